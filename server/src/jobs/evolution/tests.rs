//! What is kept of evolutions.

use super::*;
use crate::jobs::{Checkpoint, State, Unreadable};

type Kept = Checkpoint<Evolution>;

fn checkpoint() -> Kept {
    let settings = EvolutionSettings::preset("quick").unwrap();
    let work = Evolution::new(settings).unwrap();
    let latest = Some(Spread { best: 0.1 + 0.2, mean: 1.0 / 3.0 });
    Checkpoint { work, latest, elapsed: 12.5 }
}

#[test]
fn a_checkpoint_comes_back_bit_for_bit() {
    let checkpoint = checkpoint();
    assert_eq!(Kept::read(&checkpoint.body().unwrap()), Ok(checkpoint));
}

/// The bug to fear: a state of tomorrow's program read as if it were today's.
#[test]
fn another_version_is_told_from_damage() {
    let of_state = |found| Err(Unreadable::State { found, current: STATE_VERSION });
    let body = checkpoint().body().unwrap();
    let later = body.replacen("\"version\":2", "\"version\":3", 1);
    assert_eq!(Kept::read(&later), Err(Unreadable::Version(3)));
    assert_eq!(Kept::read(r#"{"version":3,"what":0}"#), Err(Unreadable::Version(3)));
    let state = body.replace("\"work\":{\"version\":1", "\"work\":{\"version\":7");
    assert_ne!(state, body);
    assert_eq!(Kept::read(&state), of_state(7));
    for name in ["work", "evolution"] {
        let foreign = format!(r#"{{"version":2,"content":{{"{name}":{{"version":9}}}}}}"#);
        assert_eq!(Kept::read(&foreign), of_state(9));
    }
    for damaged in ["", "{", "{}", r#"{"version":2}"#, r#"{"version":2,"content":{}}"#, &body[..90]]
    {
        assert!(matches!(Kept::read(damaged), Err(Unreadable::Damaged(_))), "{damaged}");
    }
}

/// The bug to fear: JSON has no infinity, so what was acknowledged could never be read again.
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
    let id = JobId { kind: JobKind::Evolution, number: 3 };
    let stored = record.stored(id).unwrap();
    assert_eq!(Record::read(&stored.body).as_ref(), Ok(&record));
    assert!(!stored.finished);
    record.reached.elapsed = f64::INFINITY;
    assert!(record.stored(id).is_err());
}
