mod backups;
mod damage;
mod files;
mod writes;

use super::schema::{MIGRATIONS, Unusable};
use super::*;
use crate::store::document::robot as document;
use crate::store::tests::{evolution, id, id_of, record, saved};
use crate::store::{Change, Posterior, StoredKind};
use rusqlite::Connection;
use std::fs;
use std::path::PathBuf;
use tempfile::{TempDir, tempdir};
use umwelt_core::controller::STATE_VERSION;

fn open(directory: &TempDir) -> SqliteStore {
    SqliteStore::open(directory.path()).unwrap()
}

/// The connection that writes, to tables as of `migrations`.
fn writer_of(
    directory: &TempDir,
    migrations: &[&str],
) -> Result<(Opened, Connection), schema::Unusable> {
    let opened = open::take(directory.path()).unwrap();
    let connection = opened.writer(migrations)?;
    Ok((opened, connection))
}

fn file(directory: &TempDir) -> PathBuf {
    directory.path().join(DATA_FILE)
}

/// A connection beside the store, as another program has one.
fn beside(directory: &TempDir) -> Connection {
    Connection::open(file(directory)).unwrap()
}

fn robot(name: &str, revision: u64) -> Change {
    Change::PutRobot(id(name), Box::new(record(revision)))
}

fn learned(name: &str, revision: u64) -> Change {
    let saved = saved(&record(revision), 2);
    Change::PutPosterior(id(name), Box::new(Posterior { revision, saved }))
}

/// A change that takes many pages.
fn large(number: u64) -> Change {
    Change::PutJob(evolution(number, &"x".repeat(400_000)))
}

fn message(error: impl std::fmt::Display) -> String {
    error.to_string()
}

#[test]
fn what_is_acknowledged_is_there_when_it_is_opened_again() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.commit(vec![robot("r", 1), learned("r", 1), Change::PutJob(evolution(7, "x"))]).unwrap();
    let before = store.load().unwrap();
    drop(store);
    let after = open(&directory).load().unwrap();
    assert_eq!(after, before);
    assert!(after.robots[0].saved.is_some() && after.last_number(StoredKind::Evolution) == 7);
}

/// Guards against: an acknowledgement before the disk has it. A kill does not show it, only a power cut would.
#[test]
fn every_commit_is_synced_to_the_disk() {
    let directory = tempdir().unwrap();
    let (_opened, connection) = writer_of(&directory, MIGRATIONS).unwrap();
    let pragma = |name| connection.pragma_query_value(None, name, |row| row.get::<_, i64>(0));
    assert_eq!(pragma("synchronous"), Ok(2), "full");
    assert_eq!(pragma("foreign_keys"), Ok(1));
    let mode = connection.pragma_query_value(None, "journal_mode", |row| row.get::<_, String>(0));
    assert_eq!(mode.unwrap(), "wal");
}

#[test]
fn a_commit_is_all_or_nothing() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.commit(vec![robot("r", 1)]).unwrap();
    let before = store.load().unwrap();
    let impossible = Change::PutRobot(id("s"), Box::new(record(u64::MAX)));
    for changes in [
        vec![robot("new", 1), impossible.clone()],
        vec![Change::DeleteRobot(id("r")), impossible.clone(), robot("t", 1)],
    ] {
        assert!(matches!(store.commit(changes), Err(StoreError::Rejected(_))));
        assert_eq!(store.load().unwrap(), before);
    }
}

/// Guards against: JSON has no infinity, so what was acknowledged could never be read again.
#[test]
fn what_could_not_be_read_back_is_rejected() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    let mut endless = record(1);
    endless.told.settings.variance.position = f64::INFINITY;
    let put = store.commit(vec![Change::PutRobot(id("r"), Box::new(endless))]);
    assert!(matches!(put, Err(StoreError::Rejected(_))), "{put:?}");
    assert_eq!(store.load().unwrap().robots, []);
}

