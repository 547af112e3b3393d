//! What a floor does to the commanded motion.

use crate::prediction::ERROR_WINDOW;

/// The time in s over which a channel's standard deviation is stated: what is identified is stated over the same.
pub const SLIP_WINDOW: f64 = ERROR_WINDOW;

/// Greatest standard deviation of a channel; ten times what any floor of the field facts does.
pub const MAX_SLIP_SD: f64 = 4.0;

/// The names that [`Slip::preset`] knows, roughly from the best floor to the worst.
pub const SLIP_PRESETS: [&str; 8] =
    ["none", "hard", "loaded", "dusty", "slippery", "oily", "towing", "ramp"];

/// One ratio error: its mean, and its standard deviation over 100 ms at constant speed.
///
/// The error is white in time: over T s at constant speed the ratio's variance is sd^2 0.1 s/T.
///
/// ```
/// use umwelt_core::plant::SlipChannel;
/// let channel = SlipChannel::new(-0.1, 0.15)?;
/// assert_eq!((channel.mean(), channel.sd()), (-0.1, 0.15));
/// assert!(SlipChannel::new(0.0, -0.1).is_err());
/// # Ok::<(), umwelt_core::plant::SlipError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlipChannel {
    mean: f64,
    sd: f64,
}

/// Why two numbers are no slip.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SlipError {
    /// The mean is not between -1 and 1: the robot would be thrown back, or twice as far.
    #[error("a mean slip of {0} must be between -1 and 1, both excluded")]
    Mean(f64),
    /// The standard deviation is negative, not a number or above [`MAX_SLIP_SD`].
    #[error("a standard deviation of {0} must be between 0 and {MAX_SLIP_SD}")]
    Sd(f64),
}

impl SlipChannel {
    /// No error.
    pub const NONE: Self = Self { mean: 0.0, sd: 0.0 };

    /// The ratio error of `mean` and standard deviation `sd` over 100 ms.
    pub fn new(mean: f64, sd: f64) -> Result<Self, SlipError> {
        if mean.is_nan() || mean.abs() >= 1.0 {
            return Err(SlipError::Mean(mean));
        }
        if !(0.0..=MAX_SLIP_SD).contains(&sd) {
            return Err(SlipError::Sd(sd));
        }
        Ok(Self { mean, sd })
    }

    /// Mean of the ratio; for drift in rad/m.
    pub fn mean(self) -> f64 {
        self.mean
    }

    /// Standard deviation of the ratio over 100 ms at constant speed; for drift in rad/m.
    pub fn sd(self) -> f64 {
        self.sd
    }
}

/// What a floor adds to the commanded motion, in the body frame (thesis eq. 22-25, corrected).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slip {
    /// Forward motion per commanded forward motion; -0.1 is a tenth less far.
    pub forward: SlipChannel,
    /// Motion to the left per commanded forward motion.
    pub lateral: SlipChannel,
    /// Turn per commanded turn.
    pub turn: SlipChannel,
    /// Turn to the left in rad per commanded forward motion in m.
    pub drift: SlipChannel,
}

/// Shorthand for presets; a test checks their numbers.
const fn channel(mean: f64, sd: f64) -> SlipChannel {
    SlipChannel { mean, sd }
}

impl Slip {
    /// Every motion as commanded.
    pub const NONE: Self = Self {
        forward: SlipChannel::NONE,
        lateral: SlipChannel::NONE,
        turn: SlipChannel::NONE,
        drift: SlipChannel::NONE,
    };

    /// A dry, hard floor. Scale and turn are off by 0.4 % and 1 % (field facts: systematic errors between robots);
    /// the rest is below 1 % (field facts: dry friction in steady level driving).
    pub const HARD: Self = Self {
        forward: channel(0.004, 0.005),
        lateral: channel(0.0, 0.002),
        turn: channel(0.01, 0.01),
        drift: channel(0.0, 0.01),
    };

    /// A dusty floor: -5 % and 8 % sd, the mild ends of what field facts give for a film (-5 to -30 %) and for ice
    /// (8-35 % sd).
    pub const DUSTY: Self = Self {
        forward: channel(-0.05, 0.08),
        lateral: channel(0.0, 0.02),
        turn: channel(-0.05, 0.08),
        drift: channel(0.0, 0.1),
    };

