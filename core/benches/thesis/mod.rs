//! The episode that the benches run: the thesis's task on a hard floor, seen by a camera.

use umwelt_core::episode::{Scenario, TIME_LIMIT};
use umwelt_core::geometry::Pose;
use umwelt_core::horizon::SLOT;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{PoseNoise, PredictorKind, Settings};
use umwelt_core::task::Task;

/// Seeds per measurement: episodes differ in length and in what the link does.
pub const SEEDS: u64 = 4;

/// The thesis's episode over the link `link`, `slots` per horizon.
pub fn scenario(link: &str, slots: usize, predictor: PredictorKind) -> Scenario {
    let settings = Settings { slots, predictor, noise: PoseNoise::CAMERA, ..Settings::default() };
    Scenario {
        settings,
        plant: PlantModel {
            drive: settings.drive,
            slip: Slip::HARD,
            noise: settings.noise,
            ..PlantModel::default()
        },
        link: LinkModel::preset(link).expect("a preset"),
        task: Task::thesis(),
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: TIME_LIMIT,
    }
}

/// Control cycles of the first [`SEEDS`] episodes together: simulated time in slots.
pub fn cycles(scenario: &Scenario) -> u64 {
    let seconds = |seed| {
        let mut end = 0.0;
        scenario.run_with(seed, |row| end = row.time).expect("a valid scenario");
        end
    };
    ((0..SEEDS).map(seconds).sum::<f64>() / SLOT).round() as u64
}

/// Runs the first [`SEEDS`] episodes.
pub fn run(scenario: &Scenario) -> f64 {
    (0..SEEDS).map(|seed| scenario.run(seed).expect("a valid scenario").time).sum()
}
