//! The laws of comparisons.

use super::{MAX, pairs, problems, within};
use crate::comparison as lab;
use crate::comparison::{ComparisonSettings, Contender, SCENARIOS};
use crate::wire::{self, Pace};
use proptest::prelude::*;
use proptest::sample::{select, subsequence};
use serde_json::{Value, json};
use umwelt_api::Checked;
use umwelt_api::comparison::{self, Request, Scenario, Spec};
use umwelt_api::problem::reason;
use umwelt_api::{Known, Problems, prior as priors, robot};
use umwelt_core::conjugate::NormalInverseChiSquared;
use umwelt_core::identification::BUILT_IN_PRIORS;
use umwelt_core::settings::Prior;

fn belief() -> impl Strategy<Value = NormalInverseChiSquared> {
    (within(robot::MU), within(robot::WEIGHT), within(robot::WEIGHT), within(robot::SUM_OF_SQUARES))
        .prop_map(|(mu, k, r, s)| NormalInverseChiSquared::new(mu, k, r, s).unwrap())
}

fn prior() -> impl Strategy<Value = Prior> {
    (belief(), belief(), belief(), belief()).prop_map(|(forward, lateral, turn, drift)| Prior {
        forward,
        lateral,
        turn,
        drift,
    })
}

fn thesis() -> ComparisonSettings {
    ComparisonSettings::scenario("thesis").unwrap()
}

/// Settings that differ from a scenario in everything that the wire can say, with the name of their prior.
fn settings() -> impl Strategy<Value = (ComparisonSettings, &'static str)> {
    let contenders = subsequence(thesis().contenders, 1..=thesis().contenders.len());
    let names = select(BUILT_IN_PRIORS.to_vec());
    (select(SCENARIOS.to_vec()), contenders, 2..=2000usize, 0..=MAX, names).prop_map(
        |(scenario, contenders, trials, seed, name)| {
            let mut settings = ComparisonSettings::scenario(scenario).unwrap();
            (settings.contenders, settings.trials, settings.seed) = (contenders, trials, seed);
            for contender in &mut settings.contenders {
                // The default comes in two, by slots, as the scenario has them.
                if contender.name == lab::CHAMPION && name != comparison::DEFAULT_PRIOR {
                    contender.prior = Prior::built_in(name).unwrap();
                }
            }
            (settings, name)
        },
    )
}

/// What asks for `settings`: what was asked for, all filled in, without what the scenario says.
fn asking_for(settings: &ComparisonSettings, prior: &str) -> Value {
    let mut spec = serde_json::to_value(wire::comparison::spec(settings, prior)).unwrap();
    let fields = spec.as_object_mut().unwrap();
    fields.remove("environments");
    fields.remove("time_limit_s");
    spec
}

fn read(body: &Value) -> Result<(Checked<Request>, ComparisonSettings), Problems> {
    wire::comparison::read(body.to_string().as_bytes(), priors::built_in)
}

fn labels(settings: &ComparisonSettings) -> Vec<String> {
    settings.contenders.iter().map(Contender::label).collect()
}

/// The one remedy of what is wrong with `body`.
fn remedy(body: &Value) -> String {
    let problems = read(body).unwrap_err();
    assert_eq!(problems.details().len(), 1, "{problems}");
    problems.details()[0].remedy.clone()
}

proptest! {
    #[test]
    fn a_comparison_survives_the_wire((lab, prior) in settings()) {
        let (request, read) = read(&asking_for(&lab, prior)).unwrap();
        prop_assert_eq!(&read, &lab);
        let spec = wire::comparison::spec(&read, request.prior_name());
        let json = serde_json::to_string(&spec).unwrap();
        prop_assert_eq!(serde_json::from_str::<Spec>(&json).unwrap(), spec);
    }

    /// Whatever one field of a request is replaced by, what comes out can run or is refused with that field.
    #[test]
    fn nothing_gets_to_lab_that_cannot_run((lab, prior) in settings(), which in any::<prop::sample::Index>(),
                                            bad in select(vec![json!(1e308), json!(-1e-9), json!(0), json!(1), json!(10_000), json!(u64::MAX), json!(""), json!("flat"), Value::Null, json!([]), json!([""]), json!(["bayesian"]), json!({})])) {
        let mut body = asking_for(&lab, prior);
        let names: Vec<String> = body.as_object().unwrap().keys().cloned().collect();
        body[&names[which.index(names.len())]] = bad;
        if let Ok((_, settings)) = read(&body) {
            prop_assert_eq!(settings.check(), Ok(()));
            prop_assert!(lab::Comparison::new(settings).is_ok());
        }
    }

    #[test]
    fn a_kept_prior_is_that_of_bayesian_alone(kept in prior()) {
        let known = |name: &str| -> Known<Prior> {
            if name == "wet-hall" { Ok(kept) } else { Err(vec!["wet-hall".to_owned()]) }
        };
        let body = json!({"prior": "wet-hall"}).to_string();
        let (request, settings) = wire::comparison::read(body.as_bytes(), known).unwrap();
        prop_assert_eq!(request.prior_name(), "wet-hall");
        for (contender, before) in settings.contenders.iter().zip(&thesis().contenders) {
            let expected = if before.name == lab::CHAMPION { kept } else { before.prior };
            prop_assert_eq!(contender.prior, expected, "{}", contender.label());
        }
        let unknown = Request { prior: Some("dry-hall".to_owned()), ..Request::default() };
        let unknown = wire::comparison::settings(&unknown, known);
        prop_assert_eq!(problems(unknown), pairs(&[(reason::UNKNOWN_PRIOR, "prior")]));
    }
}