/// Requests that wait while the writer is held up are written together: one that cannot be made fails alone.
#[test]
fn of_a_group_only_the_bad_one_fails() {
    let directory = tempdir().unwrap();
    let (opened, connection) = writer_of(&directory, MIGRATIONS).unwrap();
    let results = writer::write_together(
        connection,
        &opened.file,
        vec![
            Request::Commit(vec![robot("a", 1)]),
            Request::Commit(vec![robot("lost", 1), robot("b", u64::MAX)]),
            Request::Probe,
            Request::Commit(vec![robot("c", 1)]),
        ],
    );
    let is_ok: Vec<_> = results.iter().map(Result::is_ok).collect();
    assert_eq!(is_ok, [true, false, true, true], "{results:?}");
    drop(opened);
    let names: Vec<_> =
        open(&directory).load().unwrap().robots.into_iter().map(|robot| robot.id).collect();
    assert_eq!(names, [id("a"), id("c")]);
}

/// Guards against: a change that is too large for what is left of the disk takes the others of its group with it.
#[test]
fn a_full_disk_refuses_what_does_not_fit_and_keeps_the_rest() {
    let directory = tempdir().unwrap();
    let (opened, connection) = writer_of(&directory, MIGRATIONS).unwrap();
    connection.pragma_update(None, "max_page_count", 60).unwrap();
    let results = writer::write_together(
        connection,
        &opened.file,
        vec![
            Request::Commit(vec![robot("a", 1)]),
            Request::Commit(vec![robot("lost", 1), large(1)]),
            Request::Commit(vec![robot("b", 1)]),
        ],
    );
    assert_eq!((&results[0], &results[2]), (&Ok(()), &Ok(())));
    let Err(StoreError::Unavailable(said)) = &results[1] else { panic!("{results:?}") };
    assert!(said.contains("full") && said.contains("free some space"), "{said}");
    drop(opened);
    let robots = open(&directory).load().unwrap().robots;
    assert_eq!(robots.iter().map(|robot| robot.id.as_str()).collect::<Vec<_>>(), ["a", "b"]);
}

#[test]
fn a_store_whose_disk_was_full_works_again_once_there_is_room() {
    let directory = tempdir().unwrap();
    let store = SqliteStore::open_with(directory.path(), Some(250), IDLE).unwrap();
    store.commit(vec![large(1), robot("r", 1)]).unwrap();
    let before = store.load().unwrap();
    for _ in 0..2 {
        let refused = store.commit(vec![robot("s", 1), large(2), large(3)]);
        assert!(matches!(refused, Err(StoreError::Unavailable(_))), "{refused:?}");
        assert_eq!(store.load().unwrap(), before);
    }
    store.commit(vec![Change::DeleteJob(id_of(StoredKind::Evolution, 1))]).unwrap();
    assert_eq!(store.commit(vec![large(2), robot("s", 1)]), Ok(()));
    assert_eq!(store.probe(), Ok(()));
}

#[test]
fn a_store_that_another_program_holds_says_so_and_works_again_afterwards() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    let other = beside(&directory);
    other.execute_batch("BEGIN IMMEDIATE").unwrap();
    let Err(StoreError::Unavailable(said)) = store.probe() else { panic!("it is held") };
    assert!(said.contains("another program holds it"), "{said}");
    assert_eq!(store.load().unwrap().robots, [], "reading works all the same");
    other.execute_batch("ROLLBACK").unwrap();
    assert_eq!(store.commit(vec![robot("r", 1)]), Ok(()));
}

#[test]
fn a_second_server_on_the_same_directory_is_refused() {
    let directory = tempdir().unwrap();
    let first = open(&directory);
    let refused = SqliteStore::open(directory.path());
    assert!(matches!(&refused, Err(OpenError::InUse { .. })), "{refused:?}");
    assert!(message(refused.unwrap_err()).contains("in use by another umwelt-server"));
    drop(first);
    open(&directory);
}

#[test]
fn a_file_that_is_no_data_file_is_refused_and_not_touched() {
    let directory = tempdir().unwrap();
    beside(&directory).execute_batch("CREATE TABLE theirs (x); PRAGMA user_version = 1").unwrap();
    let before = fs::read(file(&directory)).unwrap();
    let refused = SqliteStore::open(directory.path());
    assert!(matches!(refused, Err(OpenError::Foreign { .. })), "{refused:?}");
    assert_eq!(fs::read(file(&directory)).unwrap(), before);
}

