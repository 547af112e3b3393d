//! How well a dead band is identified: `measure_dead_band [RUNS]` simulates robots whose dead band is drawn from the prior,
//! and lag and dead time too, which calibrate and drive a corner, and prints how often the 90 % interval holds the truth, how
//! wide it is, and what the task takes.

#![allow(clippy::print_stdout, reason = "an example prints")]

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::error::Error;
use umwelt_core::derived::complete;
use umwelt_core::drive::DeadBand;
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{LinkModel, Rtt};
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Settings};
use umwelt_core::task::{Calibration, Task};

/// A robot with this `dead_band`, of which only wheels, track and noise are known.
fn scenario(dead_band: f64, drive: Drive, slip: Slip, is_calibrated: bool) -> Scenario {
    let known = Settings {
        noise: PoseNoise::CAMERA,
        method: Method::Adaptive,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    let waypoints = vec![Point::new(0.8, 0.0), Point::new(0.8, 0.3)];
    let calibration = is_calibrated.then(Calibration::default);
    Scenario {
        settings: complete(known, |_| false),
        plant: PlantModel { drive, slip, noise: PoseNoise::CAMERA, dead_band },
        link: LinkModel { sensor_delay: 0.05, ..LinkModel::ordinary(Rtt::Constant(0.04)) },
        task: Task { waypoints, calibration, ..Task::thesis() },
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: 120.0,
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(200), |text| text.parse())?;
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let mut uniform = || random.random::<f64>();
    let prior = DeadBand::default();
    println!(
        "floor     calibrated  90 % holds  of those below 0.2 rad/s  of those above  width there, median  not arrived  time, median and p90"
    );
    for (floor, is_calibrated) in
        [("hard", true), ("dusty", true), ("slippery", true), ("hard", false)]
    {
        let slip = Slip::preset(floor).ok_or("no such floor")?;
        let (mut held, mut all, mut widths, mut times, mut lost) =
            ([0; 2], [0; 2], Vec::new(), Vec::new(), 0);
        for seed in 0..runs {
            let band = prior.quantile(uniform());
            let (lag, dead_time) = (0.06 + 0.1 * uniform(), 0.04 * uniform());
            let drive = Drive { lag, dead_time, ..Drive::default() };
            let (outcome, controller) =
                scenario(band, drive, slip, is_calibrated).run_with(seed, |_| {})?;
            let it = controller.drive_estimate().ok_or("it is identified")?.dead_band;
            let (low, high) = it.interval;
            let has_one = usize::from(band >= 0.2);
            all[has_one] += 1;
            held[has_one] += u32::from((low..=high).contains(&band));
            if has_one == 1 {
                widths.push(high - low);
            }
            if outcome.arrived { times.push(outcome.time) } else { lost += 1 }
        }
        let part = |held: u32, all: u32| 1e2 * f64::from(held) / f64::from(all);
        widths.sort_by(f64::total_cmp);
        times.sort_by(f64::total_cmp);
        println!(
            "{floor:9} {:10} {:9.1} % {:22.1} % {:13.1} % {:14.2} rad/s {lost:12} {:10.1} s {:.1} s",
            if is_calibrated { "yes" } else { "no" },
            part(held[0] + held[1], all[0] + all[1]),
            part(held[0], all[0]),
            part(held[1], all[1]),
            widths[widths.len() / 2],
            times[times.len() / 2],
            times[times.len() * 9 / 10],
        );
    }
    Ok(())
}
