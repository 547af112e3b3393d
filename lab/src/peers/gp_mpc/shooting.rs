//! A short model predictive controller that shoots: turns in two pieces, tried out on the kinematic model.

use crate::peers::line::Line;
use umwelt_core::controller::compensation::{PathFollower, Way};
use umwelt_core::geometry::elementary::{least, most, sin_cos};
use umwelt_core::geometry::{Twist, length};
use umwelt_core::kinematics::Drive;
use umwelt_core::settings::Settings;
use umwelt_core::steering;
use umwelt_core::task::Limit;

/// Steps of a shot.
const STEPS: usize = 8;

/// Shares of the fastest speed that are tried.
const SPEEDS: [f64; 3] = [1.0, 0.6, 0.3];

/// Turns that are tried at first, in rad/s, from the nearest to straight on; both sides.
const TURNS: [f64; 5] = [0.0, 0.06, 0.2, 0.5, 1.0];

/// Parts of the way to the next turn of the grid that are tried around the best.
const FINER: [f64; 5] = [-0.6, -0.3, 0.0, 0.3, 0.6];

/// Turns of the second piece, as parts of the first.
const SECOND: [f64; 4] = [1.0, 0.0, -1.0, 0.4];

/// A cross-track error in m, a heading error in rad and a change of turn in rad/s that cost one, at a weight of one.
const UNITS: (f64, f64, f64) = (0.01, 0.1, 1.0);

/// The part of the steepest heading that the shared controller allows before it stops to turn in place.
const STEEPEST: f64 = 0.75;

/// Cost in a second of one rad beyond the steepest heading.
const TOO_STEEP: f64 = 1000.0;

/// Weights of the cost; the distance left at the end costs one per 10 mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MpcTuning {
    /// Length of a step in s: eight make the horizon.
    pub step: f64,
    /// Of the squared cross-track error, per second.
    pub cross: f64,
    /// Of the squared heading error, per second.
    pub heading: f64,
    /// Of the squared change of the turn.
    pub change: f64,
}

impl Default for MpcTuning {
    fn default() -> Self {
        Self { step: 0.07, cross: 10.0, heading: 0.3, change: 0.3 }
    }
}

/// The model predictive controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShootingMpc {
    /// Its constants.
    pub tuning: MpcTuning,
}

impl PathFollower for ShootingMpc {
    fn steer(&self, settings: &Settings, way: &Way) -> (Twist, Limit) {
        (self.tuning.best(settings, way), Limit::Waypoint)
    }
}

/// What is tried: a share of the fastest speed, and a turn in rad/s for each half of the shot.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shot {
    share: f64,
    turns: [f64; 2],
}

impl MpcTuning {
    /// The twist to drive with now: the beginning of the cheapest shot, within every limit.
    fn best(&self, settings: &Settings, way: &Way) -> Twist {
        let shooting = Shooting::new(self, settings, way);
        let mut best = (f64::INFINITY, Shot { share: 1.0, turns: [0.0; 2] });
        let consider = |shot: Shot, best: &mut (f64, Shot)| {
            let cost = shooting.cost(shot, best.0);
            if cost < best.0 {
                *best = (cost, shot);
            }
        };
        // What is being done already is rarely far from the best: most others are given up early.
        consider(Shot { share: 1.0, turns: [way.previous.angular; 2] }, &mut best);
        let mut gap = TURNS[1];
        for share in SPEEDS {
            for (index, turn) in TURNS.iter().enumerate() {
                for side in [1.0, -1.0] {
                    if index == 0 && side < 0.0 {
                        continue;
                    }
                    let before = best.0;
                    consider(Shot { share, turns: [side * turn; 2] }, &mut best);
                    if best.0 < before {
                        gap = if index == 0 { TURNS[1] } else { turn - TURNS[index - 1] };
                    }
                }
            }
        }
        let Shot { share, turns: [around, _] } = best.1;
        for part in FINER {
            let first = around + part * gap;
            for second in SECOND {
                consider(Shot { share, turns: [first, second * first] }, &mut best);
            }
        }
        let wanted = shooting.wanted(best.1, 0, way.speed(settings));
        settings.drive.reach(way.previous, wanted, way.since_change)
    }
}

struct Shooting<'a> {
    tuning: &'a MpcTuning,
    drive: &'a Drive,
    way: &'a Way,
    start: Line,
    steepest: f64,
    /// Distance in m to the end at which the robot is to stop.
    stop: f64,
}

impl<'a> Shooting<'a> {
    fn new(tuning: &'a MpcTuning, settings: &'a Settings, way: &'a Way) -> Self {
        let law = &settings.steering;
        Self {
            tuning,
            drive: &settings.drive,
            way,
            start: Line::of(way),
            steepest: STEEPEST * 2.0 * law.turn_tolerance,
            stop: law.stop_radius / 2.0,
        }
    }

