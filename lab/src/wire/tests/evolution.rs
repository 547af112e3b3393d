//! The laws of evolutions.

use super::{MAX, pairs, problems, within};
use crate::evolution as lab;
use crate::evolution::{ENVIRONMENTS, EvolutionSettings, TrainingEnvironment};
use crate::wire::training::built_in;
use crate::wire::{self, Pace};
use proptest::prelude::*;
use proptest::sample::{select, subsequence};
use serde_json::{Value, json};
use umwelt_api::Checked;
use umwelt_api::Problems;
use umwelt_api::evolution::{self, Request, Spec};
use umwelt_api::problem::reason;

/// Settings that differ from a preset in everything that the wire can say.
fn settings() -> impl Strategy<Value = EvolutionSettings> {
    let preset = select(lab::PRESETS.to_vec());
    let environments = subsequence(ENVIRONMENTS.to_vec(), 1..=6);
    let optimizer = select(vec![
        lab::Optimizer::Genetic,
        lab::Optimizer::CmaEs,
        lab::Optimizer::EmpiricalBayes,
    ]);
    let sizes = (2..=1000usize, 1..=50usize, 1..=20usize, 1..=500usize, 2..=1000usize);
    let genetic =
        (0.0..=1.0f64, 0.0..=1.0f64, within(evolution::EXPANSION), any::<prop::sample::Index>());
    let limits = (within(evolution::MAX_DEVIATION), within(evolution::MAX_TIME), 1..=67usize);
    (preset, environments, optimizer, sizes, genetic, limits, 0..=MAX).prop_map(
        |(preset, environments, optimizer, sizes, genetic, limits, seed)| {
            let mut settings = EvolutionSettings::preset(preset).unwrap();
            settings.environments = environments
                .iter()
                .map(|name| TrainingEnvironment::preset(name).unwrap())
                .collect();
            (settings.optimizer, settings.seed) = (optimizer, seed);
            let (population, generations, trials, selection_trials, report_trials) = sizes;
            (settings.population, settings.generations, settings.trials) =
                (population, generations, trials);
            (settings.selection_trials, settings.report_trials) = (selection_trials, report_trials);
            let (one, rest, expansion, elites) = genetic;
            settings.genetic = lab::GeneticSettings {
                crossover: one,
                reproduction: (1.0 - one) * rest,
                mutation: (1.0 - one) * (1.0 - rest),
                expansion,
                elites: elites.index(population),
            };
            (settings.limits.deviation, settings.limits.time) = (limits.0, limits.1);
            settings.controller.slots = limits.2;
            settings
        },
    )
}

/// What asks for `settings`, whatever the preset.
fn asking_for(settings: &EvolutionSettings) -> Value {
    let mut spec = serde_json::to_value(wire::evolution::spec(settings, Some("mine"))).unwrap();
    // What neither preset nor request varies: noise, drive, task, and the rest of the controller.
    spec["preset"] = "thesis".into();
    spec
}

fn read(body: &Value) -> Result<(Checked<Request>, EvolutionSettings), Problems> {
    wire::evolution::read(body.to_string().as_bytes(), built_in)
}

proptest! {
    #[test]
    fn an_evolution_survives_the_wire(lab in settings()) {
        let (request, read) = read(&asking_for(&lab)).unwrap();
        prop_assert_eq!(request.prior.as_deref(), Some("mine"));
        // The horizon length is the only part of the controller in which presets differ.
        prop_assert_eq!(&read, &lab);
        prop_assert_eq!(wire::evolution::spec(&read, Some("mine")), wire::evolution::spec(&lab, Some("mine")));
        let spec = serde_json::to_string(&wire::evolution::spec(&lab, None)).unwrap();
        prop_assert_eq!(serde_json::from_str::<Spec>(&spec).unwrap(), wire::evolution::spec(&lab, None));
    }

    /// Whatever one field of a request is replaced by, what comes out can run or is refused with that field.
    #[test]
    fn nothing_gets_to_lab_that_cannot_run(lab in settings(), which in any::<prop::sample::Index>(),
                                            bad in select(vec![json!(1e308), json!(-1e-9), json!(0), json!(1), json!(u64::MAX), json!(""), Value::Null, json!([]), json!({})])) {
        let mut body = asking_for(&lab);
        let names: Vec<String> = body.as_object().unwrap().keys().cloned().collect();
        body[&names[which.index(names.len())]] = bad;
        if let Ok((_, settings)) = read(&body) {
            prop_assert_eq!(settings.check(), Ok(()));
            prop_assert!(lab::Evolution::new(settings).is_ok());
        }
    }
}

