//! Backups of a store.

use super::*;

#[test]
fn a_backup_of_a_store_in_use_is_a_data_file_of_its_own() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    let one = evolution(1, "x");
    let generation = Change::PutPart { job: one.id, index: 0, body: "g".into() };
    let first = vec![robot("r", 1), Change::PutJob(one), generation];
    store.commit(first).unwrap();
    let elsewhere = tempdir().unwrap();
    let target = file(&elsewhere);
    let made = backup(directory.path(), &target).unwrap();
    assert_eq!((made.robots, made.evolutions, made.generations), (1, 1, 1));
    assert_eq!(made.comparisons, 0);
    assert_eq!(made.bytes, fs::metadata(&target).unwrap().len());
    let then = store.load().unwrap();
    store.commit(vec![robot("later", 1)]).unwrap();
    let copy = open(&elsewhere);
    assert_eq!(copy.load().unwrap(), then);
    copy.commit(vec![robot("s", 1)]).unwrap();
    assert_eq!(store.load().unwrap().robots.len(), 2, "they are two");
}

#[test]
fn a_backup_replaces_nothing_and_leaves_nothing_behind() {
    let directory = tempdir().unwrap();
    drop(open(&directory));
    let target = directory.path().join("copy");
    fs::write(&target, "precious").unwrap();
    assert!(matches!(backup(directory.path(), &target), Err(BackupError::Exists(_))));
    assert_eq!(fs::read(&target).unwrap(), b"precious");
    let nowhere = directory.path().join("no/such/place");
    assert!(matches!(backup(directory.path(), &nowhere), Err(BackupError::Target { .. })));
    let empty = tempdir().unwrap();
    let missing = backup(empty.path(), &target.with_extension("2"));
    assert!(matches!(missing, Err(BackupError::Source(OpenError::Missing { .. }))));
    let mut names: Vec<_> =
        fs::read_dir(directory.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.retain(|name| !name.to_string_lossy().starts_with("umwelt."));
    assert_eq!(names, ["copy"]);
    assert_eq!(fs::read_dir(empty.path()).unwrap().count(), 0, "looking makes nothing");
}
