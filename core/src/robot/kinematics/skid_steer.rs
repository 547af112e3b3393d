//! Skid steer: wheels or tracks that slide sideways wherever the robot turns.

use super::differential::Differential;
use super::model::MotionModel;
use crate::geometry::elementary::{least, most};
use crate::geometry::{Twist, WheelSpeeds};

/// Between these the turn of a moving robot is to that of the same wheels at standstill, whatever its speed: a description
/// beyond means nothing.
pub const TURN_RATIO: (f64, f64) = (0.5, 1.5);

/// Steps of halving in which a limit is found: to a part of 2^-40 of what lies between.
const HALVINGS: u32 = 40;

/// How a skid-steer robot differs from a differential drive of the same wheels whose track is as wide as it turns at
/// standstill.
///
/// Its wheels touch the ground ahead of and behind its middle, and slide across it in a turn: the two sides have
/// instantaneous centres of rotation outside of them, which move with speed, load and ground (Martinez et al. 2005, Mandow
/// et al. 2007, Wang et al. 2015). That they lie farther apart than the wheels is [`Drive::track_width`]; that this changes
/// with speed, and that they lie ahead of the middle or behind it, are these two numbers.
///
/// [`Drive::track_width`]: super::Drive::track_width
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkidSteer {
    /// By what part the turn of the same difference of the wheels grows per m/s of speed, either way, in s/m.
    pub turn_by_speed: f64,
    /// Motion of the middle to the left in m per radian of turn to the left.
    pub sideways: f64,
}

/// A skid-steer robot and its wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkidSteering {
    /// The differential drive that turns as it does at standstill.
    pub wheels: Differential,
    /// How it differs.
    pub skid: SkidSteer,
}

impl SkidSteer {
    /// The turn at a speed of `linear` m/s to that of the same difference of the wheels at standstill: 1 + k |v|.
    pub fn turn_ratio(&self, linear: f64) -> f64 {
        let (low, high) = TURN_RATIO;
        most(low, least(high, 1.0 + self.turn_by_speed * linear.abs()))
    }
}

impl MotionModel for SkidSteering {
    /// v = r/2 (w_r + w_l), omega = r/W (w_r - w_l) (1 + k |v|).
    fn forward(&self, speeds: WheelSpeeds) -> Twist {
        let Twist { linear, angular } = self.wheels.forward(speeds);
        Twist { linear, angular: angular * self.skid.turn_ratio(linear) }
    }

    fn inverse(&self, twist: Twist) -> WheelSpeeds {
        let Twist { linear, angular } = twist;
        self.wheels.inverse(Twist { linear, angular: angular / self.skid.turn_ratio(linear) })
    }

    fn sideways(&self) -> f64 {
        self.skid.sideways
    }

    fn share(&self, twist: Twist, over: f64, fastest: f64) -> f64 {
        if self.skid.turn_by_speed == 0.0 {
            return self.wheels.share(twist, over, fastest);
        }
        let fits = |share: f64| {
            let WheelSpeeds { left, right } = self.inverse(twist.scaled(share));
            left.abs() <= fastest && right.abs() <= fastest
        };
        largest(0.0, if over > 1.0 { 1.0 / over } else { 1.0 }, fits)
    }

    fn faster(&self, linear: f64, turning: f64) -> f64 {
        linear + turning / self.skid.turn_ratio(linear)
    }

    fn linear_within(&self, room: f64, turning: f64, least: f64, most: f64) -> f64 {
        if self.skid.turn_by_speed == 0.0 {
            return self.wheels.linear_within(room, turning, least, most);
        }
        largest(least, most, |linear| self.faster(linear, turning) <= room)
    }

    fn turning_within(&self, room: f64, linear: f64, least: f64) -> f64 {
        most(least, (room - linear) * self.skid.turn_ratio(linear))
    }
}

/// The largest value from `low` to `high` that `fits`, where all below one that fits do so, too; `low` where none does.
fn largest(low: f64, high: f64, fits: impl Fn(f64) -> bool) -> f64 {
    if fits(high) {
        return high;
    }
    let (mut low, mut high) = (low, high);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if fits(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