#[test]
fn presets_are_those_of_lab_and_an_empty_request_is_the_default() {
    let (request, settings) = read(&json!({})).unwrap();
    assert_eq!(Some(settings), EvolutionSettings::preset("default"));
    assert_eq!(*request, Request::default());
    for name in lab::PRESETS {
        let (request, settings) = read(&json!({ "preset": name })).unwrap();
        assert_eq!(request.preset.unwrap().name(), name);
        assert_eq!(Some(settings), EvolutionSettings::preset(name));
    }
    let bad = problems(read(&json!({"preset": "fast"})));
    assert_eq!(bad, pairs(&[(reason::MALFORMED, "preset")]));
}

#[test]
fn limits_are_those_of_lab() {
    assert_eq!(*evolution::ENVIRONMENTS.end(), lab::MAX_ENVIRONMENTS);
    assert_eq!(*evolution::POPULATION.end(), lab::MAX_POPULATION as u64);
    assert_eq!(*evolution::GENERATIONS.end(), lab::MAX_GENERATIONS as u64);
    assert_eq!(*evolution::TRIALS.end(), lab::MAX_TRIALS as u64);
    assert_eq!(*evolution::SELECTION_TRIALS.end(), lab::MAX_SELECTION_TRIALS as u64);
    assert_eq!(*evolution::REPORT_TRIALS.end(), lab::MAX_REPORT_TRIALS as u64);
    assert_eq!(evolution::MAX_EPISODES, lab::MAX_EPISODES);
    assert_eq!(evolution::MAX_BATCH, lab::MAX_BATCH);
    assert_eq!(evolution::EXPANSION.max, lab::MAX_EXPANSION);
}

/// Each value alone is refused with its own field.
#[test]
fn every_limit_of_an_evolution_is_refused_with_its_field() {
    let outside = [
        ("population", json!(1)),
        ("population", json!(1001)),
        ("generations", json!(0)),
        ("generations", json!(1001)),
        ("trials", json!(0)),
        ("trials", json!(101)),
        ("selection_trials", json!(0)),
        ("selection_trials", json!(1001)),
        ("report_trials", json!(1)),
        ("report_trials", json!(10_001)),
        ("seed", json!(1u64 << 53)),
        ("crossover_probability", json!(1.01)),
        ("reproduction_probability", json!(-0.01)),
        ("mutation_probability", json!(2)),
        ("expansion", json!(10.1)),
        ("expansion", json!(-0.1)),
        ("elites", json!(1000)),
        ("max_deviation_m", json!(0)),
        ("max_deviation_m", json!(10.1)),
        ("max_time_s", json!(0.9)),
        ("max_time_s", json!(601)),
        ("horizon_slots", json!(0)),
        ("horizon_slots", json!(68)),
        ("environments", json!([])),
        ("environments", json!((0..33).map(|i| format!("e{i}")).collect::<Vec<_>>())),
        ("prior", json!("my own")),
        ("prior", json!("")),
    ];
    for (field, value) in outside {
        let found = problems(Request::read(json!({ field: value }).to_string().as_bytes()));
        assert!(found.iter().all(|(_, name)| name == field), "{field} {value}: {found:?}");
    }
    for (field, value) in [
        ("population", json!(1000)),
        ("population", json!(2)),
        ("trials", json!(100)),
        ("generations", json!(1000)),
        ("elites", json!(39)),
        ("seed", json!(MAX)),
        ("horizon_slots", json!(67)),
        ("report_trials", json!(2)),
    ] {
        assert!(read(&json!({ field: value })).is_ok(), "{field} {value}");
    }
}

#[test]
fn all_problems_of_an_evolution_are_told_at_once() {
    let body = json!({"environments": ["normal", "moon", "normal", "Bad Link"], "populations": 5, "trials": 0,
                      "elites": 60, "crossover_probability": 0.5, "mutation_probability": 0.2, "prior": "flat"});
    let expected = pairs(&[
        (reason::UNKNOWN_FIELD, "populations"),
        (reason::REPEATED, "environments[2]"),
        (reason::INVALID_ID, "environments[3]"),
        (reason::OUT_OF_RANGE, "trials"),
        (reason::UNKNOWN_ENVIRONMENT, "environments[1]"),
        (reason::BUILT_IN, "prior"),
        (reason::INCONSISTENT, "elites"),
        (reason::INCONSISTENT, "crossover_probability"),
        (reason::INCONSISTENT, "mutation_probability"),
    ]);
    assert_eq!(problems(read(&body)), expected);
    let unknown = read(&json!({"environments": ["moon"]})).unwrap_err();
    let remedy = &unknown.details()[0].remedy;
    assert!(ENVIRONMENTS.iter().all(|name| remedy.contains(name)), "{remedy}");
}

