//! The whole of an evolution: what it says, and that its result does not show how it was run.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeSet;
use umwelt_core::conjugate::SampleStatistics;
use umwelt_core::geometry::Point;
use umwelt_core::task::Task;

/// Small enough to run in a test, with a task of a single leg.
fn small(optimizer: Optimizer) -> EvolutionSettings {
    let quick = EvolutionSettings::preset("quick").unwrap();
    EvolutionSettings {
        optimizer,
        population: 6,
        generations: 3,
        trials: 1,
        selection_trials: 2,
        report_trials: 4,
        task: Task { waypoints: vec![Point::new(0.2, 0.0)], calibration: None, ..Task::thesis() },
        ..quick
    }
}

/// The same, its state written down and read again.
fn stored(evolution: &Evolution) -> Evolution {
    let text = serde_json::to_string(evolution.state()).unwrap();
    Evolution::resume(evolution.settings().clone(), serde_json::from_str(&text).unwrap()).unwrap()
}

/// Goes on to the end, shows each generation, and stores and loads the state after each step if asked to.
fn run(mut evolution: Evolution, is_stored: bool) -> (Evolution, Vec<Generation>) {
    let mut generations = Vec::new();
    while evolution.report().is_none() {
        let mut evaluations: Vec<_> = evolution.batch().iter().map(|it| (*it, None)).collect();
        // In an order that no single thread would take.
        for (episode, evaluation) in evaluations.iter_mut().rev() {
            *evaluation = Some(Evolution::evaluate(evolution.settings(), episode));
        }
        let evaluations: Vec<_> = evaluations.into_iter().filter_map(|(_, it)| it).collect();
        generations.extend(evolution.tell(&evaluations).unwrap());
        if is_stored {
            evolution = stored(&evolution);
        }
    }
    (evolution, generations)
}

#[test]
fn resumed_after_every_step_is_the_same_as_uninterrupted_bit_for_bit() {
    for optimizer in [Optimizer::Genetic, Optimizer::CmaEs, Optimizer::EmpiricalBayes] {
        let evolution = Evolution::new(small(optimizer)).unwrap();
        let (uninterrupted, generations) = run(evolution.clone(), false);
        assert_eq!(run(evolution, true), (uninterrupted.clone(), generations), "{optimizer:?}");
        assert_eq!(uninterrupted.episodes(), uninterrupted.total_episodes(), "{optimizer:?}");
        assert!(uninterrupted.batch().is_empty());
    }
}

/// Four threads that take episodes as they come, against one.
#[test]
fn the_champion_is_the_same_whatever_the_number_of_threads() {
    let mut evolution = Evolution::new(small(Optimizer::Genetic)).unwrap();
    let alone = run(evolution.clone(), false).0;
    while evolution.report().is_none() {
        let batch = evolution.batch();
        let shares: Vec<Vec<(usize, Episode)>> = (0..4)
            .map(|i| batch.iter().copied().enumerate().skip(i).step_by(4).collect())
            .collect();
        let mut evaluations = vec![Evaluation::default(); batch.len()];
        std::thread::scope(|scope| {
            let evaluate = |share: Vec<(usize, Episode)>| {
                let settings = evolution.settings();
                scope.spawn(move || {
                    let each =
                        share.into_iter().map(|(at, it)| (at, Evolution::evaluate(settings, &it)));
                    each.collect::<Vec<_>>()
                })
            };
            let threads: Vec<_> = shares.into_iter().map(evaluate).collect();
            for (at, evaluation) in threads.into_iter().flat_map(|it| it.join().unwrap()) {
                evaluations[at] = evaluation;
            }
        });
        evolution.tell(&evaluations).unwrap();
    }
    assert_eq!(evolution, alone);
}

#[test]
fn another_seed_is_another_evolution() {
    let settings = small(Optimizer::Genetic);
    let one = run(Evolution::new(settings.clone()).unwrap(), false).0;
    let other = run(Evolution::new(EvolutionSettings { seed: 2, ..settings }).unwrap(), false).0;
    assert_ne!(one.report(), other.report());
}