    /// The twist that `shot` wants in `step`, where `fastest` m/s is the fastest speed; forward, as it is travelled.
    fn wanted(&self, shot: Shot, step: usize, fastest: f64) -> Twist {
        let speed = most(shot.share * fastest, self.drive.min_linear);
        let speed = if self.way.reverse { -speed } else { speed };
        let twist = Twist::new(speed, shot.turns[2 * step / STEPS]);
        // Nearly always within the limits, which is known without a division.
        let rim = twist.linear.abs() + self.drive.track_width / 2.0 * twist.angular.abs();
        let is_within = rim <= self.drive.wheel_radius * self.drive.max_wheel_speed
            && twist.linear.abs() <= self.drive.max_linear
            && twist.angular.abs() <= self.drive.max_angular;
        if is_within { twist } else { self.drive.limited(twist) }
    }

    /// The cost of `shot`, or something above `most_expensive`: what it does is found out on the kinematic model.
    fn cost(&self, shot: Shot, most_expensive: f64) -> f64 {
        let MpcTuning { step: duration, cross, heading, change } = *self.tuning;
        let Line { cross: mut aside, heading: mut direction, mut ahead } = self.start;
        let mut twist = self.way.previous;
        let sign = if self.way.reverse { -1.0 } else { 1.0 };
        let [first, second] = shot.turns;
        let changes = (first - self.way.previous.angular).powi(2) + (second - first).powi(2);
        let mut cost = change * changes / UNITS.2.powi(2);
        let limit = self.drive.max_linear * duration;
        for step in 0..STEPS {
            let remaining = length(ahead, aside);
            // However it goes on, no step leads nearer by more than the fastest one.
            let left = remaining - limit * (STEPS - step) as f64;
            if cost + most(left, 0.0) / UNITS.0 > most_expensive {
                return f64::INFINITY;
            }
            // A shot that gets there stays there.
            if ahead <= 0.0 || remaining <= 2.0 * self.stop {
                break;
            }
            let stoppable = steering::stopping_speed(
                remaining - self.stop,
                self.drive.max_linear_acceleration,
                duration,
            );
            let fastest = least(most(stoppable, self.drive.min_linear), self.drive.max_linear);
            twist = self.drive.reach(twist, self.wanted(shot, step, fastest), duration);
            let (distance, turn) = (sign * twist.linear * duration, twist.angular * duration);
            let (sin, cos) = sin_cos(direction + turn / 2.0);
            aside += distance * sin;
            ahead -= distance * cos;
            direction += turn;
            let beyond = most(direction.abs() - self.steepest, 0.0);
            cost += duration
                * (cross * (aside / UNITS.0).powi(2)
                    + heading * (direction / UNITS.1).powi(2)
                    + TOO_STEEP * beyond);
        }
        cost + length(ahead, aside) / UNITS.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use umwelt_core::geometry::{Point, Pose};
    use umwelt_core::kinematics::integrate;

    fn way(settings: &Settings, pose: Pose, previous: Twist, to: Point, reverse: bool) -> Way {
        let distance = pose.point().distance(to) - settings.steering.stop_radius / 2.0;
        let deceleration = settings.drive.max_linear_acceleration;
        let stoppable = steering::stopping_speed(distance, deceleration, settings.slot);
        let from = Some(Point::new(0.0, 0.0));
        Way {
            pose,
            previous,
            from,
            to,
            reverse,
            stoppable,
            slowest: settings.drive.min_linear,
            is_raised: false,
            since_change: settings.slot,
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn it_stops_at_its_waypoint_within_every_limit(
            y in -0.03..0.03f64, heading in -0.15..0.15f64, far in 0.4..1.0f64, reverse in any::<bool>(),
        ) {
            let settings = Settings::default();
            let drive = &settings.drive;
            let to = Point::new(if reverse { -far } else { far }, 0.0);
            let (mut pose, mut twist) = (Pose::new(0.0, y, heading), Twist::ZERO);
            let mut arrived = None;
            for _ in 0..1500 {
                let way = way(&settings, pose, twist, to, reverse);
                let next = MpcTuning::default().best(&settings, &way);
                prop_assert!(drive.limited(next).linear.abs() >= next.linear.abs() - 1e-12, "{next:?}");
                prop_assert!(next.linear.abs() <= way.speed(&settings).max(twist.linear.abs()) + 1e-12);
                prop_assert!(drive.change_time(twist, next) <= settings.slot + 1e-9);
                prop_assert!(next.linear == 0.0 || (next.linear < 0.0) == reverse);
                twist = next;
                pose = pose.then(integrate(twist, settings.slot));
                let (ahead, _) = pose.toward(to);
                let ahead = if reverse { -ahead } else { ahead };
                if ahead <= 0.0 || pose.point().distance(to) <= settings.steering.stop_radius {
                    arrived = Some(pose.point().distance(to));
                    break;
                }
            }
            prop_assert!(arrived.is_some_and(|off| off <= 0.005), "{arrived:?}");
            // Slow enough to stop within a slot.
            prop_assert!(twist.linear.abs() <= 0.05, "{twist:?}");
        }
    }

    #[test]
    fn on_its_line_it_drives_straight_on_at_full_speed() {
        let settings = Settings::default();
        let previous = Twist::new(0.13, 0.0);
        let way = way(&settings, Pose::default(), previous, Point::new(1.0, 0.0), false);
        assert_eq!(MpcTuning::default().best(&settings, &way), previous);
    }
}
