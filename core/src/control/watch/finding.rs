//! What a look of the watch comes to.

use super::alarm::Alarm;

/// What a look found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// Nothing new.
    Nothing,
    /// The robot moves as commanded.
    Healthy,
    /// The robot is to rest until it is resumed.
    Rest(Alarm),
    /// Worth saying; the robot goes on.
    Remark(Alarm),
    /// A smallest speed was raised.
    Raised(Alarm),
}
