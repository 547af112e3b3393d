use super::*;
use std::collections::BTreeSet;

/// A comparison small enough to run in a test.
fn small(scenario: &str, methods: &[&str], trials: usize) -> Comparison {
    let settings = ComparisonSettings::scenario(scenario).unwrap();
    let is_asked = |it: &Contender| methods.contains(&it.label().as_str());
    let contenders = settings.contenders.iter().filter(|it| is_asked(it)).cloned().collect();
    Comparison::new(ComparisonSettings { contenders, trials, ..settings }).unwrap()
}

fn run(mut comparison: Comparison) -> Comparison {
    while comparison.report().is_none() {
        let evaluations: Vec<_> =
            comparison.jobs().iter().map(|job| comparison.evaluate(job)).collect();
        comparison.tell(&evaluations).unwrap();
    }
    comparison
}

#[test]
fn every_scenario_can_run_and_names_its_contenders_once() {
    for name in SCENARIOS {
        let settings = ComparisonSettings::scenario(name).unwrap();
        assert_eq!(settings.check(), Ok(()), "{name}");
        assert_eq!(settings.scenario, name);
        let labels: BTreeSet<_> = settings.contenders.iter().map(Contender::label).collect();
        assert_eq!(labels.len(), settings.contenders.len());
    }
}

/// The bug to fear: a contender that meets other luck than the others.
#[test]
fn every_contender_drives_the_same_seeds() {
    let comparison = small("floor-change", &["statistic/1", "oracle/1", "fixed-bad/20"], 3);
    assert_eq!(comparison.stage(), Stage::Trials { done: 0 });
    let jobs = comparison.jobs();
    assert_eq!(jobs.len(), 3 * 2 * 3);
    for together in jobs.chunks_exact(3) {
        assert!(together.iter().all(|job| job.seed == together[0].seed));
    }
    let seeds: BTreeSet<_> = jobs.iter().map(|job| job.seed).collect();
    assert_eq!(seeds.len(), 2 * 3);
}

#[test]
fn a_comparison_taken_up_again_comes_to_the_same() {
    let whole = run(small("thesis", &["statistic/20", "bayesian/20"], 2));
    let mut again = small("thesis", &["statistic/20", "bayesian/20"], 2);
    while again.report().is_none() {
        let text = serde_json::to_string(&again).unwrap();
        again = serde_json::from_str(&text).unwrap();
        let evaluations: Vec<_> = again.jobs().iter().map(|job| again.evaluate(job)).collect();
        assert!(again.tell(&evaluations[1..]).is_err());
        again.tell(&evaluations).unwrap();
    }
    assert_eq!(again, whole);
    assert_eq!(whole.episodes(), whole.total_episodes());
    assert!(whole.jobs().is_empty());
}
