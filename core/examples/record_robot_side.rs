//! Records what reaches a robot in a few seconds on a bad link: the files that the test `robot_side` plays.
//!
//! `cargo run -p umwelt-core --example record_robot_side > core/tests/robot_side/record.txt`, and then the same with
//! `-- played > core/tests/robot_side/played.txt`.

#![allow(clippy::print_stdout, reason = "an example prints")]

#[path = "../tests/robot_side/player.rs"]
mod player;

use player::{Event, Player};
use umwelt_core::controller::Controller;
use umwelt_core::exchange::{Observation, PoseNoise, Request};
use umwelt_core::geometry::{Point, Pose, WheelSpeeds};
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics::Drive;
use umwelt_core::link::{Link, LinkModel, Outage};
use umwelt_core::local::LocalLimits;
use umwelt_core::plant::{Plant, PlantModel, Slip};
use umwelt_core::settings::Settings;
use umwelt_core::task::Task;
use umwelt_core::time::RobotTime;

/// Recorded time in s.
const SPAN: f64 = 4.2;

/// What the robot itself allows, and from when on in s.
const RESTRAINED: [(f64, LocalLimits); 3] = [
    (2.7, LocalLimits { hold: true, max_speed: None }),
    (3.0, LocalLimits::NONE),
    (3.6, LocalLimits { hold: false, max_speed: Some(0.06) }),
];

/// What is on its way.
enum Packet {
    ToRobot(Event),
    ToServer(Box<Request>),
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let drive = Drive { lag: 0.08, ..Drive::default() };
    if std::env::args().nth(1).is_some_and(|what| what == "played") {
        print!("{}", player::play(include_str!("../tests/robot_side/record.txt"), drive));
        return Ok(());
    }
    for (at, event) in record(drive)? {
        println!("{}", player::write(at, &event));
    }
    Ok(())
}

/// Drives a robot over a link that loses, overtakes and falls silent; what reaches it, and when.
fn record(drive: Drive) -> Result<Vec<(f64, Event)>, Box<dyn std::error::Error>> {
    let noise = PoseNoise::CAMERA;
    let model = LinkModel {
        outages: vec![Outage { start: 1.0, duration: 0.6 }],
        in_order: false,
        ..LinkModel::preset("bad").ok_or("no such preset")?
    };
    let mut link = Link::new(model, 3)?;
    let mut plant = Plant::new(
        PlantModel { drive, slip: Slip::HARD, noise, ..PlantModel::default() },
        Pose::new(0.0, 0.0, 0.6),
        3,
    )?;
    let mut controller =
        Controller::new(Settings { drive, noise, slots: 6, ..Settings::default() });
    let waypoints = vec![Point::new(0.3, 0.0)];
    controller.set_task(Task { waypoints, calibration: None, ..Task::thesis() });
    let mut player = Player::new(drive);
    let restrained = RESTRAINED.map(|(at, limits)| (at, Packet::ToRobot(Event::Restrain(limits))));
    let mut packets = Vec::from(restrained);
    let (mut now, mut frames, mut newest, mut recorded) = (0.0_f64, 0_u32, 0, Vec::new());
    let mut applied = WheelSpeeds::ZERO;
    while now < SPAN {
        let frame = f64::from(frames) * SLOT;
        let packet = packets.iter().map(|(at, _)| *at).fold(f64::INFINITY, f64::min);
        let next = now.max(frame.min(packet).min(player.next()));
        plant.advance(applied, next - now);
        now = next;
        if frame <= now {
            frames += 1;
            let seen =
                Event::Pose(Observation { pose: plant.observe(), taken: RobotTime::new(frame) });
            packets.push((link.sensor(frame), Packet::ToRobot(seen)));
        }
        while let Some(index) = packets.iter().position(|(at, _)| *at <= now) {
            match packets.remove(index) {
                (_, Packet::ToRobot(event)) => {
                    player.hear(now, &event);
                    recorded.push((now, event));
                }
                (_, Packet::ToServer(request)) => {
                    let reply = if request.sequence > newest {
                        newest = request.sequence;
                        Some(controller.step(&request).horizon)
                    } else {
                        controller.late(&request)
                    };
                    if let (Some(mut horizon), Some(at)) = (reply, link.downlink(now)) {
                        horizon.answers = request.sequence;
                        packets.push((at, Packet::ToRobot(Event::Reply(Box::new(horizon)))));
                    }
                }
            }
        }
        if let Some(request) = player.advance(now)
            && let Some(at) = link.uplink(now)
        {
            packets.push((at, Packet::ToServer(Box::new(request))));
        }
        applied = player.applied;
    }
    Ok(recorded)
}