#[test]
fn a_file_of_a_newer_program_is_refused_and_not_touched() {
    let directory = tempdir().unwrap();
    drop(open(&directory));
    let newer = MIGRATIONS.len() + 1;
    beside(&directory).pragma_update(None, "user_version", newer as i64).unwrap();
    let before = fs::read(file(&directory)).unwrap();
    let refused = SqliteStore::open(directory.path()).unwrap_err();
    let OpenError::Newer { version, known, .. } = refused else { panic!("{refused:?}") };
    assert_eq!((version, known), (newer, MIGRATIONS.len()));
    assert!(message(refused).contains("use the newer one, or a backup"));
    assert_eq!(fs::read(file(&directory)).unwrap(), before);
}

/// A file as the first released program writes it, by hand: it opens, and means the same for ever.
#[test]
fn a_database_of_version_1_opens() {
    let directory = tempdir().unwrap();
    let by_hand = include_str!("version-1-example.sql");
    beside(&directory).execute_batch(&format!("{}{by_hand}", MIGRATIONS[0])).unwrap();
    let aside = tempdir().unwrap();
    let made = backup(directory.path(), &file(&aside)).unwrap();
    assert_eq!((made.evolutions, made.generations, made.comparisons), (1, 1, 0));
    assert_eq!(schema::version(&beside(&aside), 1), Ok(Some(1)), "as old as what it is made of");
    let store = open(&directory);
    let contents = store.load().unwrap();
    let rover = &contents.robots[0];
    assert_eq!(rover.id, id("rover-7"));
    assert_eq!((rover.record.revision, rover.record.told.settings.slots), (12, 7));
    assert_eq!(rover.record.told.prior.as_deref(), Some("wet-floor"));
    assert_eq!(rover.record.task.as_ref().map(|task| task.waypoints.len()), Some(2));
    assert!(rover.record.stopped);
    assert_eq!(rover.saved, None, "what it learned was of state version 1: it learns anew");
    assert_eq!(contents.priors[0].name, "wet-floor");
    assert!(matches!(
        &contents.priors[0].source,
        umwelt_api::prior::Source::Evolution { seed: 18_446_744_073_709_551_615, .. }
    ));
    assert_eq!(contents.environments[0].body, "{\"version\":1}");
    // Evolutions became one kind of job in version 2.
    let [evolution] = &contents.jobs[..] else { panic!("{:?}", contents.jobs) };
    assert_eq!(evolution.id, id_of(StoredKind::Evolution, 3));
    assert_eq!((evolution.finished, evolution.body.as_str()), (true, "{\"version\":1}"));
    assert_eq!(store.parts(evolution.id, 0, 9).unwrap()[0].body, "{\"generation\":0}");
    assert_eq!(store.checkpoint(evolution.id).unwrap().as_deref(), Some("{\"checkpoint\":1}"));
    assert_eq!(StoredKind::ALL.map(|kind| contents.last_number(kind)), [5, 0]);
}

/// Guards against: the form of what robots learn changes under the same version, and all of them forget.
#[test]
fn the_form_of_what_was_learned_is_that_of_its_version() {
    let (version, example) = (3, include_str!("saved-example.json").trim_end());
    assert_eq!(version, STATE_VERSION, "put the new form into saved-example.json");
    let saved = document::saved(example).unwrap_or_else(|why| panic!("raise STATE_VERSION: {why}"));
    assert_eq!(saved.belief().link.estimate().samples, 2);
    assert_eq!(document::of_saved(&saved).unwrap(), example, "raise STATE_VERSION");
}

/// An older file is brought up to date step by step, and a step that fails leaves it as it was.
#[test]
fn migrations_lead_forward_whole_or_not_at_all() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.commit(vec![robot("r", 1)]).unwrap();
    drop(store);
    let next = "ALTER TABLE robots ADD COLUMN colour TEXT NOT NULL DEFAULT 'grey'";
    let broken = [MIGRATIONS, &[next, "CREATE TABLE half (x); CREATE TABLE robots (x)"]].concat();
    assert!(writer_of(&directory, &broken).is_err());
    let at = schema::version(&beside(&directory), 9);
    assert_eq!(at, Ok(Some(MIGRATIONS.len() + 1)), "the step that worked stays");
    let half = beside(&directory).prepare("SELECT * FROM half").map(drop);
    assert!(half.is_err(), "of the one that failed there is nothing");

    let mended = [MIGRATIONS, &[next, "CREATE TABLE whole (x)"]].concat();
    let (_opened, connection) = writer_of(&directory, &mended).unwrap();
    let colour = "SELECT colour FROM robots WHERE id = 'r'";
    assert_eq!(connection.query_row(colour, [], |row| row.get(0)), Ok("grey".to_owned()));
    let refused = schema::version(&connection, MIGRATIONS.len());
    assert_eq!(refused, Err(Unusable::Newer { version: MIGRATIONS.len() + 2 }));
}

