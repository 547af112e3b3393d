//! The pure domain of Umwelt: a controller that drives two-wheel robots over bad links by first recognising the
//! environment they are in.
//!
//! Architecture invariant: this crate does no I/O, reads no clock, starts no thread and owns no random number
//! generator. Time and seeds are arguments; the same state and input give the same result, bit for bit.
//!
//! It has three parts, each of which uses those before it:
//!
//! * **The robot's side**: [`exchange`] says which request to send when, [`actuation`] what to play of the replies, within
//!   what the robot itself allows ([`local`]). Below them [`horizon`], [`kinematics`], [`geometry`] and [`time`].
//! * **The controller's side**: [`controller`] answers a request with a horizon. It identifies the environment
//!   ([`identification`], by [`conjugate`] beliefs), predicts where the robot will be ([`prediction`], along the
//!   [`commands`] in force), and steers from there ([`steering`]) through a [`task`]; the [`watch`] looks whether the robot
//!   moves as commanded. [`settings`] describe the robot and how to control it.
//! * **The simulation**: a [`plant`] on a floor, a [`link`] that is late and loses packets, and both with the two sides
//!   above as an [`episode`] in simulated time. [`fixed_models`] measures with it. The crate `umwelt-lab` drives episodes
//!   by the thousand; it shares the random numbers at an index ([`draws`]).
//!
//! Units are SI: m, rad, s. A pose is in the room, x and y in m and a heading counter-clockwise from x; a twist and a
//! displacement are in the body frame, forward and to the left; wheel speeds are in rad/s. Every time is the robot's own
//! clock. `docs/method.md` in the repository has the equations, under the numbers that comments cite.
//!
//! # Example
//!
//! A simulated robot with a camera's noise drives to a point. Its link takes no time:
//!
#![cfg_attr(feature = "controller", doc = "```")]
#![cfg_attr(not(feature = "controller"), doc = "```ignore")]
//! use umwelt_core::actuation::Actuation;
//! use umwelt_core::controller::Controller;
//! use umwelt_core::exchange::{Exchange, Observation, PoseNoise};
//! use umwelt_core::geometry::{Point, Pose};
//! use umwelt_core::plant::{Plant, PlantModel, Slip};
//! use umwelt_core::settings::Settings;
//! use umwelt_core::task::Task;
//! use umwelt_core::time::RobotTime;
//!
//! let (settings, goal) = (Settings::default(), Point::new(0.3, 0.1));
//! let mut controller = Controller::new(settings);
//! controller.set_task(Task { waypoints: vec![goal], calibration: None, ..Task::thesis() });
//! let (mut exchange, mut actuation) = (Exchange::new(RobotTime::ZERO), Actuation::new(settings.drive, RobotTime::ZERO));
//! let model = PlantModel { drive: settings.drive, slip: Slip::HARD, noise: PoseNoise::CAMERA, ..PlantModel::default() };
//! let mut robot = Plant::new(model, Pose::default(), 1)?;
//! for slot in 0..300 {
//!     let now = RobotTime::new(f64::from(slot) * settings.slot);
//!     exchange.observe(Observation { pose: robot.observe(), taken: now });
//!     if let Some(request) = exchange.request(now, actuation.playing()) {
//!         let horizon = controller.step(&request).horizon;
//!         exchange.reply(now, horizon.answers);
//!         actuation.accept(&horizon);
//!     }
//!     robot.advance(actuation.advance(now), settings.slot);
//! }
//! assert!(controller.has_arrived() && robot.pose().point().distance(goal) < 0.01);
//! # Ok::<(), umwelt_core::plant::PlantError>(())
//! ```
//!
//! # Without the standard library
//!
//! With `default-features = false` the crate is the robot's side alone, without the standard library (it needs `alloc`), for
//! a robot whose agent is a microcontroller. The feature `controller`, on by default, is everything else and needs `std`.
//! Both play to the last bit the same (`tests/robot_side`): sine, cosine and exponential are this crate's own, but for
//! angles beyond 10^5 rad.

#![cfg_attr(not(any(feature = "std", test)), no_std)]

extern crate alloc;

mod robot;
pub use robot::{actuation, exchange, geometry, horizon, kinematics, local, time};

#[cfg(feature = "controller")]
mod control;
#[cfg(feature = "controller")]
pub use control::{
    check, commands, conjugate, controller, derived, drive, fusion, identification, prediction,
    settings, square, steering, task, watch,
};

#[cfg(feature = "controller")]
mod simulation;
#[cfg(feature = "controller")]
pub use simulation::{draws, episode, fixed_models, link, plant};
