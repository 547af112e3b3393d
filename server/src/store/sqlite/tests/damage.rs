//! Whatever changes on the disk is noticed: byte by byte, row by row.

use super::*;
use crate::store::record::{Contents, Part};
use crate::store::tests::all_kinds;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Bytes that are changed, one at a time in a file of its own.
const FLIPS: usize = 250;

/// A directory with something in every table.
fn filled() -> TempDir {
    let directory = tempdir().unwrap();
    let store = open(&directory);
    for changes in all_kinds() {
        store.commit(changes).unwrap();
    }
    for number in 0..12 {
        let name = format!("r{number}");
        store.commit(vec![robot(&name, 1), learned(&name, 1)]).unwrap();
    }
    let one = evolution(20, "x");
    let part = |index| Change::PutPart { job: one.id, index, body: "7".repeat(3000 * index) };
    let checkpoint = Change::PutCheckpoint { job: one.id, body: "8".repeat(9000) };
    let parts = (0..4).map(part);
    let all = std::iter::once(Change::PutJob(one.clone())).chain(parts).chain([checkpoint]);
    store.commit(all.collect()).unwrap();
    directory
}

/// Everything that a store keeps.
#[derive(Debug, PartialEq)]
struct Everything {
    contents: Contents,
    jobs: Vec<(Vec<Part>, Option<String>)>,
}

fn everything(store: &SqliteStore) -> Result<Everything, StoreError> {
    let contents = store.load()?;
    let of_job = |id| Ok((store.parts(id, 0, usize::MAX)?, store.checkpoint(id)?));
    let jobs = contents.jobs.iter().map(|job| of_job(job.id)).collect::<Result<_, _>>()?;
    Ok(Everything { contents, jobs })
}

/// What comes of a file with these bytes.
fn opened(bytes: &[u8]) -> Result<Everything, String> {
    let directory = tempdir().unwrap();
    fs::write(file(&directory), bytes).unwrap();
    let store = SqliteStore::open(directory.path()).map_err(message)?;
    everything(&store).map_err(message)
}

/// The same where a robot whose knowledge is damaged rests without it, as it is said.
fn with_rest_of(found: &Everything, written: &Everything) -> Everything {
    let mut contents = found.contents.clone();
    for (robot, as_written) in contents.robots.iter_mut().zip(&written.contents.robots) {
        if robot.record.stopped && robot.saved.is_none() {
            *robot = as_written.clone();
        }
    }
    Everything { contents, jobs: found.jobs.clone() }
}

/// Guards against: a waypoint of 0.25 m becomes one of 8.25 m, and no one says a word.
#[test]
fn one_byte_that_changes_anywhere_is_noticed_or_changes_nothing() {
    let directory = filled();
    let written = everything(&open(&directory)).unwrap();
    let bytes = fs::read(file(&directory)).unwrap();
    assert_eq!(opened(&bytes).as_ref(), Ok(&written));
    let digits: Vec<_> = (0..bytes.len()).filter(|at| bytes[*at].is_ascii_digit()).collect();
    let mut rng = Pcg64Mcg::seed_from_u64(8);
    let (mut noticed, mut flipped_digits) = (0, 0);
    for flip in 0..FLIPS {
        let mut changed = bytes.clone();
        let at = match flip % 3 {
            // What one reads most easily and believes most readily.
            0 => digits[rng.random_range(0..digits.len())],
            // The header of the file, and the tables' definitions.
            1 if flip % 2 == 0 => rng.random_range(0..1500),
            _ => rng.random_range(0..bytes.len()),
        };
        let is_digit = bytes[at].is_ascii_digit();
        changed[at] = match is_digit {
            true => b'0' + (bytes[at] - b'0' + rng.random_range(1..10)) % 10,
            false => bytes[at] ^ rng.random_range(1..=255),
        };
        flipped_digits += usize::from(is_digit);
        let said = format!("byte {at} from {} to {}", bytes[at], changed[at]);
        match opened(&changed) {
            Err(_) => noticed += 1,
            Ok(found) if found == written => {}
            Ok(found) => {
                noticed += 1;
                assert_eq!(with_rest_of(&found, &written), written, "{said}");
            }
        }
    }
    // The rest is in bytes that nothing uses.
    assert!(noticed > flipped_digits / 2, "{noticed} of {FLIPS}, {flipped_digits} of them digits");
}