#[test]
fn scenarios_are_those_of_lab_and_an_empty_request_is_the_thesis() {
    let (request, settings) = read(&json!({})).unwrap();
    assert_eq!((request.into_inner(), settings), (Request::default(), thesis()));
    assert_eq!(Scenario::ALL.map(Scenario::name), SCENARIOS);
    for scenario in Scenario::ALL {
        let (_, settings) = read(&json!({ "scenario": scenario.name() })).unwrap();
        assert_eq!(Some(settings), ComparisonSettings::scenario(scenario.name()));
    }
    let bad = problems(read(&json!({"scenario": "moon"})));
    assert_eq!(bad, pairs(&[(reason::MALFORMED, "scenario")]));
}

/// What the contract says of a request that leaves something out.
#[test]
fn what_is_left_out_is_what_the_contract_says() {
    let settings = thesis();
    assert_eq!((settings.trials, settings.seed), (1000, 1));
    let bayesian = settings.contenders.iter().filter(|it| it.name == lab::CHAMPION);
    let priors: Vec<_> = bayesian.map(|it| (it.slots, it.prior)).collect();
    let [one, twenty] =
        [comparison::DEFAULT_PRIOR, "thesis-20"].map(|name| Prior::built_in(name).unwrap());
    assert_eq!(priors, [(1, one), (20, twenty)]);
    let words: serde_json::Value = serde_json::from_str(umwelt_api::DOCUMENT).unwrap();
    let request = &words["components"]["schemas"]["ComparisonRequest"]["properties"];
    assert!(request["trials"]["description"].as_str().unwrap().contains("null for 1000"));
}

#[test]
fn limits_are_those_of_lab() {
    assert_eq!(*comparison::METHODS.end(), lab::MAX_CONTENDERS);
    assert_eq!(*comparison::TRIALS.end(), lab::MAX_TRIALS as u64);
    assert_eq!(comparison::MAX_EPISODES, lab::MAX_EPISODES);
}

/// The contract names every method before lab is asked.
#[test]
fn the_methods_of_the_contract_are_those_of_lab() {
    let mut known = labels(&thesis());
    known.extend(lab::method_names().map(str::to_owned));
    known.sort_unstable();
    assert_eq!(known, comparison::KNOWN_METHODS);
}

#[test]
fn a_method_is_all_its_slots_and_a_label_one_of_them() {
    let of = |methods: &[&str]| labels(&read(&json!({ "methods": methods })).unwrap().1);
    assert_eq!(of(&["bayesian"]), ["bayesian/1", "bayesian/20"]);
    assert_eq!(of(&["bayesian/20", "statistic/20"]), ["statistic/20", "bayesian/20"]);
    for name in lab::method_names() {
        assert!(of(&[name]).iter().all(|label| label.starts_with(&format!("{name}/"))), "{name}");
    }
    assert_eq!(of(&lab::method_names().collect::<Vec<_>>()), labels(&thesis()));
}

/// Guards against a mistyped method that compares something else without an error.
#[test]
fn methods_that_are_unknown_or_repeated_are_told_with_those_that_there_are() {
    let of = |methods: &[&str]| problems(read(&json!({ "methods": methods })));
    let unknown = reason::UNKNOWN_METHOD;
    assert_eq!(
        of(&["bayes", "statistic", "bayesian/3", ""]),
        pairs(&[(unknown, "methods[0]"), (unknown, "methods[2]"), (unknown, "methods[3]")])
    );
    let repeated = reason::REPEATED;
    assert_eq!(of(&["bayesian", "bayesian"]), pairs(&[(repeated, "methods[1]")]));
    let twice = reason::INCONSISTENT;
    assert_eq!(of(&["bayesian/1", "bayesian"]), pairs(&[(twice, "methods[1]")]));
    assert_eq!(of(&["bayesian", "oracle", "bayesian/1"]), pairs(&[(twice, "methods[2]")]));

    let names = remedy(&json!({"methods": ["bayes"]}));
    assert!(lab::method_names().all(|name| names.contains(name)), "{names}");
    assert_eq!(
        remedy(&json!({"methods": ["bayesian/3"]})),
        "known: bayesian, bayesian/1, bayesian/20"
    );
}

