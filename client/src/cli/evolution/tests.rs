//! How evolutions are shown.

use super::*;
use crate::cli::job::noun::listed;
use crate::samples::EVOLUTION;
use umwelt_api::evolution::{
    Champion, Entry, EnvironmentResult, Estimate, Generation, GenerationEnvironment, Ranking,
};
use umwelt_api::evolution::{Outcome, Page};
use umwelt_api::robot::Prior;

fn evolution() -> Evolution {
    serde_json::from_str(EVOLUTION).unwrap()
}

fn estimate(mean: f64, half: f64) -> Estimate {
    Estimate { mean, low: mean - half, high: mean + half }
}

fn entry(name: &str, fitness: f64, difference: Option<Estimate>) -> Entry {
    let result = |environment: &str, fitness: f64| EnvironmentResult {
        environment: environment.to_owned(),
        fitness: estimate(fitness, 0.02),
        time_s: 21.25,
        deviation_m: 0.0123,
        arrived: 0.995,
    };
    Entry {
        name: name.to_owned(),
        prior: Prior::default(),
        fitness: estimate(fitness, 0.03),
        difference,
        environments: vec![result("normal", fitness), result("bad-link", 1.0)],
        verdict: "in the words of the server".to_owned(),
        champion_is: difference.map(|it| match it.mean {
            _ if it.includes_zero() => Ranking::NoDifference,
            mean if mean > 0.0 => Ranking::Better,
            _ => Ranking::Worse,
        }),
        champion_worse_in: if fitness > 1.36 { vec!["normal".to_owned()] } else { Vec::new() },
    }
}

fn champion() -> Champion {
    Champion {
        prior: Prior::default(),
        trials: 400,
        notes: Vec::new(),
        entries: vec![
            entry("champion", 1.32, None),
            entry("first-generation", 1.3, Some(estimate(0.02, 0.05))),
            entry("default", 1.1, Some(estimate(0.22, 0.05))),
            entry("flat", 1.4, Some(estimate(-0.08, 0.05))),
        ],
    }
}

#[test]
fn what_an_earlier_server_says_in_words_alone_is_shown_as_it_is() {
    let mut champion = champion();
    champion.entries[2].champion_is = None;
    assert!(report::text(&champion).contains("in the words of the server"));
}

#[test]
fn a_report_says_where_the_interval_includes_zero() {
    let text = report::text(&champion());
    let expected = "\
on 400 fresh trials in each environment, intervals hold with 95 %:
PRIOR             FITNESS          WITHIN  CHAMPION MINUS THIS            WITHIN  VERDICT
champion            1.320  1.290 .. 1.350                    -                 -
first-generation    1.300  1.270 .. 1.330                0.020   -0.030 .. 0.070  includes zero: no difference shown
default             1.100  1.070 .. 1.130                0.220    0.170 .. 0.270  the champion is better
flat                1.400  1.370 .. 1.430               -0.080  -0.130 .. -0.030  the champion is worse; worse in normal
";
    assert!(text.starts_with(expected), "{text}");
    let environments = "\
ENVIRONMENT  PRIOR             FITNESS          WITHIN    TIME  DEVIATION  ARRIVED
normal       champion            1.320  1.300 .. 1.340  21.2 s    12.3 mm   99.5 %
             first-generation";
    assert!(text.contains(environments), "{text}");
    assert!(text.contains("\nforward  0.0000  1.000  4.000  4.500e-2  0.1500\n"), "{text}");
}

/// Guards against 0.0 s and 0.0 mm of robots that stood still.
#[test]
fn without_arrivals_there_is_neither_time_nor_deviation() {
    let mut champion = champion();
    for entry in &mut champion.entries {
        let result = &mut entry.environments[1];
        (result.arrived, result.time_s, result.deviation_m) = (0.0, 0.0, 0.0);
    }
    champion.notes = vec!["in bad-link nobody arrives".to_owned()];
    let text = report::text(&champion);
    assert_eq!(text.matches("-          -  0.000 %\n").count(), 4, "{text}");
    assert!(!text.contains("0.0 s ") && !text.contains(" 0.0 mm"), "{text}");
    assert!(text.contains("\nnote: in bad-link nobody arrives\n"), "{text}");
}

