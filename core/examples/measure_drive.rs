//! How well a drive is identified: `measure_drive [RUNS]` simulates robots whose dead time and lag are drawn from the prior,
//! in open loop, and prints how far the estimates lie off and how often the intervals hold the truth. A robot of a known
//! floor rotates three times; one whose floor and scale are drawn as well has a whole calibration.

#![allow(clippy::print_stdout, reason = "an example prints")]

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64Mcg;
use std::error::Error;
use umwelt_core::drive::{
    Commanded, DriveBelief, DriveEstimate, LONGEST, PRIOR_MEDIAN, PRIOR_SPREAD, Quantity, Stretch,
};
use umwelt_core::exchange::{Observation, PoseNoise};
use umwelt_core::geometry::{Pose, Twist};
use umwelt_core::kinematics::{self, Drive};
use umwelt_core::plant::{Plant, PlantModel, Slip, SlipChannel};
use umwelt_core::time::RobotTime;

const SLOT: f64 = 0.03;

/// Commands, each for so many slots; a stretch ends with each of these.
type Motions = Vec<Vec<(Twist, u32)>>;

/// `rotations` of 0.9 s at 0.8 rad/s and their pauses.
fn rotations(rotations: u32) -> Motions {
    let turn = |side: f64| vec![(Twist::new(0.0, 0.8 * side), 30), (Twist::ZERO, 10)];
    (0..rotations).map(|turned| turn(if turned % 2 == 0 { 1.0 } else { -1.0 })).collect()
}

/// A calibration: ten rotations, 0.3 m ahead and back.
fn calibration() -> Motions {
    let mut motions = rotations(10);
    for speed in [0.13, -0.13] {
        motions.push(vec![(Twist::new(speed, 0.0), 38)]);
        motions.push(vec![(Twist::new(speed, 0.0), 38)]);
        motions.push(vec![(Twist::ZERO, 30)]);
    }
    motions
}

/// What is believed of a robot after these motions.
fn identified(
    model: PlantModel,
    motions: &Motions,
    seed: u64,
) -> Result<DriveEstimate, Box<dyn Error>> {
    let mut plant = Plant::new(model, Pose::default(), seed)?;
    let mut belief = DriveBelief::new(model.drive.track_width);
    let (mut stretch, mut time) = (Stretch::default(), 0.0);
    let mut commands = vec![(-2.0 * LONGEST, Twist::ZERO)];
    for motion in motions {
        for &(twist, slots) in motion {
            for _ in 0..slots {
                let _ = stretch
                    .push(Observation { pose: plant.observe(), taken: RobotTime::new(time) });
                commands.push((time, twist));
                plant.advance(kinematics::inverse(&Drive::default(), twist), SLOT);
                time += SLOT;
            }
        }
        let Some((first, _)) = stretch.ends() else { continue };
        let from = first.taken.seconds() - 2.0 * LONGEST;
        let mut commanded = Commanded::new(RobotTime::new(from));
        for pair in commands.windows(2) {
            let (begins, ends) = (pair[0].0.max(from), pair[1].0);
            if ends > begins {
                commanded.add(pair[0].1, ends - begins);
            }
        }
        belief.update(&stretch, &commanded, model.noise, model.drive.track_width);
        stretch = Stretch::default();
    }
    Ok(belief.estimate())
}

fn main() -> Result<(), Box<dyn Error>> {
    let runs: u32 = std::env::args().nth(1).map_or(Ok(200), |text| text.parse())?;
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut normal = |sd: f64| -> f64 { sd * random.sample::<f64, _>(StandardNormal) };
    let holds =
        |it: Quantity, truth: f64| u32::from((it.interval.0..=it.interval.1).contains(&truth));
    println!("floor      sum off, median  95 % within  90 % intervals hold: sum, lag");
    for floor in ["hard", "dusty", "slippery"] {
        let slip = Slip::preset(floor).ok_or("no such floor")?;
        let (mut errors, mut held) = (Vec::new(), [0; 2]);
        for seed in 0..runs {
            let sum = (PRIOR_MEDIAN.ln() + normal(PRIOR_SPREAD)).exp();
            let lag = sum * (0.5 + 0.5 * normal(1.0).tanh());
            let drive = Drive { lag, dead_time: sum - lag, ..Drive::default() };
            let model =
                PlantModel { drive, slip, noise: PoseNoise::CAMERA, ..PlantModel::default() };
            let estimate = identified(model, &rotations(3), u64::from(seed))?;
            errors.push((estimate.sum.mean - sum).abs());
            held[0] += holds(estimate.sum, sum);
            held[1] += holds(estimate.lag, lag);
        }
        errors.sort_by(f64::total_cmp);
        let at = |p: f64| 1e3 * errors[(p * (runs - 1) as f64) as usize];
        let [sum, lag] = held.map(|held| 1e2 * f64::from(held) / f64::from(runs));
        println!("{floor:9} {:13.1} ms {:8.1} ms {sum:16.1} %, {lag:.1} %", at(0.5), at(0.95));
    }
    let mut held = [0; 6];
    for seed in 0..runs {
        let sum = (PRIOR_MEDIAN.ln() + normal(PRIOR_SPREAD)).exp();
        let share = (normal(1.0).abs() * 7919.0).fract();
        let (robot, floor) = ([normal(0.10), normal(0.10)], [normal(0.07), normal(0.07)]);
        let drift = [normal(0.5), normal(0.1)];
        let sd = 0.005 * 60.0_f64.powf((normal(1.0).abs() * 7919.0).fract());
        let drive = Drive { lag: sum * share, dead_time: sum * (1.0 - share), ..Drive::default() };
        let [forward, turn] = [robot[0] + floor[0], robot[1] + floor[1]];
        let slip = Slip {
            forward: SlipChannel::new(forward, sd)?,
            turn: SlipChannel::new(turn, sd)?,
            drift: SlipChannel::new((drift[0] + drift[1]).clamp(-0.99, 0.99), 1.2 * sd)?,
            lateral: SlipChannel::NONE,
        };
        let model = PlantModel { drive, slip, noise: PoseNoise::CAMERA, ..PlantModel::default() };
        let it = identified(model, &calibration(), u64::from(seed))?;
        let [of_forward, of_turn, _] = it.scale;
        for (count, (quantity, truth)) in held.iter_mut().zip([
            (it.sum, sum),
            (it.lag, drive.lag),
            (it.dead_time, drive.dead_time),
            (of_forward.together, forward),
            (of_turn.together, turn),
            (of_forward.robot, robot[0]),
        ]) {
            *count += holds(quantity, truth);
        }
    }
    println!(
        "\nrobots, floors and scales drawn, one calibration, {runs} runs: 90 % intervals hold"
    );
    for (name, held) in
        ["sum", "lag", "dead time", "forward", "turn", "the robot's part of forward"]
            .into_iter()
            .zip(held)
    {
        println!("  {name:28}{:5.1} %", 1e2 * f64::from(held) / f64::from(runs));
    }
    Ok(())
}
