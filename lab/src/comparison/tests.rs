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
        let evaluations: Vec<_> = comparison
            .batch()
            .iter()
            .map(|it| Comparison::evaluate(comparison.settings(), it))
            .collect();
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

/// Guards against: a contender that meets other luck than the others.
#[test]
fn every_contender_drives_the_same_seeds() {
    let comparison = small("floor-change", &["statistic/1", "oracle/1", "fixed-bad/20"], 3);
    assert_eq!(comparison.stage(), Stage::Trials { done: 0 });
    let batch = comparison.batch();
    assert_eq!(batch.len(), 3 * 2 * 3);
    for together in batch.chunks_exact(3) {
        assert!(together.iter().all(|it| it.seed == together[0].seed));
    }
    let seeds: BTreeSet<_> = batch.iter().map(|it| it.seed).collect();
    assert_eq!(seeds.len(), 2 * 3);
}

#[test]
fn a_comparison_taken_up_again_comes_to_the_same() {
    let whole = run(small("thesis", &["statistic/20", "bayesian/20"], 2));
    let mut again = small("thesis", &["statistic/20", "bayesian/20"], 2);
    while again.report().is_none() {
        let text = serde_json::to_string(again.state()).unwrap();
        let state = serde_json::from_str(&text).unwrap();
        again = Comparison::resume(again.settings().clone(), state).unwrap();
        let evaluations: Vec<_> =
            again.batch().iter().map(|it| Comparison::evaluate(again.settings(), it)).collect();
        assert!(again.tell(&evaluations[1..]).is_err());
        again.tell(&evaluations).unwrap();
    }
    assert_eq!(again, whole);
    assert_eq!(whole.episodes(), whole.total_episodes());
    assert!(whole.batch().is_empty());
}

/// Trials of two contenders whose luck is the same: what one differs by is said to the last digit.
#[test]
fn a_report_pairs_each_contender_with_the_statistic_of_its_horizon() {
    let contenders = ["statistic/1", "statistic/20", "bayesian/1", "bayesian/20", "oracle/1"];
    let settings = small("thesis", &contenders, 20).settings;
    let place = |label: &str| settings.contenders.iter().position(|it| it.label() == label);
    let trial =
        |time: f64, deviation: f64| Trial { arrived: true, time, deviation, ..Trial::default() };
    let cell = |factor: f64| -> Vec<Trial> {
        (1..=20).map(|i| trial(factor * f64::from(i), 0.001 * factor * f64::from(i))).collect()
    };
    let mut cells = vec![cell(1.0); 10];
    cells[place("bayesian/1").unwrap()] = cell(0.5);
    cells[place("bayesian/20").unwrap()] = cell(1.5);
    cells[place("statistic/20").unwrap()] = cell(2.0);
    cells[place("oracle/1").unwrap()][0].arrived = false;
    let report = report::report(&settings, &cells);
    assert_eq!((report.trials, report.environments.len(), report.claims.len()), (20, 2, 4));
    let entry = |label: &str| &report.environments[0].entries[place(label).unwrap()];
    let close = |one: f64, other: f64| (one - other).abs() < 1e-12;

    assert_eq!(entry("statistic/1").difference, None);
    let one = entry("bayesian/1").difference.as_ref().unwrap();
    assert_eq!(one.against, "statistic/1");
    assert!(close(one.absolute.time.mean.mean, -5.25));
    let Quantities { mean, median, p90 } = one.reduction.deviation;
    for estimate in [mean, median, p90] {
        assert!(close(estimate.low, 0.5) && close(estimate.high, 0.5), "{estimate:?}");
    }
    let twenty = entry("bayesian/20").difference.as_ref().unwrap();
    assert_eq!(twenty.against, "statistic/20");
    assert!(close(twenty.reduction.time.median.mean, 0.25));
    let claim = &report.claims[1];
    assert_eq!((claim.environment.as_str(), claim.slots), ("normal", 20));
    assert!(close(claim.deviation.mean.mean, 0.25));

    let summary = entry("statistic/1").summary;
    assert_eq!((summary.time.median.mean, summary.time.p90.mean), (10.0, 18.0));
    let arrived = entry("oracle/1").arrived;
    assert_eq!(arrived.mean, 0.95);
    // Wilson 1927, 19 of 20.
    assert!((arrived.low - 0.7639).abs() < 1e-4 && (arrived.high - 0.9911).abs() < 1e-4);
}

/// Guards against: trials that never recognised the environment left out of the median.
#[test]
fn an_environment_that_is_not_recognised_counts_as_never() {
    let settings = small("thesis", &["statistic/1"], 4).settings;
    let trial = |recognised| Trial { recognised, ..Trial::default() };
    let cell: Vec<_> = [Some(12), None, Some(3), None].map(trial).into();
    let report = report::report(&settings, &[cell.clone(), cell]);
    let recognition = report.environments[0].entries[0].recognition.unwrap();
    assert_eq!((recognition.share, recognition.median, recognition.p90), (0.5, Some(12), None));
}

