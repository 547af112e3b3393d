//! How wheels follow a command: first-order lag.

use crate::geometry::WheelSpeeds;
use crate::geometry::elementary::exp;

/// How the wheels get from `current` toward `command` in `duration` s with first-order lag:
/// their speeds at the end, and their mean speeds over the time.
///
/// w' = (u - w)/tau: w(t) = u + (w_0 - u) e^(-t/tau), mean = u + (w_0 - u) tau/t (1 - e^(-t/tau)).
pub fn follow(
    lag: f64,
    current: WheelSpeeds,
    command: WheelSpeeds,
    duration: f64,
) -> (WheelSpeeds, WheelSpeeds) {
    if lag <= 0.0 {
        return (command, command);
    }
    if duration <= 0.0 {
        return (current, current);
    }
    let (decay, mean) = left_over(lag, duration);
    let (left, right) = (current.left - command.left, current.right - command.right);
    (
        WheelSpeeds { left: command.left + left * decay, right: command.right + right * decay },
        WheelSpeeds { left: command.left + left * mean, right: command.right + right * mean },
    )
}

/// What a first-order lag leaves of a difference after `duration` s: at the end, and on average. Both are positive.
pub fn left_over(lag: f64, duration: f64) -> (f64, f64) {
    let share = duration / lag;
    let decay = exp(-share);
    (decay, (1.0 - decay) / share)
}
