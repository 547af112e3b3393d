//! What the Monte-Carlo predictor costs beside the moments: a prediction by itself, and an episode's control cycle.

mod thesis;

use criterion::{BatchSize, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use thesis::{cycles, run, scenario};
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::{Pose, Twist};
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics::Kind;
use umwelt_core::prediction::{Agents, ChannelModel, ErrorModel, Moments, Motion};
use umwelt_core::settings::{PoseNoise, PredictorKind};

const AGENTS: [usize; 3] = [100, 1000, 10_000];

/// Slots predicted: the loop delay, which every request predicts.
const AHEAD: usize = 8;

const CELL: f64 = 0.005;

fn prediction(criterion: &mut Criterion) {
    let channel = ChannelModel::known(-0.05, 0.01);
    let model = ErrorModel { forward: channel, lateral: channel, turn: channel, drift: channel };
    let (pose, noise) = (Pose::default(), PoseNoise::CAMERA);
    let motion = Motion::new(Twist::new(0.1, 0.2), SLOT);
    let mut group = criterion.benchmark_group("prediction");
    group.sample_size(50).measurement_time(Duration::from_secs(3));
    group.bench_function("moments", |bencher| {
        bencher.iter(|| {
            let mut moments = Moments::new(Kind::Differential, black_box(pose), noise);
            (0..AHEAD).for_each(|_| moments.advance(black_box(&model), motion));
            moments.spread()
        });
    });
    for agents in AGENTS {
        group.bench_function(format!("monte-carlo-{agents}"), |bencher| {
            bencher.iter_batched(
                || pose,
                |pose| {
                    let mut agents =
                        Agents::new(Kind::Differential, pose, noise, &model, agents, CELL, 1);
                    (0..AHEAD).for_each(|_| agents.advance(black_box(motion)));
                    agents.spread()
                },
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

/// The beginning of the episode only, because ten thousand agents take their time.
fn cycle(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("monte-carlo-cycle");
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    for (slots, agents) in [(1, 100), (1, 1000), (1, 10_000), (20, 100), (20, 1000)] {
        let predictor = PredictorKind::MonteCarlo { agents, cell: CELL, seed: 1 };
        let scenario = Scenario { time_limit: 3.0, ..scenario("normal", slots, predictor) };
        group.throughput(Throughput::Elements(cycles(&scenario)));
        group.bench_function(format!("{slots}-{agents}"), |bencher| {
            bencher.iter(|| run(black_box(&scenario)));
        });
    }
    group.finish();
}

criterion_group!(benches, prediction, cycle);
criterion_main!(benches);