/// Each value alone is refused with its own field.
#[test]
fn every_limit_of_a_comparison_is_refused_with_its_field() {
    let outside = [
        ("methods", json!([])),
        ("methods", json!((0..65).map(|index| format!("m{index}")).collect::<Vec<_>>())),
        ("trials", json!(1)),
        ("trials", json!(10_001)),
        ("seed", json!(1u64 << 53)),
        ("prior", json!("my own")),
        ("prior", json!("")),
    ];
    for (field, value) in outside {
        let found = problems(Request::read(json!({ field: value }).to_string().as_bytes()));
        assert!(found.iter().all(|(_, name)| name == field), "{field} {value}: {found:?}");
    }
    for (field, value) in [("trials", json!(2)), ("seed", json!(MAX)), ("prior", json!("flat"))] {
        assert!(read(&json!({ field: value })).is_ok(), "{field} {value}");
    }
}

#[test]
fn all_problems_of_a_comparison_are_told_at_once() {
    let body = json!({"methods": ["bayesian", "guess"], "trial": 5, "trials": 1, "prior": "wet-hall", "seed": -1});
    assert_eq!(problems(read(&body)), pairs(&[(reason::MALFORMED, "seed")]));
    let body =
        json!({"methods": ["bayesian", "guess"], "trial": 5, "trials": 1, "prior": "wet-hall"});
    let expected = pairs(&[
        (reason::UNKNOWN_FIELD, "trial"),
        (reason::OUT_OF_RANGE, "trials"),
        (reason::UNKNOWN_PRIOR, "prior"),
        (reason::UNKNOWN_METHOD, "methods[1]"),
    ]);
    assert_eq!(problems(read(&body)), expected);
}

#[test]
fn what_only_the_whole_can_say_is_said() {
    let of = |methods: &[&str], trials: u64| json!({"methods": methods, "trials": trials});
    let all: Vec<_> = lab::method_names().collect();
    let cells = 2 * thesis().contenders.len() as u64;
    let most = comparison::MAX_EPISODES / cells;
    assert!(read(&of(&all, most)).is_ok());
    assert_eq!(problems(read(&of(&all, most + 1))), pairs(&[(reason::INCONSISTENT, "trials")]));
    let remedy = remedy(&of(&all, 10_000));
    assert!(remedy.contains(&format!("{} episodes", cells * 10_000)), "{remedy}");
    assert!(remedy.contains(&format!("at most {most} trials")), "{remedy}");
    assert!(read(&of(&["bayesian", "statistic", "oracle"], 10_000)).is_ok());

    let unused = json!({"methods": ["statistic", "bayesian-flat"], "prior": "flat"});
    assert_eq!(problems(read(&unused)), pairs(&[(reason::INCONSISTENT, "prior")]));
}