#[test]
fn what_only_the_whole_can_say_is_said() {
    let sum = |crossover: f64| read(&json!({"crossover_probability": crossover}));
    assert!(sum(0.49 + 0.9e-9).is_ok());
    assert_eq!(
        problems(sum(0.49 + 2e-9)),
        pairs(&[(reason::INCONSISTENT, "crossover_probability")])
    );
    let elites = |population, elites| read(&json!({"population": population, "elites": elites}));
    assert!(elites(5, 4).is_ok());
    assert_eq!(problems(elites(5, 5)), pairs(&[(reason::INCONSISTENT, "elites")]));
    let episodes = |population, environments: &[&str]| {
        read(
            &json!({"population": population, "generations": 1000, "trials": 20, "environments": environments}),
        )
    };
    assert!(episodes(1000, &["normal"]).is_ok());
    let over = episodes(1000, &["normal", "bad-link"]).unwrap_err();
    assert_eq!(over.details()[0].field, "population");
    assert!(over.details()[0].remedy.contains("40000000"), "{over}");
}

/// A whole evolution, small, from request to report: what lab says is what the wire says.
#[test]
fn what_comes_of_an_evolution_is_told_unchanged() {
    let body = json!({"preset": "quick", "population": 2, "generations": 2, "trials": 1, "selection_trials": 1,
                      "report_trials": 2, "environments": ["normal"]});
    let (_, settings) = read(&body).unwrap();
    let mut lab = lab::Evolution::new(settings).unwrap();
    let queued = wire::evolution::progress(lab.settings(), None, None, Pace::default());
    assert_eq!(
        (queued.stage, queued.generation, queued.generations),
        (evolution::Stage::Queued, 0, 2)
    );
    let mut generations = Vec::new();
    while lab.report().is_none() {
        let evaluations: Vec<_> =
            lab.batch().iter().map(|it| lab::Evolution::evaluate(lab.settings(), it)).collect();
        generations.extend(lab.tell(&evaluations).unwrap());
        let fitness = generations.last().map(|it| it.fitness);
        let pace = Pace { remaining_s: Some(f64::INFINITY), ..Pace::default() };
        let progress = wire::evolution::progress(lab.settings(), Some(lab.stage()), fitness, pace);
        assert_eq!(progress.generation, generations.len() as u64);
        assert_eq!(progress.best_fitness, fitness.map(|it| it.best));
        assert_eq!(progress.remaining_s, None);
    }
    let report = lab.report().unwrap();
    let champion = evolution::Champion::from(report);
    assert_eq!(champion.prior, report.champion.into());
    assert_eq!(champion.trials, 2);
    for (wire, lab) in champion.entries.iter().zip(&report.entries) {
        assert_eq!((&wire.name, wire.fitness.mean), (&lab.name, lab.fitness.mean));
        let zero = lab.difference.is_some_and(|it| it.includes_zero());
        assert_eq!(wire.verdict.contains("includes zero"), zero, "{}", wire.verdict);
        assert_eq!(wire.environments[0].deviation_m, lab.environments[0].deviation);
    }
    let wire = evolution::Generation::from(&generations[1]);
    assert_eq!((wire.index, wire.best_fitness), (1, generations[1].fitness.best));
    assert_eq!(wire.environments[0].mean_time_s, generations[1].environments[0].time.mean);
    let event = evolution::Event::generation("evolution-1".parse().unwrap(), wire);
    assert_eq!(event.id, 2);
    let json = serde_json::to_string(&event).unwrap();
    assert_eq!(serde_json::from_str::<evolution::Event>(&json).unwrap(), event);
    let json = serde_json::to_string(&champion).unwrap();
    assert_eq!(serde_json::from_str::<evolution::Champion>(&json).unwrap(), champion);
}

#[test]
fn optimizers_are_those_of_lab() {
    use evolution::Optimizer;
    for optimizer in [Optimizer::Genetic, Optimizer::CmaEs, Optimizer::EmpiricalBayes] {
        assert_eq!(Optimizer::from(lab::Optimizer::from(optimizer)), optimizer);
    }
}
