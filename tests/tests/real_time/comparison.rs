//! What a comparison says of methods is true of robots: some of it driven over HTTP in real time.

use crate::ARRIVAL;
use umwelt_api::robot::{Description, Spec};
use umwelt_api::task::Stage;
use umwelt_core::episode::Scenario;
use umwelt_lab::comparison::ComparisonSettings;
use umwelt_tests::rover::{Agent, Simulated, id};
use umwelt_tests::server::Server;

/// Robots of each contender that are driven.
const DRIVEN: u64 = 6;

/// Episodes of each contender that are simulated, on other seeds.
const SIMULATED: u64 = 200;

/// How rarely the real runs may be so far from the simulated ones by chance alone.
const CHANCE: f64 = 5e-4;

/// Completion time in s and largest deviation in m, as observed.
type Run = [f64; 2];

fn simulate(scenario: &Scenario, seed: u64) -> Run {
    let (outcome, controller) = scenario.run_with(seed, |_| {}).unwrap();
    assert!(outcome.arrived, "seed {seed}: {outcome:?}");
    [outcome.time, controller.progress().max_deviation]
}

/// Drives every scenario with [`DRIVEN`] seeds, all at once, each robot with an agent of its own.
async fn drive(scenarios: &[(&str, Scenario)]) -> Vec<Vec<Run>> {
    let server = Server::start();
    let mut agents = Vec::new();
    for (place, (_, scenario)) in scenarios.iter().enumerate() {
        for seed in 0..DRIVEN {
            let robot = id(&format!("contender-{place}-{seed}"));
            server
                .client
                .put_robot(&robot, &Description::from(&Spec::from(&scenario.settings)))
                .await
                .unwrap();
            server.client.set_task(&robot, &(&scenario.task).into()).await.unwrap();
            let link = Some(scenario.link.clone());
            let simulated = Simulated { plant: scenario.plant, start: scenario.start, link, seed };
            agents.push((place, robot.clone(), Agent::start(&server.url(), &robot, simulated)));
        }
    }
    let mut runs = vec![Vec::new(); scenarios.len()];
    for (place, robot, mut agent) in agents {
        agent.until("it arrives", 2 * ARRIVAL, |now| now.stage == Some(Stage::Arrived)).await;
        let progress = server.client.get_task(&robot).await.unwrap().progress;
        runs[place].push([progress.elapsed_s, progress.max_deviation_m]);
        let _ = agent.end().await;
    }
    runs
}

/// The exact permutation test of Wilcoxon's rank sum, two-sided, ties by midranks: how often as many values drawn from
/// all of them without looking have a rank sum at least as far from its expectation as that of `few`.
fn chance(few: &[f64], many: &[f64]) -> f64 {
    let all: Vec<f64> = few.iter().chain(many).copied().collect();
    // Twice the midrank, a whole number: values below, and values not above.
    let rank = |value: f64| {
        let below = all.iter().filter(|other| **other < value).count();
        let not_above = all.iter().filter(|other| **other <= value).count();
        below + not_above + 1
    };
    let ranks: Vec<usize> = all.iter().map(|value| rank(*value)).collect();
    let observed: usize = ranks[..few.len()].iter().sum();
    let most = few.len() * (2 * all.len() + 1);
    // ways[n][s]: subsets of n values whose ranks sum to s.
    let mut ways = vec![vec![0.0; most + 1]; few.len() + 1];
    ways[0][0] = 1.0;
    for rank in ranks {
        for size in (1..=few.len()).rev() {
            for sum in (rank..=most).rev() {
                ways[size][sum] += ways[size - 1][sum - rank];
            }
        }
    }
    let expected = few.len() * (all.len() + 1);
    let distance = observed.abs_diff(expected);
    let of_size = &ways[few.len()];
    let far: f64 =
        (0..=most).filter(|sum| sum.abs_diff(expected) >= distance).map(|sum| of_size[sum]).sum();
    far / of_size.iter().sum::<f64>()
}

#[test]
fn the_test_of_ranks_is_exact() {
    // 1 2 against 3 4 5: of the ten pairs, {1, 2} and {4, 5} are as far out.
    assert!((chance(&[1.0, 2.0], &[3.0, 4.0, 5.0]) - 0.2).abs() < 1e-12);
    assert!((chance(&[1.0, 5.0], &[2.0, 3.0, 4.0]) - 1.0).abs() < 1e-12);
    assert_eq!(chance(&[1.0; 3], &[1.0; 5]), 1.0);
    let many: Vec<f64> = (0..200).map(f64::from).collect();
    assert!(chance(&[300.0; 6], &many) < 1e-9);
    assert!(chance(&[20.0, 60.0, 90.0, 110.0, 150.0, 180.0], &many) > 0.5);
}

/// Guards against: a comparison that is true of its simulation alone. The thesis's bad link, calibration first; the
/// method that it suffers with most, and the one that bridges it.
#[tokio::test(flavor = "multi_thread")]
async fn real_runs_fall_within_the_simulated_distribution() {
    let thesis = ComparisonSettings::scenario("thesis").unwrap();
    let bad = thesis.environments.iter().find(|it| it.name == "bad-link").unwrap();
    let scenario = |label: &'static str| {
        let contender = thesis.contenders.iter().find(|it| it.label() == label).unwrap();
        (label, thesis.episode(bad, contender.settings(&thesis.controller)))
    };
    let scenarios = ["statistic/1", "bayesian-default/20"].map(scenario);
    let driven = drive(&scenarios).await;
    for ((label, scenario), driven) in scenarios.iter().zip(driven) {
        let simulated: Vec<Run> =
            (1000..1000 + SIMULATED).map(|seed| simulate(scenario, seed)).collect();
        for (index, what) in ["time", "deviation"].into_iter().enumerate() {
            let of = |runs: &[Run]| runs.iter().map(|run| run[index]).collect::<Vec<_>>();
            let chance = chance(&of(&driven), &of(&simulated));
            println!("{label}, {what}: {:.3?}, chance {chance:.3}", of(&driven));
            assert!(chance > CHANCE, "{label}, {what}: {driven:?} by chance {chance}");
        }
    }
}