#[test]
fn the_servers_ranking_is_shown_whatever_the_numbers_are() {
    let mut champion = champion();
    champion.entries[2].champion_is = Some(Ranking::NoDifference);
    champion.entries[2].champion_worse_in = vec!["bad-link".to_owned()];
    let text = report::text(&champion);
    assert!(text.contains("includes zero: no difference shown; worse in bad-link"), "{text}");
}

#[test]
fn an_evolution_is_shown_with_what_was_asked_for_and_what_it_found() {
    assert_eq!(
        EvolutionKind::show(&evolution()),
        "\
evolution-12: queued, waiting for its turn
  environments normal
  search       genetic, 12 generations of 24, 2 trials each, seed 1, 1 slots
  episodes     0 of 1000, 0.0 s
  prior        mine, once there is a champion
"
    );
    let succeeded = Evolution {
        state: State::Succeeded,
        interrupted: 2,
        outcome: Outcome { prior: "mine".parse().ok(), champion: Some(champion()) },
        ..evolution()
    };
    let text = EvolutionKind::show(&succeeded);
    assert!(text.contains("resumed after 2 restarts of the server"), "{text}");
    assert!(text.contains("mine; use it: umwelt robot set ID --prior mine"), "{text}");
    assert!(text.contains("VERDICT"), "{text}");
    let error = Some("no space left".to_owned());
    let failed = Evolution { state: State::Failed, error, ..evolution() };
    assert!(EvolutionKind::show(&failed).contains("error        no space left\n"));
    assert!(EvolutionKind::show(&failed).contains("none; it was to be mine"));
}

#[test]
fn progress_says_generation_best_mean_and_time_left() {
    let at = Progress {
        stage: Stage::Generations,
        generation: 5,
        best_fitness: Some(1.32),
        mean_fitness: Some(1.1041),
        remaining_s: Some(12.34),
        ..evolution().progress
    };
    assert_eq!(EvolutionKind::words(&at), "generation 5/12, best 1.320, mean 1.104, 12.3 s left");
    let done = Progress { stage: Stage::Done, remaining_s: Some(0.0), ..at };
    assert_eq!(EvolutionKind::words(&done), "12 generations, best 1.320, mean 1.104");
}

#[test]
fn evolutions_and_generations_are_tables() {
    let running = Evolution {
        state: State::Running,
        progress: Progress {
            generation: 5,
            best_fitness: Some(1.32),
            elapsed_s: 75.0,
            ..evolution().progress
        },
        ..evolution()
    };
    let page = Page { jobs: vec![running, evolution()], ..Page::default() };
    assert_eq!(
        listed(&page),
        "\
EVOLUTION     STATE    GENERATION   BEST  MEAN  RAN FOR  OPTIMIZER  SEED  PRIOR
evolution-12  running        5/12  1.320     -    1 min  genetic       1  -
evolution-12  queued         0/12      -     -    0.0 s  genetic       1  -
"
    );
    let environment = |name: &str| GenerationEnvironment {
        environment: name.to_owned(),
        best_deviation_m: 0.01,
        mean_deviation_m: 0.0234,
        best_time_s: 20.0,
        mean_time_s: 31.57,
        arrived: 0.75,
    };
    let dead = GenerationEnvironment {
        arrived: 0.0,
        best_deviation_m: 0.0,
        best_time_s: 0.0,
        ..environment("dead")
    };
    let generation = Generation {
        index: 3,
        best_fitness: 1.5,
        mean_fitness: 1.25,
        prior: Prior::default(),
        environments: vec![environment("normal"), environment("bad-link"), dead],
    };
    let page = GenerationsPage { generations: vec![generation], next_page_token: None };
    assert_eq!(
        generations_table(&page),
        "\
GENERATION   BEST   MEAN  ENVIRONMENT  BEST DEVIATION  MEAN DEVIATION  BEST TIME  MEAN TIME  ARRIVED
         3  1.500  1.250  normal              10.0 mm         23.4 mm     20.0 s     31.6 s   75.0 %
                          bad-link            10.0 mm         23.4 mm     20.0 s     31.6 s   75.0 %
                          dead                      -               -          -          -  0.000 %
"
    );
    assert_eq!(listed(&Page::default()) + &generations_table(&GenerationsPage::default()), "");
}
