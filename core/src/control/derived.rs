//! What of a robot's settings follows from the rest where it is not said.
//!
//! Each formula scales the value of the robot of the thesis (and of our choice where the thesis is silent) by what it
//! depends on, so that the thesis's constants come out for the thesis's robot to the last digit. `docs/method.md` has
//! them in one table.

use crate::horizon::{MAX_SLOTS, MAX_WATCHDOG, WATCHDOG};
use crate::kinematics::Drive;
use crate::settings::{FollowsLink, LOOP_DELAY, Settings, SteeringSettings, VarianceLimits};
use crate::task::TOLERANCE;

/// Speed in m/s up to which a robot accelerates as that of the thesis; faster ones reach their own in the same time.
const GENTLE_BELOW: f64 = 1.0;

/// Slots of a horizon: what is left of the longest loop delay is 0.9 s in which nothing need come.
const SLOTS: usize = 40;

/// Loop delays that a horizon lasts for.
const DELAYS: f64 = 3.0;

/// Standard deviations of a pose within which it lies of a point that it is on, 19 times of 20 (Rayleigh).
const WITHIN: f64 = 2.5;

/// Standard deviations of a heading that are no heading error.
const NO_ERROR: f64 = 3.0;

/// Time in s for which the smallest turn may go on unseen: the loop delay and what it varies by.
const UNSEEN: f64 = 0.5;

/// Lag and dead time in s before any sample: the middle of what robots of the 0.1 m class have (field facts: 60 to 160 ms
/// and 0 to 40 ms), and the median of what is believed of their sum.
const LAG: f64 = 0.11;
const DEAD_TIME: f64 = 0.02;

/// Largest heading error in rad at which a robot may still drive: beyond it, it drives away.
const LARGEST_BEYOND: f64 = 1.5;

/// One of the settings that follow from the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// `Drive::max_linear`: 0.13 m/s, or what the wheels can do where their speed is said.
    MaxLinear,
    /// `Drive::min_linear`: 23/30 rad/s of the wheels.
    MinLinear,
    /// `Drive::max_angular`: 1.25 rad/s, less where the track is wide for the speed.
    MaxAngular,
    /// `Drive::min_angular`: a third of a rad/s of the wheels.
    MinAngular,
    /// `Drive::max_linear_acceleration`: 0.3 m/s^2; a robot faster than 1 m/s reaches its speed in 3.3 s.
    LinearAcceleration,
    /// `Drive::max_angular_acceleration`: the wheels accelerate half as much in a turn as straight on.
    AngularAcceleration,
    /// `Drive::max_wheel_speed`: the largest speed and turn at once, and a quarter more.
    MaxWheelSpeed,
    /// `SteeringSettings::alpha`: 20/13 of the largest speed.
    Alpha,
    /// `SteeringSettings::stop_radius`: 1/15 of the wheel radius, or the noise of a pose.
    StopRadius,
    /// `SteeringSettings::tolerance`: a third of the wheel radius, or 2.5 times the noise of a pose.
    Tolerance,
    /// `SteeringSettings::turn_tolerance`: 0.1 rad, what the smallest turn covers in 0.5 s, or three times the noise.
    TurnTolerance,
    /// `SteeringSettings::turn_beyond`: six times the turn tolerance.
    TurnBeyond,
    /// `VarianceLimits::position`: of what the robot drives in 77 ms at its largest speed.
    PositionVariance,
    /// `VarianceLimits::heading`: 0.10 rad^2 (thesis table 1).
    HeadingVariance,
    /// `Settings::loop_delay`: 0.23 s until the link is known, then the median of the recent ones.
    LoopDelay,
    /// `Settings::watchdog`: 0.3 s, longer with the loop delay.
    Watchdog,
    /// `Settings::slots`: 40, or three loop delays where that is more.
    Slots,
    /// `Drive::lag`: identified, and before that the middle of what robots have; none where the dead time is said.
    Lag,
    /// `Drive::dead_time`: likewise.
    DeadTime,
}

impl Quantity {
    /// Each of them, those on which others depend first.
    pub const ALL: [Self; 19] = [
        Self::MaxLinear,
        Self::MinLinear,
        Self::MaxAngular,
        Self::MinAngular,
        Self::LinearAcceleration,
        Self::AngularAcceleration,
        Self::MaxWheelSpeed,
        Self::Alpha,
        Self::StopRadius,
        Self::Tolerance,
        Self::TurnTolerance,
        Self::TurnBeyond,
        Self::PositionVariance,
        Self::HeadingVariance,
        Self::LoopDelay,
        Self::Watchdog,
        Self::Slots,
        Self::Lag,
        Self::DeadTime,
    ];
}