fn damaged_by(directory: &TempDir, spoil: &str) -> String {
    beside(directory).execute_batch(spoil).unwrap();
    match everything(&open(directory)) {
        Err(StoreError::Damaged(said)) => said,
        other => panic!("{spoil}: {other:?}"),
    }
}

#[test]
fn a_damaged_row_of_any_table_is_named_with_its_key_and_a_remedy() {
    for (spoil, named) in [
        ("UPDATE robots SET body = replace(body, '0.1', '8.1') WHERE id = 'r3'", "robots r3"),
        ("UPDATE robots SET revision = 7 WHERE id = 'r3'", "robots r3"),
        ("UPDATE priors SET body = replace(body, '1.0', '1.5')", "priors evolved"),
        ("UPDATE environments SET body = '3'", "environments ice"),
        ("UPDATE environments SET name = 'fire'", "environments fire"),
        ("UPDATE jobs SET finished = 1 - finished WHERE number = 20", "jobs evolution/20"),
        ("UPDATE parts SET body = '' WHERE number = 20 AND position = 3", "parts evolution/20/3"),
        ("UPDATE checkpoints SET body = body || '8' WHERE number = 20", "checkpoints evolution/20"),
        ("UPDATE last_numbers SET number = 3 WHERE kind = 'evolution'", "last_numbers evolution"),
    ] {
        let directory = filled();
        let said = damaged_by(&directory, spoil);
        assert!(said.contains(&format!("{named} (its checksum does not match")), "{said}");
        assert!(said.contains(DATA_FILE) && said.contains("backup"), "{said}");
        assert!(said.contains("umwelt-server check --data"), "{said}");
        let checked = check(directory.path(), false).unwrap();
        assert_eq!(checked.damaged.len(), 1, "{checked}");
        assert!(checked.to_string().starts_with(named), "{checked}");
        let target = directory.path().join("copy");
        let copied = message(backup(directory.path(), &target).unwrap_err());
        assert!(copied.contains(named) && !target.exists(), "{copied}");
    }
}

/// Each row is sound in itself; only the keys say that they are not where they were.
#[test]
fn rows_that_were_swapped_are_damaged() {
    let said = damaged_by(
        &filled(),
        "CREATE TEMP TABLE two AS SELECT * FROM robots WHERE id IN ('r1', 'b'); \
         UPDATE robots SET (revision, body, checksum) = \
         (SELECT revision, body, checksum FROM two WHERE two.id <> robots.id) \
         WHERE id IN ('r1', 'b')",
    );
    assert!(said.contains("robots b (") && said.contains("robots r1 ("), "{said}");
}

/// Guards against: a robot whose progress is lost sets out for its first waypoint, by itself.
#[test]
fn a_robot_whose_knowledge_is_damaged_rests_and_the_others_drive() {
    let directory = filled();
    let spoil =
        "UPDATE posteriors SET body = replace(body, '\"mu\":0.0', '\"mu\":0.1') WHERE robot = 'r3'";
    assert_eq!(beside(&directory).execute(spoil, []), Ok(1));
    let robots = open(&directory).load().unwrap().robots;
    for robot in robots.iter().filter(|robot| robot.id.as_str().starts_with('r')) {
        let is_damaged = robot.id.as_str() == "r3";
        assert_eq!(robot.record.stopped, is_damaged, "{}", robot.id);
        assert_eq!(robot.saved.is_none(), is_damaged, "{}", robot.id);
    }
    let spoil = "PRAGMA foreign_keys = OFF; UPDATE posteriors SET robot = 's3' WHERE robot = 'r4'";
    let said = damaged_by(&directory, spoil);
    assert!(said.contains("posteriors s3"), "whose it is cannot be told: {said}");
}

