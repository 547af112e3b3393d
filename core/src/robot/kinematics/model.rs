//! What a robot of any kind makes of its commands: f(X, B, epsilon) of thesis chapter 3.

use crate::geometry::elementary::{sin_cos, sinc_cos};
use crate::geometry::{Displacement, Pose, Twist, WheelSpeeds};

/// Errors of a motion, each relative to what is commanded (epsilon; thesis eq. 22 and 24).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Motion ahead in m per metre commanded.
    pub forward: f64,
    /// Motion to the left in m per metre commanded.
    pub lateral: f64,
    /// Turn in rad per radian commanded.
    pub turn: f64,
    /// Turn in rad per metre commanded.
    pub drift: f64,
}

/// The motion model of a kind of robot that is commanded by two wheel speeds.
///
/// A robot turns in place about its **turning centre**, which moves along the heading alone. Its pose is that of its
/// **middle**, the point that is tracked and that waypoints are for: [`MotionModel::sideways`] m ahead of the centre. Twists
/// are those of the centre; while it turns, the middle moves sideways as well.
pub trait MotionModel {
    /// The twist of turning the wheels at `speeds`.
    fn forward(&self, speeds: WheelSpeeds) -> Twist;

    /// The wheel speeds that make the body move with `twist`.
    fn inverse(&self, twist: Twist) -> WheelSpeeds;

    /// Motion of the middle to the left in m per radian of turn to the left: how far it lies ahead of the turning centre.
    fn sideways(&self) -> f64;

    /// The largest share of `twist`, at most one, whose wheels turn at no more than `fastest` rad/s and which is within the
    /// body's limits, of which `twist` is `over` times one.
    fn share(&self, twist: Twist, over: f64, fastest: f64) -> f64;

    /// How fast in m/s the faster wheel runs over the ground where the robot drives at `linear` m/s and its turn asks for
    /// `turning` m/s of each wheel at standstill, both positive.
    fn faster(&self, linear: f64, turning: f64) -> f64;

    /// The largest `linear` from `least` to `most` with which [`MotionModel::faster`] is at most `room`; `least` where there
    /// is none.
    fn linear_within(&self, room: f64, turning: f64, least: f64, most: f64) -> f64;

    /// The largest `turning` with which [`MotionModel::faster`] is at most `room`; at least `least`.
    fn turning_within(&self, room: f64, linear: f64, least: f64) -> f64;

    /// The pose after a commanded arc of `length` m and `turn` rad with `errors`: f(X, B, epsilon).
    ///
    /// Thesis eq. 8-9, corrected: forward and sideways speed and turning rate are constant, so it is the exact arc of
    /// both, whose chord points at half the turn.
    fn next(&self, pose: Pose, length: f64, turn: f64, errors: &Errors) -> Pose {
        let (sideways, turn) = (self.sideways(), turn * (1.0 + errors.turn));
        if length == 0.0 && sideways == 0.0 {
            return Pose { heading: pose.heading + turn, ..pose };
        }
        let turn = turn + length * errors.drift;
        let forward = length * (1.0 + errors.forward);
        let lateral = length * errors.lateral;
        let lateral = if sideways == 0.0 { lateral } else { lateral + sideways * turn };
        let (sinc, _) = sinc_cos(turn / 2.0);
        let (sin, cos) = sin_cos(pose.heading.radians() + turn / 2.0);
        Pose {
            x: pose.x + sinc * (cos * forward - sin * lateral),
            y: pose.y + sinc * (sin * forward + cos * lateral),
            heading: pose.heading + turn,
        }
    }

    /// The pose of the turning centre where the middle has this one.
    fn centre_of(&self, middle: Pose) -> Pose {
        ahead(middle, -self.sideways())
    }

    /// The motion of the middle where the turning centre makes this one.
    ///
    /// ```
    /// use umwelt_core::geometry::{Displacement, Pose};
    /// use umwelt_core::kinematics::{Drive, Kind, MotionModel, SkidSteer};
    /// let kind = Kind::SkidSteer(SkidSteer { sideways: 0.05, turn_by_speed: 0.0 });
    /// let drive = Drive { kind, ..Drive::default() };
    /// let half_turn = Displacement { turn: std::f64::consts::PI, ..Displacement::default() };
    /// let moved = Pose::default().then(drive.of_middle(half_turn));
    /// assert!((moved.x + 0.1).abs() < 1e-12 && moved.y.abs() < 1e-12);
    /// ```
    fn of_middle(&self, of_centre: Displacement) -> Displacement {
        about(of_centre, self.sideways())
    }

    /// The motion of the turning centre where the middle makes this one.
    fn of_centre(&self, of_middle: Displacement) -> Displacement {
        about(of_middle, -self.sideways())
    }
}

/// The pose `by` m ahead.
fn ahead(pose: Pose, by: f64) -> Pose {
    if by == 0.0 {
        return pose;
    }
    pose.then(Displacement { forward: by, ..Displacement::default() })
}

/// The motion of a point `by` m ahead of one that moves by `displacement`.
fn about(displacement: Displacement, by: f64) -> Displacement {
    if by == 0.0 {
        return displacement;
    }
    let (sin, cos) = sin_cos(displacement.turn);
    Displacement {
        forward: displacement.forward + by * (cos - 1.0),
        lateral: displacement.lateral + by * sin,
        ..displacement
    }
}
