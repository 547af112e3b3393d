//! How late simulated drives follow their commands.

use crate::draws::{Draws, Stream};

/// Dead time and lag of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lateness {
    /// Time constant in s with which the wheels follow a command.
    pub lag: f64,
    /// Time in s before they begin to.
    pub dead_time: f64,
}

impl Lateness {
    /// That of the robot of this seed, one of those of the 0.1 m class: a lag of 60 to 160 ms, a dead time of 0 to 40 ms (field
    /// facts).
    ///
    /// ```
    /// use umwelt_core::plant::Lateness;
    /// let drawn = Lateness::drawn(7);
    /// assert!((0.06..0.16).contains(&drawn.lag) && (0.0..0.04).contains(&drawn.dead_time));
    /// assert_eq!(drawn, Lateness::drawn(7));
    /// ```
    pub fn drawn(seed: u64) -> Self {
        let mut draws = Draws::new(seed, Stream::Lateness, 0);
        Self { lag: 0.06 + 0.1 * draws.uniform(), dead_time: 0.04 * draws.uniform() }
    }
}