/// The settings with everything in its derived value that is not said.
///
/// ```
/// use umwelt_core::derived::{Quantity, complete};
/// use umwelt_core::kinematics::Drive;
/// use umwelt_core::settings::Settings;
/// // Of the robot of the thesis only wheels, track and top speed are known: its constants come out.
/// let thesis = complete(Settings::default(), |quantity| quantity == Quantity::MaxLinear);
/// assert_eq!((thesis.drive.max_angular, thesis.steering), (1.25, Settings::default().steering));
/// // A warehouse robot of 2 m/s.
/// let drive = Drive { wheel_radius: 0.1, track_width: 1.3, max_linear: 2.0, ..Drive::default() };
/// let large = complete(Settings { drive, ..Settings::default() }, |quantity| quantity == Quantity::MaxLinear);
/// assert!(large.steering.alpha > 3.0 && large.drive.min_linear < 0.08);
/// ```
pub fn complete(mut settings: Settings, is_said: impl Fn(Quantity) -> bool) -> Settings {
    settings.follows_link = follows_link(&is_said);
    settings.identifies_lag = identifies_lag(&is_said);
    settings.identifies_dead_band = identifies_dead_band(&is_said);
    for quantity in Quantity::ALL {
        if !is_said(quantity) {
            derive(&mut settings, quantity, &is_said);
        }
    }
    settings
}

/// Whether dead time and lag are identified because neither is said.
pub fn identifies_lag(is_said: impl Fn(Quantity) -> bool) -> bool {
    !is_said(Quantity::Lag) && !is_said(Quantity::DeadTime)
}

/// Whether the speed below which wheels do not turn is identified because no smallest speed is said.
pub fn identifies_dead_band(is_said: impl Fn(Quantity) -> bool) -> bool {
    !is_said(Quantity::MinLinear) && !is_said(Quantity::MinAngular)
}

/// What follows the link because it is not said.
pub fn follows_link(is_said: impl Fn(Quantity) -> bool) -> FollowsLink {
    FollowsLink {
        loop_delay: !is_said(Quantity::LoopDelay),
        slots: !is_said(Quantity::Slots),
        watchdog: !is_said(Quantity::Watchdog),
    }
}

/// The settings of a robot whose link has this `loop_delay` in s, as far as they follow it.
pub fn over_link(settings: &Settings, loop_delay: f64) -> Settings {
    let FollowsLink { loop_delay: follows, slots, watchdog } = settings.follows_link;
    let mut followed = *settings;
    if follows {
        followed.loop_delay = loop_delay;
        if watchdog {
            derive(&mut followed, Quantity::Watchdog, &|_| false);
        }
        if slots {
            derive(&mut followed, Quantity::Slots, &|_| false);
        }
    }
    followed
}