/// Guards against a champion reported on the seeds that made it champion, or individuals compared on different ones.
#[test]
fn seeds_are_common_within_a_generation_and_fresh_for_everything_else() {
    let mut evolution = Evolution::new(small(Optimizer::Genetic)).unwrap();
    let mut seen = BTreeSet::new();
    let mut stages = Vec::new();
    while evolution.report().is_none() {
        let batch = evolution.batch();
        let mut seeds: Vec<BTreeSet<u64>> = Vec::new();
        for subject in batch.chunk_by(|one, other| one.subject == other.subject) {
            seeds.push(subject.iter().map(|it| it.seed).collect());
        }
        assert!(seeds.windows(2).all(|pair| pair[0] == pair[1]), "{:?}", evolution.stage());
        assert!(seeds[0].iter().all(|seed| seen.insert(*seed)), "{:?}", evolution.stage());
        stages.push(evolution.stage());
        let evaluations: Vec<_> =
            batch.iter().map(|it| Evolution::evaluate(evolution.settings(), it)).collect();
        evolution.tell(&evaluations).unwrap();
    }
    let generations = (0..3).map(|generation| Stage::Generations { generation });
    let expected: Vec<_> = std::iter::once(Stage::Reference)
        .chain(generations)
        .chain([Stage::Selection, Stage::Report])
        .collect();
    assert_eq!(stages, expected);
}

/// What fitness says is said by hand: weights, units, the mean over trials.
#[test]
fn fitness_is_normalised_to_fixed_normal_and_weighted() {
    let mut settings = small(Optimizer::Genetic);
    settings.trials = 2;
    settings.environments[1].weight = 3.0;
    let mut evolution = Evolution::new(settings).unwrap();
    let evaluation = |time: f64, deviation: f64| Evaluation {
        arrived: true,
        time,
        deviation,
        ..Default::default()
    };
    // Fixed-normal takes 10 s on the normal link and strays by 20 mm on the bad one.
    let reference =
        [vec![evaluation(10.0, 0.001); 200], vec![evaluation(20.0, 0.02); 200]].concat();
    evolution.tell(&reference).unwrap();
    let near = |found: &[f64], expected: [f64; 2]| {
        assert_eq!(found.len(), 2);
        let pairs = found.iter().zip(expected);
        pairs.for_each(|(one, other)| assert!((one - other).abs() < 1e-9, "{found:?}"));
    };
    near(&evolution.state.units, [0.1, 50.0]);
    // One individual: 5 s and never; 10 mm and too late.
    let trials = [
        evaluation(5.0, 0.01),
        evaluation(5.0, 0.2),
        evaluation(20.0, 0.01),
        evaluation(61.0, 0.01),
    ];
    // Normal: (2 + 0)/2 = 1; bad: (2 + 0)/2 = 1, three times.
    let other = [
        evaluation(10.0, 0.01),
        evaluation(10.0, 0.01),
        evaluation(20.0, 0.1),
        evaluation(20.0, 0.1),
    ];
    let fitness = evolution.fitness(2, &[trials, other].concat());
    near(&fitness, [1.0, (1.0 + 3.0 * 0.2) / 4.0]);
}

#[test]
fn where_fixed_normal_has_no_fitness_the_limit_is_the_unit() {
    let mut evolution = Evolution::new(small(Optimizer::Genetic)).unwrap();
    evolution.tell(&vec![Evaluation::default(); 400]).unwrap();
    assert_eq!(evolution.state.units, [1.0 / 60.0, 10.0]);
}

#[test]
fn evaluations_of_another_batch_are_refused_and_change_nothing() {
    let mut evolution = Evolution::new(small(Optimizer::Genetic)).unwrap();
    let before = evolution.clone();
    let refused = evolution.tell(&[Evaluation::default(); 3]);
    assert_eq!(refused, Err(TellError { given: 3, asked: 400 }));
    assert_eq!(evolution, before);
}

