//! How comparisons are shown.

use super::*;
use crate::cli::job::noun::listed;
use crate::samples::COMPARISON;
use umwelt_api::comparison::{
    Claim, Entry, EnvironmentReport, Estimate, Finding, FindingResult, FindingSubject, Quantities,
    Recognition, Reductions, Report,
};
use umwelt_api::comparison::{Outcome, Page};

fn comparison() -> Comparison {
    serde_json::from_str(COMPARISON).unwrap()
}

fn estimate(mean: f64) -> Estimate {
    Estimate { mean, low: 0.9 * mean, high: 1.1 * mean }
}

fn quantities(median: f64, p90: f64) -> Quantities {
    Quantities { mean: estimate(9e9), median: estimate(median), p90: estimate(p90) }
}

fn entry(contender: &str, identifies: bool) -> Entry {
    let recognition = Recognition { share: 0.7, median_samples: Some(412), p90_samples: None };
    Entry {
        contender: contender.to_owned(),
        arrived: estimate(0.995),
        time_s: quantities(21.25, 170.0),
        deviation_m: quantities(0.0123, 0.1),
        recognition: identifies.then_some(recognition),
        coverage: identifies.then(|| estimate(0.912)),
        difference: None,
    }
}

/// The words of a verdict, finding by finding.
const WORDS: [&str; 3] = [
    "deviation 12.3 % smaller (95 %: 8.1 to 16.0): 16 % of the thesis's 75 %",
    "time 104 % longer (95 %: 100 to 108): the opposite of the thesis's 35 % shorter, none of it is reached",
    "not all arrived: bayesian/20 in 99.5 % of the trials, statistic/20 in 100.0 %, the others count with the time limit and as far as they got",
];

fn report() -> Report {
    let never = Recognition { share: 0.4, median_samples: None, p90_samples: None };
    let environment = |name: &str| EnvironmentReport {
        environment: name.to_owned(),
        entries: vec![
            Entry { recognition: Some(never), ..entry("statistic/20", true) },
            entry("bayesian/20", true),
            entry("no-compensation/1", false),
        ],
    };
    let reductions = |mean, low, high| Reductions {
        mean: Some(Estimate { mean, low, high }),
        median: None,
        p90: None,
    };
    let claim = Claim {
        environment: "bad-link".to_owned(),
        slots: 20,
        contender: "bayesian/20".to_owned(),
        against: "statistic/20".to_owned(),
        deviation_reduction: reductions(0.123, 0.081, 0.16),
        time_reduction: reductions(-1.04, -1.08, -1.0),
        promised_deviation: 0.75,
        promised_time: 0.35,
        arrived: 0.995,
        against_arrived: 1.0,
        verdict: String::new(),
        findings: Vec::new(),
    };
    let findings = [
        (FindingSubject::Deviation, FindingResult::Partly, WORDS[0]),
        (FindingSubject::Time, FindingResult::Opposite, WORDS[1]),
        (FindingSubject::Arrival, FindingResult::NotAllArrived, WORDS[2]),
    ];
    let finding =
        |(about, result, words): (_, _, &str)| Finding { about, result, words: words.to_owned() };
    let claims =
        vec![Claim { verdict: WORDS.join("; "), findings: findings.map(finding).into(), ..claim }];
    Report {
        trials: 1000,
        environments: vec![environment("normal"), environment("bad-link")],
        claims,
    }
}

#[test]
fn a_report_is_a_table_for_each_environment_and_the_verdicts() {
    let table = "\
METHOD             ARRIVED  TIME 50 %     90 %  DEVIATION 50 %      90 %  COVERED  RECOGNISED
statistic/20        99.5 %     21.2 s  170.0 s         12.3 mm  100.0 mm   91.2 %       never
bayesian/20         99.5 %     21.2 s  170.0 s         12.3 mm  100.0 mm   91.2 %         412
no-compensation/1   99.5 %     21.2 s  170.0 s         12.3 mm  100.0 mm        -           -
";
    let expected = format!(
        "normal:\n{table}\nbad-link:\n{table}\n\
         bayesian/20 against statistic/20, bad-link:\n  \
         deviation 12.3 % smaller (95 %: 8.1 to 16.0): 16 % of the thesis's 75 %\n  \
         time 104 % longer (95 %: 100 to 108): the opposite of the thesis's 35 % shorter, none of it is reached\n  \
         not all arrived: bayesian/20 in 99.5 % of the trials, statistic/20 in 100.0 %, the others count with the time \
         limit and as far as they got\n"
    );
    assert_eq!(report::text(&report()), expected);
    let mut earlier = report();
    earlier.claims[0].findings.clear();
    let shown = report::text(&earlier);
    assert!(
        shown.ends_with(&format!("  {}\n", WORDS.join("; "))),
        "as a server of an earlier version says it"
    );
    let untested = Report { claims: Vec::new(), ..report() };
    assert!(report::text(&untested).ends_with("with as many slots\n"));
}

#[test]
fn a_comparison_is_shown_with_what_was_asked_for_and_what_came_of_it() {
    assert_eq!(
        ComparisonKind::show(&comparison()),
        "\
comparison-12: queued, waiting for its turn
  scenario     thesis: normal, bad-link
  methods      statistic/20, bayesian/20, no-compensation/1
  trials       1000 of each in each environment, seed 1; not arrived after 180 s
  episodes     0 of 6040, 0.0 s
  prior        thesis, of bayesian
"
    );
    let succeeded = Comparison {
        state: State::Succeeded,
        interrupted: 1,
        outcome: Outcome { report: Some(report()) },
        ..comparison()
    };
    let text = ComparisonKind::show(&succeeded);
    assert!(text.contains("resumed after one restart of the server"), "{text}");
    assert!(text.contains("of bayesian\n\nnormal:\nMETHOD"), "{text}");
    let error = Some("no space left".to_owned());
    let failed = Comparison { state: State::Failed, error, ..comparison() };
    assert!(ComparisonKind::show(&failed).contains("error        no space left\n"));
}

#[test]
fn progress_says_trial_and_time_left() {
    let progress = comparison().progress;
    let trials =
        Progress { stage: Stage::Trials, trials_done: 5, remaining_s: Some(12.34), ..progress };
    assert_eq!(ComparisonKind::words(&trials), "trial 5/1000, 12.3 s left");
    let reference = Progress { stage: Stage::Reference, ..progress };
    assert_eq!(
        ComparisonKind::words(&reference),
        "measuring how each environment shows in the samples"
    );
    let done = Progress { stage: Stage::Done, remaining_s: Some(0.0), ..trials };
    assert_eq!(ComparisonKind::words(&done), "1000 trials");
}

#[test]
fn comparisons_are_a_table() {
    let running = Comparison {
        state: State::Running,
        progress: Progress { trials_done: 5, elapsed_s: 75.0, ..comparison().progress },
        ..comparison()
    };
    let mut without = comparison();
    without.spec.prior = None;
    let page = Page { jobs: vec![running, without], ..Page::default() };
    assert_eq!(
        listed(&page),
        "\
COMPARISON     STATE     TRIAL  RAN FOR  SCENARIO  METHODS  SEED  PRIOR
comparison-12  running  5/1000    1 min  thesis          3     1  thesis
comparison-12  queued   0/1000    0.0 s  thesis          3     1  -
"
    );
    assert_eq!(listed(&Page::default()), "");
}
