//! A control cycle allocates nothing: an episode of twice the length allocates as often.

use allocation_counter::measure;
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::link::LinkModel;
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{PoseNoise, Settings};
use umwelt_core::task::Task;

/// Allocations of an episode that its time limit ends.
fn allocations(link: &str, slots: usize, time_limit: f64) -> u64 {
    let settings = Settings { slots, noise: PoseNoise::CAMERA, ..Settings::default() };
    let far = Task { waypoints: vec![Point::new(100.0, 0.0)], ..Task::thesis() };
    let scenario = Scenario {
        settings,
        plant: PlantModel {
            drive: settings.drive,
            slip: Slip::HARD,
            noise: settings.noise,
            ..PlantModel::default()
        },
        link: LinkModel::preset(link).expect("a preset"),
        task: far,
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit,
    };
    let mut end = 0.0;
    let allocated = measure(|| {
        scenario.run_with(7, |row| end = row.time).expect("a valid scenario");
    });
    assert!(end > time_limit - 0.1, "the limit ends it");
    assert_eq!(allocated.count_current, 0, "nothing is kept");
    allocated.count_total
}

#[test]
fn a_cycle_allocates_nothing() {
    for link in ["clean", "normal", "bad"] {
        for slots in [1, 20] {
            let (short, long) = (allocations(link, slots, 1.0), allocations(link, slots, 60.0));
            assert_eq!(short, long, "{link}, {slots} slots: 33 cycles and 2000");
            assert!(short > 0, "the counter counts");
        }
    }
}