/// Selection is by fresh trials alone: the candidate that drives best in them is the champion, whatever it was before.
#[test]
fn the_champion_is_the_best_of_the_candidates_on_fresh_seeds() {
    let mut evolution = Evolution::new(small(Optimizer::Genetic)).unwrap();
    let evaluation =
        |time: f64| Evaluation { arrived: true, time, deviation: 0.01, ..Default::default() };
    evolution.tell(&vec![evaluation(10.0); 400]).unwrap();
    for _ in 0..3 {
        let batch = evolution.batch();
        evolution.tell(&vec![evaluation(10.0); batch.len()]).unwrap();
    }
    assert_eq!(evolution.stage(), Stage::Selection);
    let (batch, favourite) = (evolution.batch(), evolution.state.candidates[1].clone());
    let evaluations: Vec<_> =
        batch.iter().map(|it| evaluation(if it.subject == 1 { 9.0 } else { 10.0 })).collect();
    evolution.tell(&evaluations).unwrap();
    assert_eq!(evolution.state.champion, Some(favourite));
}

/// The prior that is checked in is still what it was evolved for: careful on the bad link, and not for nothing.
#[test]
fn the_thesis_prior_halves_the_deviation_on_the_bad_link() {
    let settings = EvolutionSettings::preset("thesis").unwrap();
    let evolution = Evolution::new(settings).unwrap();
    let drive = |prior| {
        let mut evolution = evolution.clone();
        evolution.state.stage = Stage::Selection;
        evolution.state.candidates = vec![genome::of_prior(&prior, false)];
        let batch = evolution.batch();
        let bad = batch.iter().filter(|it| it.environment == 1).take(60);
        let evaluations: Vec<_> =
            bad.map(|it| Evolution::evaluate(evolution.settings(), it)).collect();
        assert!(evaluations.iter().all(|it| it.arrived && it.time <= 60.0));
        evaluations.iter().map(|it| it.deviation).sum::<f64>() / 60.0
    };
    let [careful, weak] = [Prior::thesis(), Prior::default()].map(drive);
    assert!(careful < 0.6 * weak, "{careful} {weak}");
}

/// Goes on as [`run`] does, with evaluations that are made up; what it says in the end, and how many generations.
fn made_up(
    mut evolution: Evolution,
    evaluation: impl Fn(Stage) -> Evaluation,
) -> (Evolution, usize) {
    let mut generations = 0;
    while evolution.report().is_none() && evolution.failure().is_none() {
        let evaluations = vec![evaluation(evolution.stage()); evolution.batch().len()];
        generations += usize::from(evolution.tell(&evaluations).unwrap().is_some());
        evolution = stored(&evolution);
    }
    (evolution, generations)
}

/// Guards against a prior that was drawn at random, offered as what an evolution has found.
#[test]
fn where_no_robot_arrives_there_is_no_report_but_a_reason() {
    for optimizer in [Optimizer::Genetic, Optimizer::CmaEs, Optimizer::EmpiricalBayes] {
        for (generations, enough) in [(2, 2), (9, GENERATIONS_WITHOUT_ARRIVAL)] {
            let settings = EvolutionSettings { generations, ..small(optimizer) };
            let evolution = Evolution::new(settings).unwrap();
            let (evolution, driven) = made_up(evolution, |_| Evaluation::default());
            assert_eq!(driven, enough, "{optimizer:?}");
            assert_eq!((evolution.report(), evolution.batch()), (None, Vec::new()));
            let reason = evolution.failure().unwrap().to_string();
            assert!(reason.starts_with("nobody arrives in normal, bad-link: "), "{reason}");
            assert!(reason.contains(&format!("none of {} episodes", evolution.episodes())));
        }
    }
}