fn derive(settings: &mut Settings, quantity: Quantity, is_said: &impl Fn(Quantity) -> bool) {
    let thesis = Drive::default();
    let law = SteeringSettings::default();
    let Settings { drive, noise, steering, variance, loop_delay, .. } = settings;
    let size = drive.wheel_radius / thesis.wheel_radius;
    let speed = drive.max_linear / thesis.max_linear;
    match quantity {
        Quantity::MaxLinear => {
            let wheels = drive.max_wheel_speed * drive.wheel_radius;
            let are_wheels_said = is_said(Quantity::MaxWheelSpeed);
            drive.max_linear =
                if are_wheels_said { thesis.max_linear.min(wheels) } else { thesis.max_linear };
        }
        Quantity::MinLinear => drive.min_linear = (thesis.min_linear * size).min(drive.max_linear),
        Quantity::MaxAngular => {
            let narrow = speed * (thesis.track_width / drive.track_width);
            drive.max_angular = thesis.max_angular * narrow.min(1.0);
        }
        Quantity::MinAngular => {
            let turn = size * (thesis.track_width / drive.track_width);
            drive.min_angular = (thesis.min_angular * turn).min(drive.max_angular);
        }
        Quantity::LinearAcceleration => {
            let fast = (drive.max_linear / GENTLE_BELOW).max(1.0);
            drive.max_linear_acceleration = thesis.max_linear_acceleration * fast;
        }
        Quantity::AngularAcceleration => {
            let linear = drive.max_linear_acceleration / thesis.max_linear_acceleration;
            let turn = linear * (thesis.track_width / drive.track_width);
            drive.max_angular_acceleration = thesis.max_angular_acceleration * turn;
        }
        Quantity::MaxWheelSpeed => {
            drive.max_wheel_speed = thesis.max_wheel_speed * (fastest(drive) / fastest(&thesis));
        }
        Quantity::Alpha => steering.alpha = law.alpha * speed,
        Quantity::StopRadius => steering.stop_radius = (law.stop_radius * size).max(noise.position),
        Quantity::Tolerance => {
            let tolerance = (TOLERANCE * size).max(WITHIN * noise.position);
            steering.tolerance = tolerance.max(steering.stop_radius);
        }
        Quantity::TurnTolerance => {
            let unseen = UNSEEN * drive.min_angular;
            let tolerance = law.turn_tolerance.max(unseen).max(NO_ERROR * noise.heading);
            steering.turn_tolerance = tolerance.min(LARGEST_BEYOND / 2.0);
        }
        Quantity::TurnBeyond => {
            let beyond = law.turn_beyond * (steering.turn_tolerance / law.turn_tolerance);
            let least = 2.0 * steering.turn_tolerance;
            steering.turn_beyond = beyond.min(LARGEST_BEYOND).max(least);
        }
        Quantity::PositionVariance => {
            variance.position = VarianceLimits::default().position * (speed * speed);
        }
        Quantity::HeadingVariance => variance.heading = VarianceLimits::default().heading,
        Quantity::LoopDelay => settings.loop_delay = LOOP_DELAY,
        Quantity::Watchdog => {
            let slow = (*loop_delay / LOOP_DELAY).max(1.0);
            settings.watchdog = (WATCHDOG * slow).min(MAX_WATCHDOG);
        }
        Quantity::Slots => {
            let wanted = (DELAYS * *loop_delay / settings.slot).ceil() as usize;
            settings.slots = wanted.clamp(SLOTS, MAX_SLOTS);
        }
        Quantity::Lag => drive.lag = if is_said(Quantity::DeadTime) { 0.0 } else { LAG },
        Quantity::DeadTime => {
            drive.dead_time = if is_said(Quantity::Lag) { 0.0 } else { DEAD_TIME }
        }
    }
}

