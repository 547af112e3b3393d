//! Records a simulated robot that somebody drives about, as CSV for `umwelt identify`: poses to one file, commands to
//! another.
//!
//! `cargo run --release -p umwelt-core --example record_drive -- POSES.csv COMMANDS.csv [NAME=VALUE ...]`, where a name is
//! one of those in [`Options`].

#![allow(clippy::disallowed_types, reason = "an example writes files")]

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64Mcg;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use umwelt_core::exchange::PoseNoise;
use umwelt_core::geometry::{Pose, Twist};
use umwelt_core::kinematics::{self, Drive};
use umwelt_core::plant::{Plant, PlantModel, SLIP_PRESETS, Slip};

/// How it is driven and recorded.
struct Options {
    /// Lag and dead time of the drive in s.
    lag: f64,
    dead: f64,
    /// Length in s.
    span: f64,
    /// Poses and commands per second, and by what part of the time between two poses their times vary.
    poses: f64,
    commands: f64,
    jitter: f64,
    /// Every so many poses one jumps; 0 is never.
    jump: u64,
    /// What each command varies by, in m/s and rad/s.
    shake: f64,
    /// How far the clock of the poses is ahead of that of the commands in s.
    offset: f64,
    /// Times the noise of a camera.
    noise: f64,
    /// A preset of slip.
    floor: Slip,
    /// Seconds without poses in every minute.
    gap: f64,
    seed: f64,
}

impl Options {
    fn read(arguments: impl Iterator<Item = String>) -> Result<Self, Box<dyn Error>> {
        let mut read = Self {
            lag: 0.1,
            dead: 0.04,
            span: 60.0,
            poses: 30.0,
            commands: 20.0,
            jitter: 0.1,
            jump: 0,
            shake: 0.0,
            offset: 0.0,
            noise: 1.0,
            floor: Slip::NONE,
            gap: 0.0,
            seed: 1.0,
        };
        for argument in arguments {
            let (name, value) = argument.split_once('=').ok_or("an option is NAME=VALUE")?;
            if name == "floor" {
                let no_such = || format!("a floor is one of {SLIP_PRESETS:?}");
                read.floor = Slip::preset(value).ok_or_else(no_such)?;
                continue;
            }
            let value: f64 = value.parse()?;
            match name {
                "lag" => read.lag = value,
                "dead" => read.dead = value,
                "span" => read.span = value,
                "poses" => read.poses = value,
                "commands" => read.commands = value,
                "jitter" => read.jitter = value,
                "jump" => read.jump = value as u64,
                "shake" => read.shake = value,
                "offset" => read.offset = value,
                "noise" => read.noise = value,
                "gap" => read.gap = value,
                "seed" => read.seed = value,
                other => return Err(format!("there is no option {other}").into()),
            }
        }
        Ok(read)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut file = || -> Result<BufWriter<File>, Box<dyn Error>> {
        let path = arguments.next().ok_or("give POSES.csv and COMMANDS.csv")?;
        Ok(BufWriter::new(File::create(path)?))
    };
    let (mut poses, mut commands) = (file()?, file()?);
    let options = Options::read(arguments)?;
    writeln!(poses, "t_s,x_m,y_m,heading_rad")?;
    writeln!(commands, "t_s,linear_m_per_s,angular_rad_per_s")?;

    let drive = Drive { lag: options.lag, dead_time: options.dead, ..Drive::default() };
    let noise = PoseNoise {
        position: options.noise * PoseNoise::CAMERA.position,
        heading: options.noise * PoseNoise::CAMERA.heading,
    };
    let seed = options.seed as u64;
    let mut plant = Plant::new(
        PlantModel { drive, slip: options.floor, noise, ..PlantModel::default() },
        Pose::default(),
        seed,
    )?;
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let (mut wanted, mut until, mut taken) = (Twist::ZERO, 1.0, 0_u64);
    let (mut next_pose, mut next_command, mut sent) = (0.0, 0.0, Twist::ZERO);
    while plant.time() < options.span {
        let time = plant.time();
        if time >= next_pose {
            next_pose += (1.0 + options.jitter * (random.random::<f64>() - 0.5)) / options.poses;
            let seen = plant.observe();
            taken += 1;
            let jump = if options.jump > 0 && taken % options.jump == 0 { 0.3 } else { 0.0 };
            if time % 60.0 >= options.gap {
                let (x, heading) = (seen.x + jump, (seen.heading + jump).radians());
                let stamp = time + options.offset;
                writeln!(poses, "{stamp:.4},{x:.5},{:.5},{heading:.4}", seen.y)?;
            }
        }
        if time >= next_command {
            next_command += 1.0 / options.commands;
            if time >= until {
                until = time + random.random_range(0.5..2.5);
                wanted = match random.random_range(0..4) {
                    0 => Twist::ZERO,
                    1 => Twist::new(0.0, random.random_range(-1.2..1.2)),
                    2 => Twist::new(random.random_range(-0.12..0.12), 0.0),
                    _ => {
                        Twist::new(random.random_range(0.03..0.12), random.random_range(-1.0..1.0))
                    }
                };
            }
            sent = wanted;
            if wanted != Twist::ZERO {
                let mut shaken = || options.shake * random.sample::<f64, _>(StandardNormal);
                sent = Twist::new(wanted.linear + 0.1 * shaken(), wanted.angular + shaken());
            }
            writeln!(commands, "{time:.4},{:.4},{:.4}", sent.linear, sent.angular)?;
        }
        let next = next_pose.min(next_command);
        plant.advance(kinematics::inverse(&drive, sent), (next - time).max(1e-4));
    }
    Ok(())
}