/// One arrival is hope; a champion that never keeps the limits is none.
#[test]
fn a_champion_without_fitness_is_no_champion() {
    let arrives = Evaluation { arrived: true, time: 10.0, deviation: 0.01, ..Default::default() };
    let evolution = Evolution::new(small(Optimizer::Genetic)).unwrap();
    let (done, generations) = made_up(evolution.clone(), |_| arrives);
    assert!(done.report().is_some() && done.failure().is_none() && generations == 3);
    let too_late = Evaluation { time: 1e3, deviation: 1.0, ..arrives };
    for (last, arrived) in [(too_late, 1.0), (Evaluation::default(), 0.0)] {
        let of_stage = |stage| if stage == Stage::Report { last } else { arrives };
        let (failed, generations) = made_up(evolution.clone(), of_stage);
        assert_eq!((failed.report(), generations), (None, 3));
        let environments = "normal, bad-link".to_owned();
        let reason = Failure::ChampionFails { environments, trials: 8, arrived };
        assert_eq!(failed.failure(), Some(&reason));
    }
}

/// A state of the program before this one does not say who arrived: it is not given up for that.
#[test]
fn a_state_that_does_not_count_arrivals_is_not_given_up() {
    let mut evolution = Evolution::new(small(Optimizer::Genetic)).unwrap();
    let mut old = serde_json::to_value(evolution.state()).unwrap();
    let fields = old.as_object_mut().unwrap();
    assert!(fields.remove("arrivals").is_some() && fields.remove("hopeless").is_some());
    let settings = evolution.settings().clone();
    evolution = Evolution::resume(settings, serde_json::from_value(old).unwrap()).unwrap();
    while evolution.stage() != Stage::Selection {
        let evaluations = vec![Evaluation::default(); evolution.batch().len()];
        evolution.tell(&evaluations).unwrap();
        assert_eq!(evolution.failure(), None);
    }
}

/// Guards against an episode that a worker in another process drives otherwise, or whose numbers come back rounded.
#[test]
fn episodes_and_evaluations_pass_as_json_bit_for_bit() {
    for optimizer in [Optimizer::Genetic, Optimizer::CmaEs, Optimizer::EmpiricalBayes] {
        let mut evolution = Evolution::new(small(optimizer)).unwrap();
        while evolution.report().is_none() {
            let (batch, settings) = (evolution.batch(), evolution.settings());
            let evaluations: Vec<_> =
                batch.iter().map(|it| Evolution::evaluate(settings, it)).collect();
            assert_eq!(sent(&batch), batch);
            assert_eq!(sent(&evaluations), evaluations);
            let last = batch.len() - 1;
            assert_eq!(Evolution::evaluate(settings, &sent(&batch[last])), evaluations[last]);
            evolution.tell(&evaluations).unwrap();
        }
    }
}

/// What comes back of `value` as JSON, the same text again.
fn sent<T: serde::Serialize + serde::de::DeserializeOwned>(value: &T) -> T {
    let text = serde_json::to_string(value).unwrap();
    let read: T = serde_json::from_str(&text).unwrap();
    assert_eq!(serde_json::to_string(&read).unwrap(), text);
    read
}

proptest! {
    #[test]
    fn any_evaluation_passes_as_json_bit_for_bit(
        arrived: bool,
        numbers in proptest::array::uniform5(proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL),
        samples: u64,
    ) {
        let [time, deviation, weight, mean, squares] = numbers;
        let statistics = SampleStatistics { samples, weight, mean, squares };
        let evaluation = Evaluation { arrived, time, deviation, samples: [statistics; 4] };
        let bits = |it: &Evaluation| {
            let SampleStatistics { weight, mean, squares, .. } = it.samples[3];
            [it.time, it.deviation, weight, mean, squares].map(f64::to_bits)
        };
        prop_assert_eq!(bits(&sent(&evaluation)), bits(&evaluation));
    }
}
