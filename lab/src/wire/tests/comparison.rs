//! The laws of comparisons.

use super::strategies::{MAX, prior};
use super::{pairs, problems};
use crate::comparison::{self, Request, Scenario, Spec};
use crate::named::Known;
use crate::problem::reason;
use crate::{Problems, prior as priors};
use proptest::prelude::*;
use proptest::sample::{select, subsequence};
use serde_json::{Value, json};
use umwelt_core::comparison as core;
use umwelt_core::comparison::{ComparisonSettings, Contender, SCENARIOS};
use umwelt_core::identification::BUILT_IN_PRIORS;
use umwelt_core::settings::Prior;

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
                if contender.name == core::CHAMPION && name != comparison::DEFAULT_PRIOR {
                    contender.prior = Prior::built_in(name).unwrap();
                }
            }
            (settings, name)
        },
    )
}

/// What asks for `settings`: what it was told, all filled in, without what the scenario says.
fn asking_for(settings: &ComparisonSettings, prior: &str) -> Value {
    let mut spec = serde_json::to_value(Spec::from_core(settings, prior)).unwrap();
    let fields = spec.as_object_mut().unwrap();
    fields.remove("environments");
    fields.remove("time_limit_s");
    spec
}

fn read(body: &Value) -> Result<(Request, ComparisonSettings), Problems> {
    Request::read_known(body.to_string().as_bytes(), priors::built_in)
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
    fn a_comparison_survives_the_wire((core, prior) in settings()) {
        let (request, read) = read(&asking_for(&core, prior)).unwrap();
        prop_assert_eq!(&read, &core);
        let spec = Spec::from_core(&read, request.prior_name());
        let json = serde_json::to_string(&spec).unwrap();
        prop_assert_eq!(serde_json::from_str::<Spec>(&json).unwrap(), spec);
    }

    /// Whatever one field of a request is replaced by, what comes out can run or is refused with that field.
    #[test]
    fn nothing_gets_to_core_that_cannot_run((core, prior) in settings(), which in any::<prop::sample::Index>(),
                                            bad in select(vec![json!(1e308), json!(-1e-9), json!(0), json!(1), json!(10_000), json!(u64::MAX), json!(""), json!("flat"), Value::Null, json!([]), json!([""]), json!(["bayesian"]), json!({})])) {
        let mut body = asking_for(&core, prior);
        let names: Vec<String> = body.as_object().unwrap().keys().cloned().collect();
        body[&names[which.index(names.len())]] = bad;
        if let Ok((_, settings)) = read(&body) {
            prop_assert_eq!(settings.check(), Ok(()));
            prop_assert!(core::Comparison::new(settings).is_ok());
        }
    }

    #[test]
    fn a_kept_prior_is_that_of_bayesian_alone(kept in prior()) {
        let known = |name: &str| -> Known<Prior> {
            if name == "wet-hall" { Ok(kept) } else { Err(vec!["wet-hall".to_owned()]) }
        };
        let body = json!({"prior": "wet-hall"}).to_string();
        let (request, settings) = Request::read_known(body.as_bytes(), known).unwrap();
        prop_assert_eq!(request.prior_name(), "wet-hall");
        for (contender, before) in settings.contenders.iter().zip(&thesis().contenders) {
            let expected = if before.name == core::CHAMPION { kept } else { before.prior };
            prop_assert_eq!(contender.prior, expected, "{}", contender.label());
        }
        let unknown = Request { prior: Some("dry-hall".to_owned()), ..Request::default() }.to_core(known);
        prop_assert_eq!(problems(unknown), pairs(&[(reason::UNKNOWN_PRIOR, "prior")]));
    }
}

#[test]
fn scenarios_are_cores_and_an_empty_request_is_the_thesis() {
    let (request, settings) = read(&json!({})).unwrap();
    assert_eq!((request, settings), (Request::default(), thesis()));
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
    let bayesian = settings.contenders.iter().filter(|it| it.name == core::CHAMPION);
    let priors: Vec<_> = bayesian.map(|it| (it.slots, it.prior)).collect();
    let [one, twenty] =
        [comparison::DEFAULT_PRIOR, "thesis-20"].map(|name| Prior::built_in(name).unwrap());
    assert_eq!(priors, [(1, one), (20, twenty)]);
    let words = serde_json::to_value(crate::document()).unwrap();
    let request = &words["components"]["schemas"]["comparison.Request"]["properties"];
    assert!(request["trials"]["description"].as_str().unwrap().contains("null for 1000"));
}

