//! Files that are moved, emptied, removed or left behind, before a server starts and while it runs.

use super::*;
use std::time::{Duration, Instant};

/// Far longer than anything here takes.
const LONG: Duration = Duration::from_secs(60);

fn log_of(directory: &TempDir) -> PathBuf {
    directory.path().join(format!("{DATA_FILE}-wal"))
}

/// A directory in which a server kept a robot and has ended in order.
fn used() -> TempDir {
    let directory = tempdir().unwrap();
    open(&directory).commit(vec![robot("r", 1)]).unwrap();
    directory
}

fn names(store: &SqliteStore) -> Vec<String> {
    store.load().unwrap().robots.into_iter().map(|robot| robot.id.to_string()).collect()
}

/// Guards against: a data file that a crash of the machine has emptied is taken for a new one, and every robot is gone.
#[test]
fn a_store_that_is_gone_is_not_begun_anew() {
    for length in [None, Some(0), Some(1), Some(100), Some(511)] {
        let directory = used();
        let whole = fs::read(file(&directory)).unwrap();
        match length {
            None => fs::remove_file(file(&directory)).unwrap(),
            Some(length) => fs::write(file(&directory), &whole[..length]).unwrap(),
        }
        let refused = SqliteStore::open(directory.path());
        let Err(error @ OpenError::Lost { .. }) = refused else {
            panic!("{length:?}: {refused:?}")
        };
        let said = message(error);
        assert!(said.contains(DATA_FILE) && said.contains("put a backup in its place"), "{said}");
        let left = fs::read(file(&directory)).ok();
        assert_eq!(left.map(|left| left.len()), length, "it is not touched");
        assert!(backup(directory.path(), &directory.path().join("copy")).is_err());
        fs::write(file(&directory), &whole).unwrap();
        assert_eq!(names(&open(&directory)), ["r"], "put back, it opens");
        // To begin anew is to remove all of it.
        fs::remove_file(file(&directory)).unwrap();
        fs::remove_file(directory.path().join(LOCK_FILE)).unwrap();
        assert_eq!(names(&open(&directory)), [""; 0]);
    }
}

/// Guards against: SQLite removes the log of a file that is missing, and with it what was acknowledged last.
#[test]
fn a_log_without_its_file_is_not_thrown_away() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.commit(vec![robot("r", 1)]).unwrap();
    // As a kill leaves them, and without the lock file.
    let killed = tempdir().unwrap();
    fs::copy(log_of(&directory), log_of(&killed)).unwrap();
    let log = fs::read(log_of(&killed)).unwrap();
    for create in [false, true] {
        if create {
            fs::write(file(&killed), "").unwrap();
        }
        let refused = SqliteStore::open(killed.path());
        assert!(matches!(&refused, Err(OpenError::Lost { .. })), "{refused:?}");
        assert!(message(refused.unwrap_err()).contains("umwelt.sqlite-wal"));
        assert_eq!(fs::read(log_of(&killed)).unwrap(), log, "it is not touched");
    }
    fs::copy(file(&directory), file(&killed)).unwrap();
    assert_eq!(names(&open(&killed)), ["r"]);
}

#[test]
fn what_a_kill_leaves_of_a_file_that_was_never_used_is_begun_anew() {
    let directory = tempdir().unwrap();
    fs::write(file(&directory), "").unwrap();
    fs::write(directory.path().join(LOCK_FILE), "").unwrap();
    assert_eq!(names(&open(&directory)), [""; 0]);
}

#[test]
fn a_backup_in_place_of_what_is_gone_opens() {
    let directory = used();
    let aside = tempdir().unwrap();
    backup(directory.path(), &file(&aside)).unwrap();
    fs::write(file(&directory), "").unwrap();
    assert!(SqliteStore::open(directory.path()).is_err());
    fs::copy(file(&aside), file(&directory)).unwrap();
    assert_eq!(names(&open(&directory)), ["r"]);
}

/// Guards against: SQLite goes on writing to a file that has no name any more, and all of it is lost.
#[test]
fn a_file_that_was_moved_away_is_not_written_to() {
    for ending in ["sqlite", "sqlite-wal", "sqlite-shm", "lock"] {
        let directory = tempdir().unwrap();
        let store = open(&directory);
        let (file, aside) =
            (directory.path().join(format!("umwelt.{ending}")), directory.path().join("aside"));
        fs::rename(&file, &aside).unwrap();
        for replaced in [false, true] {
            let Err(StoreError::Unavailable(said)) = store.commit(vec![robot("r", 1)]) else {
                panic!("{ending} is gone")
            };
            assert!(said.contains("put it back"), "{said}");
            assert!(said.contains(file.to_str().unwrap()), "{said}");
            assert_eq!(store.probe(), store.commit(vec![robot("s", 1)]), "{replaced}");
            // Another file of that name is not the one.
            fs::copy(&aside, &file).unwrap();
        }
        fs::rename(&aside, &file).unwrap();
        assert_eq!(store.commit(vec![robot("r", 1)]), Ok(()), "{ending}");
        assert_eq!(names(&store), ["r"], "{ending}: what was refused is not there");
    }
}

