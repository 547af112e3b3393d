//! A belief as it is shown: estimates per channel and for the link.

use super::status::Status;
use crate::settings::Method;
use serde::{Deserialize, Serialize};

/// Probability mass of every interval that is shown.
pub const LEVEL: f64 = 0.90;

/// Half the width of an interval that is shown, in standard deviations of a normal distribution.
pub const NORMAL_HALF_WIDTH: f64 = 1.644_853_626_951_472_2;

/// A channel of control errors, in the body frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Channel {
    /// Forward error per metre commanded.
    Forward,
    /// Lateral error per metre commanded.
    Lateral,
    /// Heading error per radian commanded.
    Turn,
    /// Heading error in rad per metre commanded.
    Drift,
}

impl Channel {
    /// Every channel, in the order in which they are stored and shown.
    pub const ALL: [Self; 4] = [Self::Forward, Self::Lateral, Self::Turn, Self::Drift];

    /// The name used on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::Lateral => "lateral",
            Self::Turn => "turn",
            Self::Drift => "drift",
        }
    }
}

/// What is believed about one channel's error ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelEstimate {
    /// Which channel.
    pub channel: Channel,
    /// Whether predictions use it.
    pub used: bool,
    /// Expected ratio.
    pub mean: f64,
    /// Standard deviation of the ratio over 100 ms; none where the belief is too weak to have one.
    pub sd: Option<f64>,
    /// Interval that holds the mean with probability [`LEVEL`]; none for a fixed model.
    pub mean_interval: Option<(f64, f64)>,
    /// Interval that holds the next ratio over 100 ms with probability [`LEVEL`].
    pub predictive_interval: Option<(f64, f64)>,
    /// Samples taken.
    pub samples: u64,
    /// Samples that they are worth, discounted for their lag-1 correlation.
    pub effective_samples: f64,
    /// Natural logarithm of the evidence of the samples under the prior; 0 without samples.
    pub ln_evidence: f64,
    /// How far the estimate has got.
    pub status: Status,
}

/// What is believed about the link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkEstimate {
    /// Deliveries reported.
    pub samples: u64,
    /// Median loop delay in s; none before the first delivery.
    pub median: Option<f64>,
    /// 99 % quantile in s of a loop delay that is not late.
    pub p99: Option<f64>,
    /// Deliveries that were late: more than three slots above the median, not merely held back behind a late one.
    pub late: u64,
    /// Expected probability that a delivery is late.
    pub late_probability: f64,
    /// Interval that holds that probability with probability [`LEVEL`].
    pub late_interval: (f64, f64),
    /// Probability that a link with 5 % late packets would have shown none in as many samples (0.95^n).
    /// Until it is small, a good record says little.
    pub chance_of_luck: f64,
    /// How far the estimate of the loop delay has got.
    pub delay_status: Status,
    /// How far the estimate of the probability of late packets has got.
    pub late_status: Status,
}

/// What was identified of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// How it was identified.
    pub method: Method,
    /// Per channel, in the order of [`Channel::ALL`].
    pub channels: [ChannelEstimate; 4],
    /// The link.
    pub link: LinkEstimate,
    /// Windows of motion that gave no sample because the commanded motion was not constant.
    pub windows_rejected: u64,
    /// Poses set aside because the robot cannot have moved there.
    pub poses_set_aside: u64,
}