    /// A slippery floor: -10 % and 15 % sd, within what field facts give for a film (-5 to -30 %) and for ice
    /// (8-35 % sd under changing commands).
    pub const SLIPPERY: Self = Self {
        forward: channel(-0.10, 0.15),
        lateral: channel(0.0, 0.05),
        turn: channel(-0.10, 0.15),
        drift: channel(0.0, 0.3),
    };

    /// An oily film: -20 %, in the middle of the constant -5 to -30 % of field facts, with the little spread that
    /// "constant" says.
    pub const OILY: Self = Self {
        forward: channel(-0.20, 0.05),
        lateral: channel(0.0, 0.03),
        turn: channel(-0.20, 0.05),
        drift: channel(0.0, 0.1),
    };

    /// A heavy load on a hard floor: -3 % and 5 % sd, which is the start of the 8-35 % sd that field facts give where
    /// a slope or load adds to a film, and a load that sits to one side, 0.1 rad/m. Our choice in both.
    pub const LOADED: Self = Self {
        forward: channel(-0.03, 0.05),
        lateral: channel(0.0, 0.01),
        turn: channel(-0.03, 0.05),
        drift: channel(0.1, 0.1),
    };

    /// Towing a load with patches under one wheel: -10 %, and a constant turn of 0.7 rad/m. Field facts give up to
    /// 80 degrees while towing; that it takes two metres is our choice.
    pub const TOWING: Self = Self {
        forward: channel(-0.10, 0.10),
        lateral: channel(0.0, 0.05),
        turn: channel(-0.10, 0.10),
        drift: channel(0.7, 0.5),
    };

    /// Uphill on a slippery ramp: -50 %, in the middle of the -40 to -60 % of field facts, 35 % sd as on ice.
    pub const RAMP: Self = Self {
        forward: channel(-0.50, 0.35),
        lateral: channel(0.0, 0.10),
        turn: channel(-0.30, 0.35),
        drift: channel(0.0, 0.5),
    };

    /// The floor called `name`, one of [`SLIP_PRESETS`].
    ///
    /// ```
    /// use umwelt_core::plant::{Slip, SLIP_PRESETS};
    /// assert!(SLIP_PRESETS.iter().all(|name| Slip::preset(name).is_some()));
    /// assert_eq!(Slip::preset("oily").map(|slip| slip.forward.mean()), Some(-0.2));
    /// assert_eq!(Slip::preset("lava"), None);
    /// ```
    pub fn preset(name: &str) -> Option<Self> {
        Some(match name {
            "none" => Self::NONE,
            "hard" => Self::HARD,
            "dusty" => Self::DUSTY,
            "slippery" => Self::SLIPPERY,
            "oily" => Self::OILY,
            "loaded" => Self::LOADED,
            "towing" => Self::TOWING,
            "ramp" => Self::RAMP,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_pass_the_check() {
        for name in SLIP_PRESETS {
            let slip = Slip::preset(name).unwrap();
            for channel in [slip.forward, slip.lateral, slip.turn, slip.drift] {
                assert_eq!(SlipChannel::new(channel.mean, channel.sd), Ok(channel), "{name}");
            }
        }
        assert_eq!(Slip::NONE, Slip::default());
    }

    #[test]
    fn what_is_no_slip_is_refused_with_its_value() {
        for mean in [-1.0, 1.0, 3.0, f64::INFINITY] {
            assert_eq!(SlipChannel::new(mean, 0.1), Err(SlipError::Mean(mean)));
        }
        assert!(matches!(SlipChannel::new(f64::NAN, 0.1), Err(SlipError::Mean(_))));
        for sd in [-0.1, 4.1, f64::INFINITY] {
            assert_eq!(SlipChannel::new(0.1, sd), Err(SlipError::Sd(sd)));
        }
        assert!(matches!(SlipChannel::new(0.1, f64::NAN), Err(SlipError::Sd(_))));
    }
}