/// Only what is damaged goes, and all that hangs on it.
#[test]
fn damaged_rows_can_be_removed_alone() {
    let directory = filled();
    let before = everything(&open(&directory)).unwrap();
    beside(&directory)
        .execute_batch(
            "UPDATE robots SET revision = 7 WHERE id = 'r3'; \
             UPDATE posteriors SET version = 1 WHERE robot = 'r5'; \
             UPDATE parts SET body = '' WHERE number = 20 AND position = 3; \
             UPDATE last_numbers SET number = 3 WHERE kind = 'evolution'; \
             UPDATE numbers SET value = -1",
        )
        .unwrap();
    let running = SqliteStore::open(directory.path()).unwrap();
    let refused = check(directory.path(), true);
    assert!(matches!(refused, Err(OpenError::InUse { .. })), "{refused:?}");
    drop(running);
    let checked = check(directory.path(), true).unwrap();
    assert!(checked.removed && (4..=5).contains(&checked.damaged.len()), "{checked}");
    assert_eq!(check(directory.path(), false).unwrap().damaged, []);
    let store = open(&directory);
    let contents = store.load().unwrap();
    let expected = before.contents.robots.iter().filter(|robot| robot.id.as_str() != "r3");
    for (robot, expected) in contents.robots.iter().zip(expected) {
        assert_eq!(robot.record, expected.record);
        assert_eq!(robot.saved.is_some(), expected.saved.is_some() && robot.id.as_str() != "r5");
    }
    assert_eq!(contents.priors, before.contents.priors);
    let numbers: Vec<_> = contents.jobs.iter().map(|job| job.id.number).collect();
    assert_eq!(numbers, [1, 3, 10], "the job of the damaged part is gone");
    assert_eq!(contents.last_number(StoredKind::Evolution), 3, "none that is there comes again");
    assert_eq!(store.probe(), Ok(()));
}

/// Guards against: a table's definition changes on the disk, and rows come to mean something else.
#[test]
fn tables_that_are_not_as_they_were_made_are_damage() {
    for spoil in [
        "ALTER TABLE robots RENAME COLUMN body TO bodx",
        "ALTER TABLE environments ADD COLUMN more TEXT",
        "CREATE TABLE more (x)",
    ] {
        let directory = filled();
        beside(&directory).execute_batch(spoil).unwrap();
        let refused = SqliteStore::open(directory.path());
        assert!(matches!(refused, Err(OpenError::Damaged { .. })), "{spoil}: {refused:?}");
    }
}

/// A file of before there were checksums, by hand: it opens, means the same, and has checksums from then on.
#[test]
fn a_database_of_version_2_opens_and_gets_checksums() {
    let directory = tempdir().unwrap();
    let by_hand = include_str!("version-2-example.sql");
    let all = [MIGRATIONS[0], MIGRATIONS[1], by_hand].concat();
    beside(&directory).execute_batch(&all).unwrap();
    assert_eq!(check(directory.path(), false).unwrap().damaged, [], "there is nothing to compare");
    let aside = tempdir().unwrap();
    backup(directory.path(), &file(&aside)).unwrap();
    let found = everything(&open(&directory)).unwrap();
    let Everything { contents, jobs } = &found;
    let rover = &contents.robots[0];
    assert_eq!((rover.id.as_str(), rover.record.revision), ("rover-7", 12));
    assert_eq!(rover.record.task.as_ref().map(|task| task.waypoints.len()), Some(2));
    assert_eq!(rover.saved.is_some(), STATE_VERSION == 3);
    assert_eq!(contents.priors[0].name, "wet-floor");
    assert_eq!(contents.environments[0].body, "{\"version\":1}");
    let ids: Vec<_> = contents.jobs.iter().map(|job| job.id.to_string()).collect();
    assert_eq!(ids, ["evolution-3", "comparison-4"]);
    assert_eq!(jobs[0].0[0].body, "{\"generation\":0}");
    assert_eq!((jobs[1].0[0].index, &jobs[1].1), (7, &None));
    assert_eq!(jobs[0].1.as_deref(), Some("{\"checkpoint\":1}"));
    assert_eq!(StoredKind::ALL.map(|kind| contents.last_number(kind)), [5, 4]);
    assert_eq!(everything(&open(&aside)).unwrap(), found, "so does a backup of it");
    let said = damaged_by(&directory, "UPDATE jobs SET body = '{\"version\":3}' WHERE number = 3");
    assert!(said.contains("jobs evolution/3"), "{said}");
}

/// Guards against: a file that is cut off anywhere opens as an older one, or as a new one.
#[test]
fn a_file_that_is_cut_off_is_damage_wherever_it_is_cut() {
    let directory = filled();
    let bytes = fs::read(file(&directory)).unwrap();
    let pages = bytes.len() / 4096;
    for length in [512, 1024, 4095, 4096, 8192, 4096 * (pages - 1)] {
        let cut = opened(&bytes[..length]);
        assert!(cut.is_err(), "{length} of {} bytes: {cut:?}", bytes.len());
    }
}
