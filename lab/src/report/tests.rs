use super::*;
use umwelt_api::comparison::{Difference, Recognition};

fn estimate(mean: f64, half: f64) -> Estimate {
    Estimate { mean, low: mean - half, high: mean + half }
}

fn quantities(value: f64) -> Quantities {
    let [mean, median, p90] =
        [1.1 * value, value, 1.5 * value].map(|it| estimate(it, 0.1 * value.abs()));
    Quantities { mean, median, p90 }
}

fn reductions(mean: f64) -> Reductions {
    let it = Some(estimate(mean, 0.05));
    Reductions { mean: it, median: it, p90: None }
}

fn entry(contender: &str, time: f64, deviation: f64, difference: Option<(f64, f64)>) -> Entry {
    let difference = difference.map(|(time, deviation)| Difference {
        against: "statistic/1".to_owned(),
        time_s: quantities(time),
        deviation_m: quantities(deviation),
        time_reduction: reductions(-time / 10.0),
        deviation_reduction: reductions(-deviation / 0.02),
    });
    Entry {
        contender: contender.to_owned(),
        arrived: estimate(0.995, 0.004),
        time_s: quantities(time),
        deviation_m: quantities(deviation),
        recognition: Some(Recognition { share: 0.75, median_samples: Some(12), p90_samples: None }),
        coverage: Some(estimate(0.991, 0.002)),
        difference,
    }
}

fn report(deviation: f64, time: f64) -> Report {
    let claim = crate::wire::verdict::judged(Claim {
        environment: "bad-link".to_owned(),
        slots: 1,
        contender: "bayesian/1".to_owned(),
        against: "statistic/1".to_owned(),
        deviation_reduction: reductions(deviation),
        time_reduction: reductions(time),
        arrived: 1.0,
        against_arrived: 1.0,
        promised_deviation: 0.75,
        promised_time: 0.35,
        verdict: String::new(),
        findings: Vec::new(),
    });
    let entries = vec![
        entry("statistic/1", 10.0, 0.02, None),
        entry("bayesian/1", 20.0, 0.01, Some((10.0, -0.01))),
        entry("statistic/20", 9.0, 0.002, None),
        entry("gp-mpc/1", 12.0, 0.005, None),
        entry("oracle/1", 9.5, 0.018, None),
    ];
    let environments = vec![EnvironmentReport { environment: "bad-link".to_owned(), entries }];
    Report { trials: 40, environments, claims: vec![claim] }
}

fn text(report: &Report) -> String {
    markdown(&ComparisonSettings::scenario("thesis").unwrap(), "thesis", report)
}

/// Guards against a report that reads well whatever the numbers are.
#[test]
fn the_words_follow_the_numbers() {
    let bought = text(&report(0.5, -1.0));
    assert!(bought.contains("It buys accuracy with time"), "{bought}");
    assert!(bought.contains("* Deviation (means): better than the baseline, by less than is claimed in bad-link with 1 slot."));
    assert!(bought.contains(
        "* Time (means): the opposite: worse than the baseline in bad-link with 1 slot."
    ));
    assert!(bought.contains("67 % of the thesis's 75 %"));
    let none = text(&report(0.01, 0.02));
    assert!(none.contains("Nothing tells them apart") && none.contains("includes zero"));
    assert!(!none.contains("whole claim"));
    let kept = text(&report(0.8, 0.4));
    assert!(kept.contains("It is better in both."));
    assert_eq!(kept.matches("the whole claim or more is reached").count(), 2);
    let worse = text(&report(-0.2, -0.3));
    assert!(worse.contains("It is worse in both."));
}

#[test]
fn everybody_has_a_row_and_those_who_are_better_are_named() {
    let text = text(&report(0.5, -1.0));
    assert!(text.contains("| `bayesian/1` | 99.5 % | 20.00 | 22.00 | 30.00 | 10.0 | 11.0 | 15.0 | +11.00 (+10.00 to +12.00) | \
                           -11.0 (-12.0 to -10.0) | 12, never (75 % at the end) | 99.1 % |"), "{text}");
    assert!(text.contains("both faster and nearer to the path, by the medians: `gp-mpc/1`."));
    assert!(text.contains(
        "with 20 slots instead of one command per reply `statistic` goes from 10.0 s and 20.0 mm"
    ));
    assert!(text.contains("held 99.1 % of what came"));
    for figure in Figure::ALL {
        assert!(text.contains(&format!("]({}.svg)", figure.name())));
    }
    for named in [
        "wheel radius",
        "alpha of the steering law",
        "environment bad-link",
        "5 % of the slots late by 0.4 s",
    ] {
        assert!(text.contains(named), "{named}");
    }
    let columns = |line: &str| line.matches('|').count();
    let lines: Vec<&str> = text.lines().filter(|line| line.starts_with('|')).collect();
    for pair in lines.windows(2).filter(|pair| pair[0].starts_with("|--")) {
        assert_eq!(columns(pair[0]), columns(pair[1]));
    }
}

#[test]
fn without_claims_nothing_is_claimed() {
    let nothing = Report { claims: Vec::new(), ..report(0.1, 0.1) };
    let text = text(&nothing);
    assert!(text.contains("not both drove") && !text.contains("### Why"));
}

#[test]
fn a_change_is_signed_and_marked_where_it_says_nothing() {
    assert_eq!(change(Some(estimate(0.614, 0.08))), "-61 % (-69 to -53)");
    assert_eq!(change(Some(estimate(-1.13, 0.1))), "+113 % (+103 to +123)");
    assert_eq!(change(Some(estimate(0.001, 0.05))), "+0 % (-5 to +5, includes zero)");
    assert_eq!(change(None), "-");
}
