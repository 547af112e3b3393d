//! What has to hold of every answer.

use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use umwelt_api::robot::LOOP_DELAY;
use umwelt_core::controller::{Controller, Saved};
use umwelt_core::exchange::{Observation, Request};
use umwelt_core::geometry::Twist;
use umwelt_core::horizon::{Horizon, SLOT};
use umwelt_core::kinematics::{self, Drive};
use umwelt_core::settings::Attribution;
use umwelt_core::time::RobotTime;

/// Rounding of speeds, as a part of them, and of times in s.
const ROUNDING: f64 = 1e-9;

/// A speed below this part of the largest one is rest.
const REST: f64 = 1e-12;

/// So many horizons are remembered by a controller at least: more than wait for their start where one comes per slot.
const REMEMBERED: usize = 64;

/// A moment before in s: what is in force then is what a new horizon takes the place of.
const BEFORE: f64 = 1e-6;

/// What was answered before, on the same clock.
#[derive(Debug, Default)]
pub struct Judge {
    answered: Vec<Horizon>,
    /// How many of them the robot has let go of: it came to rest on its own.
    let_go: usize,
    was_playing: bool,
    was_held: bool,
}

impl Judge {
    /// Checks one answer.
    pub fn answer(
        &mut self,
        controller: &Controller,
        request: &Request,
        horizon: &Horizon,
    ) -> TestCaseResult {
        let (is_playing, is_held) = (request.playing.is_some(), controller.is_held());
        if (self.was_playing && !is_playing) || (is_held && !self.was_held) {
            self.let_go = self.answered.len();
        }
        (self.was_playing, self.was_held) = (is_playing, is_held);
        self.times(request, horizon)?;
        let settings = controller.settings();
        let count = horizon.speeds.len();
        prop_assert!((1..=settings.slots).contains(&count), "{count} entries");
        let twists = within_limits(&settings.drive, horizon)?;
        if settings.attribution == Attribution::Sent {
            self.follows(&settings.drive, horizon.start, twists[0])?;
        }
        self.answered.push(horizon.clone());
        if controller.is_stopped() || is_held {
            comes_to_rest(&settings.drive, &twists)?;
        }
        let seen = controller.pose();
        if let Some(Observation { pose, .. }) = seen {
            let sum = pose.x + pose.y + pose.heading.radians();
            prop_assert!(sum.is_finite(), "{pose:?}");
        }
        let progress = controller.progress();
        prop_assert!(progress.deviation.is_finite() && progress.max_deviation.is_finite());
        prop_assert!(progress.elapsed.is_finite() && progress.elapsed >= 0.0, "{progress:?}");
        Ok(())
    }

    /// It begins after it is sent, no later than the loop takes at most, and never before the one before.
    fn times(&self, request: &Request, horizon: &Horizon) -> TestCaseResult {
        let (sent, start) = (request.sent, horizon.start);
        prop_assert_eq!(horizon.sequence, request.sequence);
        prop_assert!(start >= sent, "it begins at {start} s, sent at {sent} s");
        let latest = sent + LOOP_DELAY.max.max(SLOT) + ROUNDING * (1.0 + sent.seconds().abs());
        prop_assert!(start <= latest, "it begins at {start} s, sent at {sent} s");
        // What a robot that rests on its own has let go of never begins.
        let before = self.answered[self.let_go..].last();
        let before = before.map_or(RobotTime::BEFORE_ALL, |before| before.start);
        prop_assert!(start >= before, "it begins at {start} s, the one before at {before} s");
        Ok(())
    }

    /// It goes on from what was in force before it, as the robot plays what it was sent.
    fn follows(&self, drive: &Drive, start: RobotTime, first: Twist) -> TestCaseResult {
        let time = start - BEFORE;
        let recent = self.answered[self.let_go..].iter().rev().take(REMEMBERED);
        let before = recent.clone().find(|horizon| horizon.start <= time + ROUNDING);
        if before.is_none() && (self.let_go > 0 || recent.count() == REMEMBERED) {
            return Ok(());
        }
        let before =
            before.map_or(Twist::ZERO, |before| kinematics::forward(drive, before.at(time, drive)));
        let needed = drive.change_time(before, first);
        prop_assert!(
            needed <= SLOT * (1.0 + 1e-6) + ROUNDING,
            "a change of {needed} s at the start, from {before:?} to {first:?}"
        );
        Ok(())
    }

    /// What is kept is read back as it was, and taken up again: in it every number is finite, or it would not be.
    pub fn restored(&self, controller: &Controller) -> Result<Controller, TestCaseError> {
        let saved = controller.saved();
        let text = serde_json::to_string(&saved).unwrap();
        let read = serde_json::from_str::<Saved>(&text);
        let read = read.map_err(|error| TestCaseError::fail(format!("{error}: {text}")))?;
        prop_assert_eq!(&read, &saved);
        let (settings, task) = (*controller.settings(), controller.task().cloned());
        let restored = Controller::restore(settings, task, controller.is_stopped(), read);
        restored.ok_or_else(|| TestCaseError::fail("what was kept is not taken up"))
    }
}

/// Checks speeds and their changes; returns them as twists of the body.
fn within_limits(drive: &Drive, horizon: &Horizon) -> Result<Vec<Twist>, TestCaseError> {
    let mut twists: Vec<Twist> = Vec::with_capacity(horizon.speeds.len());
    for (slot, &speeds) in horizon.speeds.iter().enumerate() {
        let twist = kinematics::forward(drive, speeds);
        for (what, value, limit) in [
            ("the left wheel", speeds.left, drive.max_wheel_speed),
            ("the right wheel", speeds.right, drive.max_wheel_speed),
            ("the speed", twist.linear, drive.max_linear),
            ("the angular velocity", twist.angular, drive.max_angular),
        ] {
            // What is no number is within nothing.
            prop_assert!(
                value.abs() <= limit * (1.0 + ROUNDING),
                "slot {slot}: {what} is {value}, the limit {limit}"
            );
        }
        if let Some(&before) = twists.last() {
            let needed = drive.change_time(before, twist);
            prop_assert!(
                needed <= horizon.slot * (1.0 + 1e-6) + ROUNDING,
                "slot {slot}: a change of {needed} s, from {before:?} to {twist:?}"
            );
        }
        twists.push(twist);
    }
    Ok(twists)
}

/// A robot that is stopped is told to slow down and to rest, and nothing else.
fn comes_to_rest(drive: &Drive, twists: &[Twist]) -> TestCaseResult {
    let grows = |before: f64, after: f64, limit: f64| {
        after.abs() > before.abs() + limit * ROUNDING
            || (before * after < 0.0 && after.abs() > limit * ROUNDING)
    };
    for pair in twists.windows(2) {
        prop_assert!(!grows(pair[0].linear, pair[1].linear, drive.max_linear), "{pair:?}");
        prop_assert!(!grows(pair[0].angular, pair[1].angular, drive.max_angular), "{pair:?}");
    }
    let (Some(&first), Some(&last)) = (twists.first(), twists.last()) else { return Ok(()) };
    // One slot per step, each as large as the limits allow.
    let needed = drive.stopping_time(first) + SLOT;
    let rests = last.linear.abs() <= drive.max_linear * REST
        && last.angular.abs() <= drive.max_angular * REST;
    prop_assert!(
        rests || needed > twists.len() as f64 * SLOT,
        "not at rest after {} slots: {first:?}, {last:?}",
        twists.len()
    );
    Ok(())
}