#[test]
fn the_nearest_environment_is_the_one_whose_errors_surprise_least() {
    use umwelt_core::prediction::{ChannelModel, ErrorModel};
    let errors = |sd: f64, mean: f64| EnvironmentSignature {
        forward: (mean, sd * sd),
        turn: (mean, sd * sd),
    };
    let known = [errors(0.02, 0.0), errors(0.2, -0.05)];
    let believing = |mean, sd: f64| {
        let channel = ChannelModel::known(mean, sd * sd);
        ErrorModel { forward: channel, turn: channel, ..ErrorModel::PERFECT }
    };
    assert_eq!(EnvironmentSignature::nearest(&known, &believing(0.0, 0.03)), 0);
    assert_eq!(EnvironmentSignature::nearest(&known, &believing(-0.04, 0.15)), 1);
    // Twice as wide as the narrow one is farther from it than half as wide from the wide one.
    assert_eq!(EnvironmentSignature::nearest(&known, &believing(0.0, 0.1)), 1);
}

/// Guards against: what is identified on the bad link taken for what is identified on the normal one. With one slot
/// the thesis's samples distinguish them; intervals are counted for those who identify alone.
#[test]
fn statistic_recognises_the_thesis_environments() {
    let done = run(small("thesis", &["statistic/1", "fixed-normal/1"], 6));
    for environment in &done.report().unwrap().environments {
        let [fixed, statistic] = &environment.entries[..] else { panic!() };
        assert_eq!((fixed.recognition, fixed.coverage), (None, None));
        assert!(statistic.recognition.unwrap().share > 0.6, "{environment:?}");
        assert!((0.85..=1.0).contains(&statistic.coverage.unwrap().mean));
    }
}

/// Robots on floors drawn from their prior: their 90 % intervals hold 90 % to three standard deviations of 600 runs, and
/// the truth has no favourite rank. By command with more: `--example belief_calibration`.
#[test]
fn beliefs_are_honest_where_the_truth_is_drawn_from_the_prior() {
    use beliefs::{Run, Verdict, honest_prior, rank_statistic};
    const RUNS: usize = 600;
    let runs: Vec<Run> =
        (0..RUNS).map(|index| beliefs::run(honest_prior(), 1, index).unwrap()).collect();
    for channel in 0..4 {
        let of_channel = || runs.iter().map(|run| run.channels[channel]);
        for of in [(|it: &Verdict| it.mean_held) as fn(&Verdict) -> bool, |it| it.next_held] {
            let held = of_channel().filter(of).count() as f64 / RUNS as f64;
            assert!((held - 0.9).abs() < 0.037, "channel {channel}: {held}");
        }
        for rank in [(|it: Verdict| it.mean_rank) as fn(Verdict) -> usize, |it| it.sd_rank] {
            let statistic = rank_statistic(of_channel().map(rank));
            assert!(statistic < 43.8, "channel {channel}: chi-squared {statistic}");
        }
    }
    let coverage = runs.iter().map(|run| run.coverage).fold(Coverage::default(), Coverage::and);
    assert!((coverage.share().unwrap() - 0.9).abs() < 0.01, "{coverage:?}");
}

/// Guards against: a robot that gives up early, or is late, counted as fast.
#[test]
fn who_does_not_arrive_in_time_took_the_whole_of_it() {
    for limit in [5.0, 0.5] {
        let settings = small("thesis", &["statistic/20", "oracle/1"], 2).settings;
        let settings = ComparisonSettings { time_limit: limit, ..settings };
        let done = run(Comparison::new(settings).unwrap());
        for distribution in done.distributions() {
            assert!(distribution.trials.iter().all(|it| !it.arrived && it.time == limit));
        }
        let entry = &done.report().unwrap().environments[0].entries[0];
        assert_eq!((entry.arrived.mean, entry.summary.time.mean.mean), (0.0, limit));
    }
}

/// Guards against an episode that a worker in another process drives otherwise, or whose numbers come back rounded.
#[test]
fn episodes_and_evaluations_pass_as_json_bit_for_bit() {
    let methods = ["statistic/20", "bayesian/20", "oracle/1", "ekf-packet/20"];
    let mut comparison = small("thesis", &methods, 2);
    while comparison.report().is_none() {
        let (batch, settings) = (comparison.batch(), comparison.settings());
        let evaluate = |it: &Episode| Comparison::evaluate(settings, it);
        let evaluations: Vec<_> = batch.iter().map(evaluate).collect();
        let sent: Vec<Episode> =
            serde_json::from_str(&serde_json::to_string(&batch).unwrap()).unwrap();
        assert_eq!(sent, batch);
        let text = serde_json::to_string(&evaluations).unwrap();
        let read: Vec<Evaluation> = serde_json::from_str(&text).unwrap();
        assert_eq!(read, evaluations);
        assert_eq!(serde_json::to_string(&read).unwrap(), text);
        let last = batch.len() - 1;
        assert_eq!(evaluate(&sent[last]), evaluations[last]);
        comparison.tell(&evaluations).unwrap();
    }
}