/// A whole comparison, small, from request to report: what lab says is what the wire says.
#[test]
fn what_comes_of_a_comparison_is_told_unchanged() {
    let body = json!({"methods": ["statistic", "bayesian/20", "no-compensation"], "trials": 3});
    let (request, settings) = read(&body).unwrap();
    assert_eq!(
        wire::comparison::spec(&settings, request.prior_name()).prior.as_deref(),
        Some("thesis")
    );
    let mut lab = lab::Comparison::new(settings).unwrap();
    let total = lab.total_episodes();
    let pace = Pace { total_episodes: total, ..Pace::default() };
    let queued = wire::comparison::progress(lab.settings(), None, pace);
    assert_eq!(
        (queued.stage, queued.trials_done, queued.trials),
        (comparison::Stage::Queued, 0, 3)
    );
    assert_eq!((queued.episodes, queued.total_episodes), (0, total));
    let mut stages = Vec::new();
    while lab.report().is_none() {
        let pace = Pace {
            episodes: lab.episodes(),
            total_episodes: total,
            elapsed_s: 1.5,
            remaining_s: Some(f64::INFINITY),
        };
        let progress = wire::comparison::progress(lab.settings(), Some(lab.stage()), pace);
        assert_eq!((progress.episodes, progress.elapsed_s), (lab.episodes(), 1.5));
        assert_eq!(progress.remaining_s, None);
        stages.push(progress.stage.name());
        let evaluations: Vec<_> =
            lab.batch().iter().map(|it| lab::Comparison::evaluate(lab.settings(), it)).collect();
        lab.tell(&evaluations).unwrap();
    }
    assert_eq!(stages, ["reference", "trials"]);
    let pace = Pace { episodes: lab.episodes(), remaining_s: Some(0.0), ..pace };
    let done = wire::comparison::progress(lab.settings(), Some(lab.stage()), pace);
    assert_eq!((done.stage, done.trials_done), (comparison::Stage::Done, 3));
    assert_eq!((done.episodes, done.remaining_s), (total, Some(0.0)));

    let mut report = lab.report().unwrap().clone();
    // All may have arrived: make them tell who is who.
    let entries = report.environments.iter_mut().flat_map(|it| &mut it.entries);
    entries.enumerate().for_each(|(place, entry)| entry.arrived.mean = 0.1 * place as f64);
    let wire = comparison::Report::from(&report);
    assert_eq!(wire.trials, 3);
    for (wire, lab) in wire.environments.iter().zip(&report.environments) {
        assert_eq!((&wire.environment, wire.entries.len()), (&lab.environment, 4));
        for (wire, lab) in wire.entries.iter().zip(&lab.entries) {
            assert_eq!(wire.contender, lab.contender);
            assert_eq!(wire.arrived.low, lab.arrived.low);
            assert_eq!(wire.time_s.median.mean, lab.summary.time.median.mean);
            assert_eq!(wire.deviation_m.p90.high, lab.summary.deviation.p90.high);
            let identifies = lab.recognition.is_some();
            assert_eq!(
                (wire.recognition.is_some(), wire.coverage.is_some()),
                (identifies, identifies)
            );
            let (wire, lab) = (wire.difference.as_ref(), lab.difference.as_ref());
            assert_eq!(wire.map(|it| &it.against), lab.map(|it| &it.against));
            assert_eq!(wire.map(|it| it.time_s.p90.low), lab.map(|it| it.absolute.time.p90.low));
            let of_wire = wire.and_then(|it| it.deviation_reduction.median).map(|it| it.mean);
            assert_eq!(of_wire, lab.map(|it| it.reduction.deviation.median.mean));
        }
    }
    assert_eq!(wire.claims.len(), 2, "one in each environment");
    for (wire, lab) in wire.claims.iter().zip(&report.claims) {
        assert_eq!((wire.slots, wire.contender.as_str()), (20, "bayesian/20"));
        assert_eq!(wire.against, "statistic/20");
        assert_eq!(wire.deviation_reduction.mean.unwrap().mean, lab.deviation.mean.mean);
        assert_eq!(wire.time_reduction.p90.unwrap().high, lab.time.p90.high);
        assert_eq!((wire.promised_deviation, wire.promised_time), (0.75, 0.35));
        assert_eq!(*wire, wire::verdict::judged(wire.clone()), "its words are made once");
        let here = report.environments.iter().find(|it| it.environment == lab.environment);
        let arrived = |label: &str| {
            let mut entries = here.unwrap().entries.iter();
            entries.find(|it| it.contender == label).unwrap().arrived.mean
        };
        let expected = (arrived("bayesian/20"), arrived("statistic/20"));
        assert_eq!((wire.arrived, wire.against_arrived), expected);
    }
    let json = serde_json::to_string(&wire).unwrap();
    assert_eq!(serde_json::from_str::<comparison::Report>(&json).unwrap(), wire);

    let id = umwelt_api::ComparisonId::numbered(1);
    let event = comparison::Event::state(id, comparison::State::Succeeded, done, None);
    assert_eq!(event.id, 3);
    let json = serde_json::to_string(&event).unwrap();
    assert_eq!(serde_json::from_str::<comparison::Event>(&json).unwrap(), event);
}

/// A robot that stood still has no deviation, and no other is better than that by a part of it.
#[test]
fn a_reduction_of_nothing_is_null() {
    let number = |mean: f64| crate::evolution::Estimate { mean, low: mean, high: mean };
    let reductions = comparison::Reductions::from(lab::Quantities {
        mean: number(0.5),
        median: number(f64::NAN),
        p90: number(f64::NEG_INFINITY),
    });
    assert_eq!(reductions.mean.map(|it| it.mean), Some(0.5));
    assert_eq!((reductions.median, reductions.p90), (None, None));
    assert!(serde_json::to_string(&reductions).is_ok());
}
