//! Motion at constant speeds: the exact arc.

use crate::geometry::elementary::sinc_cos;
use crate::geometry::{Displacement, Twist};

/// The motion of holding `twist` for `duration` s: the exact arc, a straight line as its limit.
///
/// Thesis eq. 8-9, corrected: displacement = rate x duration, and along the arc, not the starting tangent.
pub fn integrate(twist: Twist, duration: f64) -> Displacement {
    arc(twist.linear * duration, twist.angular * duration)
}

/// The motion along an arc of `length` m that turns by `turn` rad.
///
/// The chord is `length` sinc(turn/2), at half the turn.
pub fn arc(length: f64, turn: f64) -> Displacement {
    if length == 0.0 {
        return Displacement { forward: 0.0, lateral: 0.0, turn };
    }
    let half = turn / 2.0;
    let (sinc, cos) = sinc_cos(half);
    let chord = length * sinc;
    Displacement { forward: chord * cos, lateral: chord * (half * sinc), turn }
}
