//! The robot's clock as core sees it: seconds since the second in which the epoch's first request was sent.
//!
//! A clock may have counted for thirty years, and then a double resolves no more than a tenth of a microsecond. Core
//! is kept out of that: it counts from the first request of the epoch on. The base is a whole number of seconds and no
//! larger than the times themselves, so what is subtracted leaves no rounding behind and adding it back gives the very
//! number that the robot sent; of a clock that counts up from below zero, to its own resolution or that of the time since
//! its epoch began, whichever is coarser. A horizon is planned to the full precision of small numbers; on the wire its start is
//! as exact as the robot's own clock is.

use umwelt_api::step;
use umwelt_core::exchange::{Observation, Request};
use umwelt_core::horizon;
use umwelt_core::time::RobotTime;

/// Where an epoch's time begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RobotClock {
    /// Robot time in s that core calls zero: a whole number.
    base: f64,
}

impl RobotClock {
    /// The clock of an epoch whose first request was sent at robot time `sent`.
    pub(super) fn beginning(sent: RobotTime) -> Self {
        Self { base: sent.seconds().floor() }
    }

    /// A request as core takes it.
    pub(super) fn request(self, request: &Request) -> Request {
        let mut request = request.clone();
        request.sent -= self.base;
        for observation in &mut request.observations {
            observation.taken -= self.base;
        }
        if let Some(playing) = &mut request.playing {
            playing.since -= self.base;
        }
        request
    }

    /// A pose of core's as the robot knows it.
    pub(super) fn observation(self, observation: Observation) -> Observation {
        Observation { taken: observation.taken + self.base, ..observation }
    }

    /// A horizon of core's as the robot plays it.
    pub(super) fn horizon(self, horizon: &horizon::Horizon) -> step::Horizon {
        let mut said = step::Horizon::from(horizon);
        said.start_s += self.base;
        said.valid_until_s = said.valid_until_s.map(|until| until + self.base);
        said
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use umwelt_core::actuation::Playing;
    use umwelt_core::controller::Controller;
    use umwelt_core::geometry::Pose;
    use umwelt_core::settings::Settings;
    use umwelt_core::task::Task;

    fn request(sequence: u64, sent: f64, taken: f64) -> Request {
        let (sent, taken) = (RobotTime::new(sent), RobotTime::new(taken));
        let mut request = Request { sequence, sent, ..Request::EMPTY };
        request.observations.push(Observation { pose: Pose::new(0.1, 0.2, 0.3), taken });
        request.playing = Some(Playing { horizon: sequence, since: taken });
        request
    }

    proptest! {
        /// Guards against: a pose that comes back with another time than it was sent with.
        #[test]
        fn what_was_sent_comes_back_to_the_last_digit(
            first in -1e9..1e9f64, later in 0.0..86_400.0f64, age in 0.0..1.0f64,
        ) {
            let clock = RobotClock::beginning(RobotTime::new(first));
            let sent = first + later;
            let taken = sent - age;
            let told = clock.request(&request(1, sent, taken));
            prop_assert!((-1.0..86_402.0).contains(&told.sent.seconds()));
            let back = clock.observation(told.observations[0]).taken.seconds();
            // Below one second the base is zero or next to it and digits beyond the robot's resolution may be cut.
            let cut = if first < 0.0 { later * f64::EPSILON } else { 0.0 };
            prop_assert!((back - taken).abs() <= 1e-15 + cut, "{} {}", back, taken);
            prop_assert!(taken.abs() < 1.0 || first < 0.0 || back == taken);
        }

        /// Guards against: a robot that drives otherwise because its clock has counted for long.
        #[test]
        fn however_much_a_clock_has_counted_the_robot_is_told_the_same(
            seconds in prop_oneof![-1_000_000_000i32..1_000_000_000, Just(1 << 29), Just(849_000_000)],
            pause in 0u16..2000,
        ) {
            let of = |base: f64| {
                let mut controller = Controller::new(Settings::default());
                controller.set_task(Task::thesis());
                let clock = RobotClock::beginning(RobotTime::new(base));
                let told = |(sequence, at): (u64, f64)| {
                    // Quarters of a second are numbers that every clock can say.
                    let request = request(sequence, base + at, base + at - 0.25);
                    clock.horizon(&controller.step(&clock.request(&request)).horizon)
                };
                let times = [0.5, 0.75, 1.0, 1.0 + f64::from(pause) / 4.0, 600.0];
                times.into_iter().enumerate().map(|(i, at)| (i as u64 + 1, at)).map(told).collect::<Vec<_>>()
            };
            let (large, small) = (of(f64::from(seconds)), of(0.0));
            for (large, small) in large.iter().zip(&small) {
                prop_assert_eq!(&large.wheel_speeds, &small.wheel_speeds);
                prop_assert!((large.start_s - f64::from(seconds) - small.start_s).abs() < 2e-7);
            }
        }
    }
}
