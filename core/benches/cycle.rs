//! What one closed-loop control cycle of 30 ms costs in an episode: controller, link and plant.
//!
//! `cargo bench -p umwelt-core` measures and writes the table; see the bench `table`.

mod thesis;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use thesis::{cycles, run, scenario};
use umwelt_core::settings::PredictorKind;

fn cycle(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cycle");
    group.sampling_mode(SamplingMode::Flat).sample_size(100);
    group.warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(5));
    for slots in [1, 20] {
        for link in ["normal", "bad"] {
            let scenario = scenario(link, slots, PredictorKind::Moments);
            group.throughput(Throughput::Elements(cycles(&scenario)));
            group.bench_function(format!("{slots}-{link}"), |bencher| {
                bencher.iter(|| run(black_box(&scenario)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, cycle);
criterion_main!(benches);
