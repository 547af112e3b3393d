//! What is kept of evolutions.

use super::*;
use crate::jobs::{CHECKPOINT, Checkpoint, PART, Record, State, Unusable, part_body, read_part};
use crate::store::document::Unreadable;
use crate::store::document::tests::{golden, one_field_less};
use umwelt_lab::evolution::{Generation, STATE_VERSION, Spread};

type Kept = Checkpoint<Evolution>;

fn checkpoint() -> Kept {
    let settings = EvolutionSettings::preset("quick").unwrap();
    let work = Evolution::new(settings).unwrap();
    let latest = Some(Spread { best: 0.1 + 0.2, mean: 1.0 / 3.0 });
    Checkpoint { work, latest, elapsed: 12.5 }
}

fn read(body: &str) -> Result<Kept, Unusable> {
    Kept::read(body, &EvolutionSettings::preset("quick").unwrap())
}

#[test]
fn a_checkpoint_comes_back_bit_for_bit() {
    let checkpoint = checkpoint();
    assert_eq!(read(&checkpoint.body().unwrap()), Ok(checkpoint));
}

/// Guards against a state of tomorrow's program read as if it were today's.
#[test]
fn another_version_is_told_from_damage() {
    let of_state = |found| Err(Unusable::State { found, current: STATE_VERSION });
    let body = checkpoint().body().unwrap();
    let later = body.replacen("\"version\":3", "\"version\":4", 1);
    let newer = |program: Option<&str>| {
        let program = program.map(str::to_owned);
        Err(Unusable::Unreadable(Unreadable::Newer { version: 4, known: 3, program }))
    };
    assert_eq!(read(&later), newer(Some(env!("CARGO_PKG_VERSION"))));
    assert_eq!(read(r#"{"version":4,"what":0}"#), newer(None));
    let state = body.replace("\"work\":{\"version\":1", "\"work\":{\"version\":7");
    assert_ne!(state, body);
    assert_eq!(read(&state), of_state(7));
    for (version, name) in [(1, "evolution"), (2, "work")] {
        let foreign = format!(r#"{{"version":{version},"content":{{"{name}":{{"version":9}}}}}}"#);
        assert_eq!(read(&foreign), of_state(9));
    }
    for damaged in ["", "{", "{}", r#"{"version":2}"#, r#"{"version":2,"content":{}}"#, &body[..90]]
    {
        assert!(
            matches!(read(damaged), Err(Unusable::Unreadable(Unreadable::Meaningless { .. }))),
            "{damaged}"
        );
    }
}

/// Guards against an infinity, which JSON has not, so that what was acknowledged could never be read again.
#[test]
fn a_record_that_would_not_be_read_back_is_refused() {
    let checkpoint = checkpoint();
    let mut record = Record {
        state: State::Queued,
        interrupted: 0,
        created_unix: 1,
        settings: checkpoint.work.settings().clone(),
        own: "meadow".parse().unwrap(),
        key: None,
        request: "hash".to_owned(),
        error: None,
        report: None,
        reached: checkpoint.reached(),
    };
    let id = JobId { kind: StoredKind::Evolution, number: 3 };
    let stored = record.stored(id).unwrap();
    assert_eq!(Record::read(&stored.body).as_ref(), Ok(&record));
    assert!(!stored.finished);
    record.reached.elapsed = f64::INFINITY;
    assert!(record.stored(id).is_err());
}

#[test]
fn records_of_every_version_mean_what_they_meant() {
    let write = |record: &Record<Evolution>| {
        record.stored(JobId { kind: StoredKind::Evolution, number: 1 }).unwrap().body
    };
    for name in ["running", "least"] {
        golden(&kept::FORM, &format!("jobs/evolution/golden/{name}"), 2, Record::read, write);
    }
    let newest = golden(&kept::FORM, "jobs/evolution/golden/record", 1, Record::read, write);
    // Nothing else says where a job stands, what its champion is called, or its result.
    let essential = [
        "state",
        "own",
        "settings",
        "environments",
        "name",
        "slip",
        "link",
        "rtt/",
        "controller",
        "drive",
        "prior",
        "task",
        "waypoints/",
        "report/",
        "latest/",
    ];
    one_field_less(&kept::FORM, &newest, &essential, Record::<Evolution>::read);
}

#[test]
fn generations_and_checkpoints_of_every_version_mean_what_they_meant() {
    golden(&PART, "jobs/evolution/golden/generation", 1, read_part::<Generation>, |generation| {
        part_body(generation).unwrap()
    });
    let record = Record::<Evolution>::read(include_str!("golden/running-2.json")).unwrap();
    let read = |body: &str| {
        Kept::read(body, &record.settings)
            .map_err(|why| Unreadable::Meaningless { what: why.to_string(), program: None })
    };
    let newest = golden(&CHECKPOINT, "jobs/evolution/golden/checkpoint", 2, read, |checkpoint| {
        checkpoint.body().unwrap()
    });
    let work = read(&newest).unwrap().work;
    assert!(work.episodes() > 0 && !work.batch().is_empty());
}