#[test]
fn a_damaged_file_is_refused_and_says_what_to_do() {
    type Damage = fn(&mut Vec<u8>);
    let damages: [(&str, Damage); 3] = [
        ("no database at all", |bytes| bytes.fill(b'x')),
        ("a page in the middle", |bytes| {
            let half = bytes.len() / 2;
            bytes[half..half + 4096].fill(0xff);
        }),
        ("cut off", |bytes| bytes.truncate(bytes.len() / 2)),
    ];
    for (what, damage) in damages {
        let directory = tempdir().unwrap();
        let store = open(&directory);
        for number in 0..40 {
            store.commit(vec![robot(&format!("r{number}"), 1)]).unwrap();
        }
        drop(store);
        let mut bytes = fs::read(file(&directory)).unwrap();
        damage(&mut bytes);
        fs::write(file(&directory), bytes).unwrap();
        let refused = SqliteStore::open(directory.path());
        let Err(error @ OpenError::Damaged { .. }) = refused else { panic!("{what}: {refused:?}") };
        let said = message(error);
        assert!(said.contains(DATA_FILE) && said.contains("put a backup in its place"), "{said}");
    }
}

/// Changes rows as this program does, so that their checksums are right.
fn rewrite(directory: &TempDir, table: &str, sql: &str) {
    let table = tables::ALL.into_iter().find(|it| it.name == table).unwrap();
    let (name, columns) = (table.name, table.columns());
    let connection = open::writable(&file(directory)).unwrap();
    connection.execute_batch(sql).unwrap();
    let checksum = format!("UPDATE {name} SET checksum = row_checksum('{name}', {columns})");
    connection.execute_batch(&checksum).unwrap();
}

/// Guards against a program that calls damage what it only cannot read, and does not start for it.
#[test]
fn a_row_that_is_whole_and_cannot_be_read_is_no_damage() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.commit(vec![robot("r", 5), learned("r", 5), robot("s", 2)]).unwrap();
    for (body, why, written_by) in [
        (r#"{"version": 1}"#, "missing field", None),
        (r#"{"version": 9, "program": "0.9.0"}"#, "its form is of version 9", Some("0.9.0")),
    ] {
        let set = format!("UPDATE robots SET body = '{body}' WHERE id = 'r'");
        rewrite(&directory, "robots", &set);
        let Contents { robots, unreadable, .. } = store.load().unwrap();
        assert_eq!(robots.iter().map(|robot| robot.id.as_str()).collect::<Vec<_>>(), ["s"]);
        let [unreadable] = &unreadable[..] else { panic!("{unreadable:?}") };
        assert_eq!((unreadable.name.as_str(), unreadable.revision), ("r", 5));
        assert!(unreadable.why.starts_with(why), "{unreadable:?}");
        assert_eq!(unreadable.written_by.as_deref(), written_by);
        assert_eq!(check(directory.path(), false).unwrap().damaged, []);
    }
    store.commit(vec![robot("r", 7)]).unwrap();
    assert_eq!(store.load().unwrap().unreadable, [], "another one is in its place");
}

/// Guards against: a new version of what robots learn keeps the server from starting.
#[test]
fn what_was_learned_in_another_version_is_left_out_and_the_robot_stays() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.commit(vec![robot("r", 1), learned("r", 1)]).unwrap();
    let set = format!("UPDATE posteriors SET version = {}, body = '{{}}'", STATE_VERSION + 1);
    rewrite(&directory, "posteriors", &set);
    let robots = store.load().unwrap().robots;
    assert_eq!((robots.len(), &robots[0].saved), (1, &None));
    assert!(!robots[0].record.stopped, "nothing is damaged");
}