#[test]
fn limits_are_those_of_core() {
    assert_eq!(*comparison::METHODS.end(), core::MAX_CONTENDERS);
    assert_eq!(*comparison::TRIALS.end(), core::MAX_TRIALS as u64);
    assert_eq!(comparison::MAX_EPISODES, core::MAX_EPISODES);
}

#[test]
fn a_method_is_all_its_slots_and_a_label_one_of_them() {
    let of = |methods: &[&str]| labels(&read(&json!({ "methods": methods })).unwrap().1);
    assert_eq!(of(&["bayesian"]), ["bayesian/1", "bayesian/20"]);
    assert_eq!(of(&["bayesian/20", "statistic/20"]), ["statistic/20", "bayesian/20"]);
    for name in core::method_names() {
        assert!(of(&[name]).iter().all(|label| label.starts_with(&format!("{name}/"))), "{name}");
    }
    assert_eq!(of(&core::method_names().collect::<Vec<_>>()), labels(&thesis()));
}

/// The bug to fear: somebody who mistypes a method compares something else and is not told.
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
    assert!(core::method_names().all(|name| names.contains(name)), "{names}");
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
        ("prior", json!("Mine")),
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
    let all: Vec<_> = core::method_names().collect();
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

/// A whole comparison, small, from request to report: what core says is what the wire says.
#[test]
fn what_comes_of_a_comparison_is_told_unchanged() {
    let body = json!({"methods": ["statistic", "bayesian/20", "no-compensation"], "trials": 3});
    let (request, settings) = read(&body).unwrap();
    assert_eq!(Spec::from_core(&settings, request.prior_name()).prior.as_deref(), Some("thesis"));
    let mut core = core::Comparison::new(settings).unwrap();
    let queued = comparison::Progress::queued(&core);
    let total = core.total_episodes();
    assert_eq!(
        (queued.stage, queued.trials_done, queued.trials),
        (comparison::Stage::Queued, 0, 3)
    );
    assert_eq!((queued.episodes, queued.total_episodes), (0, total));
    let mut stages = Vec::new();
    while core.report().is_none() {
        let progress = comparison::Progress::of(&core, 1.5, Some(f64::INFINITY));
        assert_eq!((progress.episodes, progress.elapsed_s), (core.episodes(), 1.5));
        assert_eq!(progress.remaining_s, None);
        stages.push(progress.stage.name());
        let evaluations: Vec<_> = core.jobs().iter().map(|job| core.evaluate(job)).collect();
        core.tell(&evaluations).unwrap();
    }
    assert_eq!(stages, ["reference", "trials"]);
    let done = comparison::Progress::of(&core, 1.5, Some(0.0));
    assert_eq!((done.stage, done.trials_done), (comparison::Stage::Done, 3));
    assert_eq!((done.episodes, done.remaining_s), (total, Some(0.0)));

    let mut report = core.report().unwrap().clone();
    // All may have arrived: make them tell who is who.
    let entries = report.environments.iter_mut().flat_map(|it| &mut it.entries);
    entries.enumerate().for_each(|(place, entry)| entry.arrived.mean = 0.1 * place as f64);
    let wire = comparison::Report::from(&report);
    assert_eq!(wire.trials, 3);
    for (wire, core) in wire.environments.iter().zip(&report.environments) {
        assert_eq!((&wire.environment, wire.entries.len()), (&core.environment, 4));
        for (wire, core) in wire.entries.iter().zip(&core.entries) {
            assert_eq!(wire.contender, core.contender);
            assert_eq!(wire.arrived.low, core.arrived.low);
            assert_eq!(wire.time_s.median.mean, core.summary.time.median.mean);
            assert_eq!(wire.deviation_m.p90.high, core.summary.deviation.p90.high);
            let identifies = core.recognition.is_some();
            assert_eq!(
                (wire.recognition.is_some(), wire.coverage.is_some()),
                (identifies, identifies)
            );
            let (wire, core) = (wire.difference.as_ref(), core.difference.as_ref());
            assert_eq!(wire.map(|it| &it.against), core.map(|it| &it.against));
            assert_eq!(wire.map(|it| it.time_s.p90.low), core.map(|it| it.absolute.time.p90.low));
            let of_wire = wire.and_then(|it| it.deviation_reduction.median).map(|it| it.mean);
            assert_eq!(of_wire, core.map(|it| it.reduction.deviation.median.mean));
        }
    }
    assert_eq!(wire.claims.len(), 2, "one in each environment");
    for (wire, core) in wire.claims.iter().zip(&report.claims) {
        assert_eq!((wire.slots, wire.contender.as_str()), (20, "bayesian/20"));
        assert_eq!(wire.against, "statistic/20");
        assert_eq!(wire.deviation_reduction.mean.unwrap().mean, core.deviation.mean.mean);
        assert_eq!(wire.time_reduction.p90.unwrap().high, core.time.p90.high);
        assert_eq!((wire.promised_deviation, wire.promised_time), (0.75, 0.35));
        assert_eq!(wire.verdict, wire.in_words());
        let here = report.environments.iter().find(|it| it.environment == core.environment);
        let arrived = |label: &str| {
            let mut entries = here.unwrap().entries.iter();
            entries.find(|it| it.contender == label).unwrap().arrived.mean
        };
        let expected = (arrived("bayesian/20"), arrived("statistic/20"));
        assert_eq!((wire.arrived, wire.against_arrived), expected);
    }
    let json = serde_json::to_string(&wire).unwrap();
    assert_eq!(serde_json::from_str::<comparison::Report>(&json).unwrap(), wire);

    let id = crate::ComparisonId::numbered(1);
    let event = comparison::Event::state(id, comparison::State::Succeeded, done, None);
    assert_eq!(event.id, 3);
    let json = serde_json::to_string(&event).unwrap();
    assert_eq!(serde_json::from_str::<comparison::Event>(&json).unwrap(), event);
}