/// Speed in rad/s of the faster wheel at the largest speed and turn at once.
fn fastest(drive: &Drive) -> f64 {
    (drive.max_linear + drive.max_angular * drive.track_width / 2.0) / drive.wheel_radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exchange::PoseNoise;
    use proptest::prelude::*;

    fn derived(drive: Drive, noise: PoseNoise) -> Settings {
        let known = Settings { drive, noise, ..Settings::default() };
        complete(known, |quantity| quantity == Quantity::MaxLinear)
    }

    /// Guards against comparisons with the thesis that compare something else.
    #[test]
    fn the_constants_of_the_thesis_come_out_for_its_robot() {
        let derived = complete(Settings::default(), |_| false);
        let follows_link = FollowsLink { loop_delay: true, slots: true, watchdog: true };
        // Whose robot follows at once, as far as it says.
        let drive = Drive { lag: LAG, dead_time: DEAD_TIME, ..Drive::default() };
        let identified = Settings {
            drive,
            identifies_lag: true,
            identifies_dead_band: true,
            ..Settings::default()
        };
        assert_eq!(derived, Settings { slots: SLOTS, follows_link, ..identified });
        let camera =
            complete(Settings { noise: PoseNoise::CAMERA, ..Settings::default() }, |_| false);
        assert_eq!(camera.steering, SteeringSettings::default());
    }

    /// Guards against a derived value that replaces what the user said.
    #[test]
    fn what_is_said_stays() {
        let odd = Settings {
            drive: Drive {
                max_wheel_speed: 3.0,
                max_linear: 0.05,
                min_linear: 0.011,
                max_angular: 0.7,
                min_angular: 0.09,
                max_linear_acceleration: 0.11,
                max_angular_acceleration: 0.77,
                lag: 0.07,
                dead_time: 0.03,
                ..Drive::default()
            },
            slots: 3,
            watchdog: 0.7,
            variance: VarianceLimits { position: 1e-3, heading: 0.5 },
            steering: SteeringSettings {
                alpha: 0.33,
                stop_radius: 0.009,
                tolerance: 0.09,
                turn_tolerance: 0.3,
                turn_beyond: 0.9,
            },
            ..Settings::default()
        };
        assert_eq!(complete(odd, |_| true), odd);
        for said in Quantity::ALL.into_iter().filter(|&it| it != Quantity::LoopDelay) {
            let only = complete(odd, |quantity| quantity == said);
            let all_but = complete(odd, |quantity| quantity != said);
            let differs = complete(only, |quantity| quantity != said) != only;
            assert!(differs && all_but != odd, "{said:?}: it is neither kept nor derived");
        }
    }

    #[test]
    fn a_robot_of_another_size_is_driven_as_one_of_that_size() {
        let drive =
            Drive { wheel_radius: 0.1, track_width: 1.3, max_linear: 2.0, ..Drive::default() };
        let large = derived(drive, PoseNoise { position: 0.01, heading: 0.005 });
        assert!((large.drive.max_linear_acceleration - 0.6).abs() < 1e-12);
        assert!(large.drive.max_angular <= 1.25 && large.drive.min_angular < 0.06);
        assert!((large.steering.alpha / 2.0 - 0.2 / 0.13).abs() < 1e-12);
        assert!((large.steering.tolerance - 0.1 / 3.0).abs() < 1e-12);
        let drive =
            Drive { wheel_radius: 0.005, track_width: 0.02, max_linear: 0.08, ..Drive::default() };
        let small = derived(drive, PoseNoise { position: 0.0005, heading: 0.01 });
        assert!(small.drive.min_linear < 0.004 && small.steering.tolerance < 0.002);
        let noisy = derived(Drive::default(), PoseNoise { position: 0.01, heading: 0.1 });
        assert_eq!((noisy.steering.stop_radius, noisy.steering.tolerance), (0.01, 0.025));
        assert!(noisy.steering.turn_tolerance > 0.29);
    }

    #[test]
    fn a_slow_link_gets_longer_horizons() {
        let with = |loop_delay| {
            let said = Settings { loop_delay, ..Settings::default() };
            let settings = complete(said, |quantity| quantity == Quantity::LoopDelay);
            let identified = over_link(&complete(Settings::default(), |_| false), loop_delay);
            assert_eq!(
                (identified.slots, identified.watchdog),
                (settings.slots, settings.watchdog)
            );
            (settings.slots, settings.watchdog)
        };
        assert_eq!(with(0.1), (SLOTS, WATCHDOG));
        assert_eq!(with(0.5).0, 50);
        assert!(with(0.5).1 > 0.6);
        assert_eq!(with(2.0), (MAX_SLOTS, MAX_WATCHDOG));
    }

    proptest! {
        /// Guards against a derived value that contradicts another one, whatever is said.
        #[test]
        fn what_is_derived_agrees(
            radius in 0.001..2.0f64, track in 0.005..10.0f64, linear in 1e-3..10.0f64, wheel in 0.01..1000.0f64,
            position in 0.0..1.0f64, heading in 0.0..1.0f64, loop_delay in 0.0..2.0f64, says_wheel in any::<bool>(),
        ) {
            let drive = Drive { wheel_radius: radius, track_width: track, max_linear: linear, max_wheel_speed: wheel, ..Drive::default() };
            let known = Settings { drive, noise: PoseNoise { position, heading }, loop_delay, ..Settings::default() };
            let said = if says_wheel { Quantity::MaxWheelSpeed } else { Quantity::MaxLinear };
            let is_said = |quantity| quantity == said || quantity == Quantity::LoopDelay;
            let Settings { drive, steering, slots, .. } = complete(known, is_said);
            prop_assert!(drive.min_linear <= drive.max_linear && drive.min_angular <= drive.max_angular);
            prop_assert!(steering.turn_beyond > steering.turn_tolerance && steering.tolerance >= steering.stop_radius);
            prop_assert!((1..=MAX_SLOTS).contains(&slots));
            let room = drive.max_wheel_speed * radius * (1.0 + 1e-9);
            prop_assert!(says_wheel || (drive.min_linear <= room && drive.min_angular * track / 2.0 <= room));
        }
    }
}
