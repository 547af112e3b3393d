#![allow(clippy::all, clippy::print_stdout, missing_docs)]
use umwelt_core::controller::Controller;
use umwelt_core::derived::{Quantity, complete};
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};
fn main() {
    let noise = PoseNoise::CAMERA;
    let known = Settings {
        noise,
        method: Method::Bayesian,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let settings = complete(known, |it| it == Quantity::MaxLinear);
    let scenario = Scenario {
        settings,
        plant: PlantModel {
            drive: Drive { lag: 0.1, dead_time: 0.03, ..settings.drive },
            slip: Slip::HARD,
            noise,
        },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(Rtt::Constant(0.04)) },
        task: Task {
            waypoints: vec![Point::new(1.0, 0.0)],
            calibration: Some(Calibration::default()),
            ..Task::thesis()
        },
        start: Pose::default(),
        region: None,
        frame: std::env::args().nth(1).unwrap().parse().unwrap(),
        time_limit: 30.0,
    };
    let mut next = 0.0;
    let (o, c) = scenario
        .drive(Controller::new(settings), 1, |row, c| {
            if row.time >= next {
                next += 0.5;
                println!("{:.2} {:?} {:?} {:?}", row.time, row.pose, row.applied, c.progress());
            }
        })
        .unwrap();
    println!("{o:?} {:?}", c.watch_state());
}