/// Guards against: what was acknowledged is in a log that has no name any more, and goes with the process.
#[test]
fn a_log_that_is_removed_takes_nothing_with_it() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.commit(vec![robot("r", 1)]).unwrap();
    fs::remove_file(log_of(&directory)).unwrap();
    assert!(matches!(store.probe(), Err(StoreError::Unavailable(_))));
    // A process that is killed now leaves this.
    let killed = tempdir().unwrap();
    fs::copy(file(&directory), file(&killed)).unwrap();
    assert_eq!(names(&open(&killed)), ["r"]);
    drop(store);
    assert_eq!(names(&open(&directory)), ["r"]);
}

#[test]
fn a_store_is_tidied_up_into_one_file() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.commit(vec![robot("r", 1)]).unwrap();
    let log = log_of(&directory);
    assert!(fs::metadata(&log).unwrap().len() > 0);
    store.settle().unwrap();
    assert_eq!(fs::metadata(&log).unwrap().len(), 0);
    assert_eq!(store.load().unwrap().robots.len(), 1);
}

#[test]
fn the_log_goes_into_the_file_once_nothing_is_written() {
    let directory = tempdir().unwrap();
    let idle = Duration::from_millis(20);
    let store = SqliteStore::open_with(directory.path(), None, idle).unwrap();
    for number in 0..40 {
        store.commit(vec![robot(&format!("r{number}"), 1)]).unwrap();
    }
    let begun = Instant::now();
    while fs::metadata(log_of(&directory)).unwrap().len() > 0 {
        assert!(begun.elapsed() < LONG, "the log stays");
        std::thread::yield_now();
    }
    let copied = tempdir().unwrap();
    fs::copy(file(&directory), file(&copied)).unwrap();
    assert_eq!(names(&open(&copied)).len(), 40, "the file alone holds everything");
    assert_eq!(store.commit(vec![robot("later", 1)]), Ok(()));
}

/// Guards against: a log that grows for as long as robots drive.
#[test]
fn the_log_stays_small_while_much_is_written() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    let mut largest = 0;
    for number in 0..60 {
        store.commit(vec![large(1 + number % 3)]).unwrap();
        largest = largest.max(fs::metadata(log_of(&directory)).unwrap().len());
    }
    assert!(largest < 8 << 20, "{largest} bytes");
}

/// Guards against: one byte of the log changes, and SQLite drops what was acknowledged after it, without a word.
#[test]
fn a_byte_that_changes_in_the_log_is_noticed_before_its_last_transaction() {
    const COMMITS: usize = 12;
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.settle().unwrap();
    let mut ends = Vec::new();
    for number in 0..COMMITS {
        store.commit(vec![robot(&format!("r{number}"), 1)]).unwrap();
        ends.push(fs::metadata(log_of(&directory)).unwrap().len() as usize);
    }
    let (bytes, log) = (fs::read(file(&directory)).unwrap(), fs::read(log_of(&directory)).unwrap());
    let killed = |log: &[u8]| {
        let killed = tempdir().unwrap();
        fs::write(file(&killed), &bytes).unwrap();
        fs::write(log_of(&killed), log).unwrap();
        killed
    };
    assert_eq!(names(&open(&killed(&log))).len(), COMMITS);
    let last = ends[COMMITS - 2];
    for at in (0..log.len()).step_by(log.len() / 97) {
        let mut changed = log.clone();
        changed[at] ^= 0x10;
        let killed = killed(&changed);
        let opened = SqliteStore::open(killed.path());
        if at < last {
            assert!(matches!(&opened, Err(OpenError::DamagedLog { .. })), "byte {at}: {opened:?}");
            let said = message(opened.unwrap_err());
            assert!(said.contains("-wal") && said.contains("--remove-damaged"), "{said}");
            assert!(check(killed.path(), false).unwrap().to_string().contains("umwelt.sqlite-wal"));
        } else {
            // It looks as if the power had gone while it was written.
            assert!(names(&opened.unwrap()).len() >= COMMITS - 1, "byte {at}");
        }
    }
    // Going on without what comes after: those before are kept.
    let mut changed = log.clone();
    changed[ends[5] + 100] ^= 1;
    let killed = killed(&changed);
    assert!(check(killed.path(), true).unwrap().removed);
    assert_eq!(names(&open(&killed)).len(), 6);
}

/// A power cut in the midst of a write leaves less than all of it, and no damage.
#[test]
fn a_log_that_ends_anywhere_is_no_damage() {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    store.settle().unwrap();
    store.commit(vec![large(1)]).unwrap();
    let first = fs::metadata(log_of(&directory)).unwrap().len() as usize;
    store.commit(vec![large(2), robot("r", 1)]).unwrap();
    let (bytes, log) = (fs::read(file(&directory)).unwrap(), fs::read(log_of(&directory)).unwrap());
    for length in (first..log.len()).step_by((log.len() - first) / 7) {
        for zeros in [0, 5000] {
            let killed = tempdir().unwrap();
            fs::write(file(&killed), &bytes).unwrap();
            let torn = [&log[..length], &vec![0; zeros]].concat();
            fs::write(log_of(&killed), torn).unwrap();
            assert_eq!(open(&killed).load().unwrap().jobs.len(), 1, "{length} and {zeros} zeros");
        }
    }
}
