//! What is kept of comparisons.

use super::*;
use crate::jobs::{Checkpoint, Unreadable};

type Kept = Checkpoint<Comparison>;

fn begun() -> Comparison {
    let thesis = ComparisonSettings::scenario("thesis").unwrap();
    let contenders = thesis.contenders.into_iter().filter(|it| it.name == "statistic").collect();
    Comparison::new(ComparisonSettings { contenders, trials: 600, ..thesis }).unwrap()
}

/// Tells a batch: some of it driven, and again and again the same.
fn tell(work: &mut Comparison, seen: &mut Vec<Evaluation>) -> Told<Comparison> {
    let batch = work.batch();
    seen.extend(batch.iter().take(7).map(|job| work.evaluate(job)));
    let evaluations: Vec<_> = seen.iter().cycle().take(batch.len()).copied().collect();
    Work::tell(work, &evaluations).unwrap()
}

/// The bug to fear: trials that come back rounded or not at all, so that a restart changes the report.
#[test]
fn a_comparison_comes_back_bit_for_bit_at_every_stage() {
    let (mut work, mut stages, mut seen) = (begun(), Vec::new(), Vec::new());
    while work.report().is_none() {
        stages.push(work.stage());
        let checkpoint = Checkpoint { work, latest: None, elapsed: 12.5 };
        let read = Kept::read(&checkpoint.body().unwrap()).unwrap();
        assert_eq!(read, checkpoint);
        work = read.work;
        let told = tell(&mut work, &mut seen);
        // Nothing is kept before the end, and then everything.
        let indices: Vec<_> = told.parts.iter().map(|(index, _)| *index).collect();
        let expected = if work.report().is_some() { 0..4 } else { 0..0 };
        assert_eq!(indices, expected.collect::<Vec<_>>());
        assert!(told.parts.iter().all(|(_, part)| part.trials.len() == 600));
    }
    let trials = |done| Stage::Trials { done };
    assert_eq!(stages, [Stage::Reference, trials(0), trials(500)]);
}

/// The bug to fear: a state of tomorrow's program read as if it were today's.
#[test]
fn a_state_of_another_version_is_not_taken_up() {
    let body = Checkpoint { work: begun(), latest: None, elapsed: 0.0 }.body().unwrap();
    let state = body.replace("\"work\":{\"version\":1", "\"work\":{\"version\":7");
    let refused = Err(Unreadable::State { found: 7, current: STATE_VERSION });
    assert_eq!(Kept::read(&state), refused);
}
