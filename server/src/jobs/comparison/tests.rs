//! What is kept of comparisons.

use super::*;
use crate::jobs::{Checkpoint, PART, Record, Unusable, part_body, read_part};
use crate::store::document::tests::{golden, one_field_less};
use umwelt_lab::comparison::{Distribution, Evaluation, SCENARIOS, STATE_VERSION, Stage};
use umwelt_lab::work::BatchOutcome;

type Kept = Checkpoint<Comparison>;

fn begun() -> Comparison {
    let thesis = ComparisonSettings::scenario("thesis").unwrap();
    let contenders = thesis.contenders.into_iter().filter(|it| it.name == "statistic").collect();
    Comparison::new(ComparisonSettings { contenders, trials: 600, ..thesis }).unwrap()
}

/// Tells a batch: some of it driven, and again and again the same.
fn tell(work: &mut Comparison, seen: &mut Vec<Evaluation>) -> BatchOutcome<Comparison> {
    let batch = work.batch();
    seen.extend(batch.iter().take(7).map(|it| Comparison::evaluate(work.settings(), it)));
    let evaluations: Vec<_> = seen.iter().cycle().take(batch.len()).copied().collect();
    umwelt_lab::work::Work::tell(work, &evaluations).unwrap()
}

/// Guards against trials that come back rounded or not at all, so that a restart changes the report.
#[test]
fn a_comparison_comes_back_bit_for_bit_at_every_stage() {
    let (mut work, mut stages, mut seen) = (begun(), Vec::new(), Vec::new());
    while work.report().is_none() {
        stages.push(work.stage());
        let checkpoint = Checkpoint { work, latest: None, elapsed: 12.5 };
        let body = checkpoint.body().unwrap();
        let read = Kept::read(&body, checkpoint.work.settings()).unwrap();
        assert_eq!(read, checkpoint);
        work = read.work;
        let outcome = tell(&mut work, &mut seen);
        // Nothing is kept before the end, and then everything.
        let indices: Vec<_> = outcome.parts.iter().map(|(index, _)| *index).collect();
        let expected = if work.report().is_some() { 0..4 } else { 0..0 };
        assert_eq!(indices, expected.collect::<Vec<_>>());
        assert!(outcome.parts.iter().all(|(_, part)| part.trials.len() == 600));
    }
    let trials = |done| Stage::Trials { done };
    assert_eq!(stages, [Stage::Reference, trials(0), trials(500)]);
}

/// Guards against a state of tomorrow's program read as if it were today's.
#[test]
fn a_state_of_another_version_is_not_taken_up() {
    let body = Checkpoint { work: begun(), latest: None, elapsed: 0.0 }.body().unwrap();
    let state = body.replace("\"work\":{\"version\":1", "\"work\":{\"version\":7");
    let refused = Err(Unusable::State { found: 7, current: STATE_VERSION });
    assert_eq!(Kept::read(&state, begun().settings()), refused);
}

/// Guards against a scenario whose settings are kept as something else: a region, an outage, a start.
#[test]
fn settings_of_every_scenario_come_back() {
    for name in SCENARIOS {
        let settings = ComparisonSettings::scenario(name).unwrap();
        assert_eq!(kept::Spec::from(&settings).convert(), Ok(settings), "{name}");
    }
}

#[test]
fn records_of_every_version_mean_what_they_meant() {
    let write = |record: &Record<Comparison>| {
        record.stored(crate::store::JobId { kind: StoredKind::Comparison, number: 1 }).unwrap().body
    };
    golden(&kept::FORM, "jobs/comparison/golden/least", 2, Record::read, write);
    let newest = golden(&kept::FORM, "jobs/comparison/golden/record", 2, Record::read, write);
    // A contender and an environment have no name but their own; its result has no other meaning.
    let essential = [
        "state",
        "settings",
        "environments",
        "contenders",
        "name",
        "approach",
        "drive",
        "slip",
        "link",
        "rtt/",
        "controller",
        "prior",
        "task",
        "waypoints/",
        "report/",
    ];
    one_field_less(&kept::FORM, &newest, &essential, Record::<Comparison>::read);
}

#[test]
fn trials_of_every_version_mean_what_they_meant() {
    golden(&PART, "jobs/comparison/golden/trials", 2, read_part::<Distribution>, |trials| {
        part_body(trials).unwrap()
    });
}