/// Nobody who stood still has a deviation, and nobody is better than that by a part of it.
#[test]
fn a_reduction_of_nothing_is_null() {
    let number = |mean: f64| umwelt_core::evolution::Estimate { mean, low: mean, high: mean };
    let reductions = comparison::Reductions::from(core::Quantities {
        mean: number(0.5),
        median: number(f64::NAN),
        p90: number(f64::NEG_INFINITY),
    });
    assert_eq!(reductions.mean.map(|it| it.mean), Some(0.5));
    assert_eq!((reductions.median, reductions.p90), (None, None));
    assert!(serde_json::to_string(&reductions).is_ok());
}

#[test]
fn names_are_those_of_the_wire() {
    use comparison::{Figure, Stage};
    for figure in Figure::ALL {
        assert_eq!(serde_json::to_value(figure).unwrap(), figure.name());
        assert_eq!(Figure::named(figure.name()), Some(figure));
    }
    assert_eq!(Figure::named("speed"), None);
    for stage in Stage::ALL {
        assert_eq!(serde_json::to_value(stage).unwrap(), stage.name());
    }
    for scenario in Scenario::ALL {
        assert_eq!(serde_json::to_value(scenario).unwrap(), scenario.name());
        assert_eq!(Scenario::named(scenario.name()), Some(scenario));
    }
}

#[test]
fn a_reader_of_comparisons_ignores_what_it_does_not_know() {
    let spec = json!({"scenario": "of-tomorrow", "methods": ["guess/3"], "environments": ["moon"], "trials": 20_000,
                      "seed": 1, "time_limit_s": 180, "prior": null, "colour": "red"});
    let progress = json!({"stage": "trials", "trials_done": 5, "trials": 9, "episodes": 10, "total_episodes": 18,
                          "elapsed_s": 1, "remaining_s": null, "mood": "good"});
    let body = json!({"comparison": "comparison-1", "state": "running", "spec": spec, "progress": progress,
                      "interrupted": 0, "created_unix_s": 1, "error": null, "report": null, "more": {}});
    let read: comparison::Comparison = serde_json::from_value(body).unwrap();
    assert_eq!((read.spec.trials, read.progress.trials_done), (20_000, 5));
}
