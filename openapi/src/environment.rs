//! The identified environment: per channel and for the link.

use crate::number::known;
use crate::robot::Method;
use serde::{Deserialize, Serialize};
use umwelt_core::identification::estimate::{self, LEVEL};
use utoipa::ToSchema;

/// Above this chance of luck a record without late packets says little, and the response says so.
pub const LUCK: f64 = 0.05;

/// What is identified of the environment of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = environment::Environment)]
pub struct Environment {
    /// How it was identified.
    pub method: Method,
    /// Probability mass of every interval.
    pub level: f64,
    /// Control errors per channel, in the body frame.
    pub channels: Channels,
    /// The link.
    pub link: Link,
    /// Windows of motion that gave no sample because the commanded motion was not constant.
    pub windows_rejected: u64,
    /// Poses set aside because the robot cannot have moved there.
    pub poses_set_aside: u64,
}

/// Control errors per channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = environment::Channels)]
pub struct Channels {
    /// Forward error per metre commanded.
    pub forward: Channel,
    /// Lateral error per metre commanded.
    pub lateral: Channel,
    /// Heading error per radian commanded.
    pub turn: Channel,
    /// Heading error in rad per metre commanded.
    pub drift: Channel,
}

/// What is believed about one channel's error ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = environment::Channel)]
pub struct Channel {
    /// Whether predictions use it.
    pub used: bool,
    /// Expected ratio; null where there is none.
    pub mean: Option<f64>,
    /// Standard deviation of the ratio over 100 ms; null where the belief is too weak to have one.
    pub sd: Option<f64>,
    /// Holds the mean with probability `level`; null for a fixed model.
    pub mean_interval: Option<Interval>,
    /// Holds the next ratio over 100 ms with probability `level`; null where there is none.
    pub predictive_interval: Option<Interval>,
    /// Samples taken.
    pub samples: u64,
    /// Samples that they are worth, discounted for their correlation.
    pub effective_samples: Option<f64>,
    /// Natural logarithm of the evidence of the samples under the prior; 0 without samples.
    pub ln_evidence: Option<f64>,
}

/// From `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = environment::Interval)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// What is believed about the link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = environment::Link)]
pub struct Link {
    /// Deliveries reported.
    pub samples: u64,
    /// Median loop delay; null before the first delivery.
    pub median_s: Option<f64>,
    /// 99 % quantile of a loop delay that is not late; null before the first delivery.
    pub p99_s: Option<f64>,
    /// Deliveries that were late: more than three slots above the median, not merely held back behind a late one.
    pub late: u64,
    /// Expected probability that a delivery is late.
    pub late_probability: Option<f64>,
    /// Holds that probability with probability `level`.
    pub late_interval: Option<Interval>,
    /// Probability that a link with 5 % late packets would have shown none in as many samples.
    pub chance_of_luck: Option<f64>,
    /// What the numbers do not show at first sight; null where there is nothing to say.
    pub note: Option<String>,
}

impl From<&estimate::Environment> for Environment {
    fn from(core: &estimate::Environment) -> Self {
        let [forward, lateral, turn, drift] = core.channels.map(Channel::from);
        Self {
            method: core.method.into(),
            level: LEVEL,
            channels: Channels { forward, lateral, turn, drift },
            link: core.link.into(),
            windows_rejected: core.windows_rejected,
            poses_set_aside: core.poses_set_aside,
        }
    }
}

impl From<estimate::ChannelEstimate> for Channel {
    fn from(core: estimate::ChannelEstimate) -> Self {
        Self {
            used: core.used,
            mean: known(core.mean),
            sd: core.sd.and_then(known),
            mean_interval: core.mean_interval.and_then(interval),
            predictive_interval: core.predictive_interval.and_then(interval),
            samples: core.samples,
            effective_samples: known(core.effective_samples),
            ln_evidence: known(core.ln_evidence),
        }
    }
}

impl From<estimate::LinkEstimate> for Link {
    fn from(core: estimate::LinkEstimate) -> Self {
        Self {
            samples: core.samples,
            median_s: core.median.and_then(known),
            p99_s: core.p99.and_then(known),
            late: core.late,
            late_probability: known(core.late_probability),
            late_interval: interval(core.late_interval),
            chance_of_luck: known(core.chance_of_luck),
            note: note(&core),
        }
    }
}

fn interval((low, high): (f64, f64)) -> Option<Interval> {
    (low.is_finite() && high.is_finite()).then_some(Interval { low, high })
}

fn note(link: &estimate::LinkEstimate) -> Option<String> {
    let luck = link.chance_of_luck;
    if link.late > 0 || luck.is_nan() || luck <= LUCK {
        return None;
    }
    Some(format!(
        "no late packet in {} deliveries says little yet: a link with 5 % late packets shows none in as many with probability {luck:.2}",
        link.samples
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_core::controller::settings;

    fn environment(number: f64, samples: u64, late: u64) -> Environment {
        let channel = |channel| estimate::ChannelEstimate {
            channel,
            used: true,
            mean: number,
            sd: Some(number),
            mean_interval: Some((number, number)),
            predictive_interval: None,
            samples,
            effective_samples: number,
            ln_evidence: number,
        };
        let link = estimate::LinkEstimate {
            samples,
            median: Some(number),
            p99: Some(number),
            late,
            late_probability: number,
            late_interval: (number, number),
            chance_of_luck: 0.95f64.powf(samples as f64),
        };
        Environment::from(&estimate::Environment {
            method: settings::Method::Bayesian,
            channels: estimate::Channel::ALL.map(channel),
            link,
            windows_rejected: 1,
            poses_set_aside: 2,
        })
    }

    #[test]
    fn what_core_knows_is_told_unchanged() {
        let wire = environment(0.125, 7, 1);
        assert_eq!(wire.channels.turn.mean, Some(0.125));
        assert_eq!(wire.channels.drift.mean_interval, Some(Interval { low: 0.125, high: 0.125 }));
        assert_eq!(wire.link.late_probability, Some(0.125));
        assert_eq!((wire.channels.turn.samples, wire.windows_rejected), (7, 1));
    }

    #[test]
    fn what_is_no_number_is_null_and_can_be_read_again() {
        for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let wire = environment(number, 7, 1);
            assert_eq!(wire.channels.forward.mean, None);
            let json = serde_json::to_string(&wire).unwrap();
            assert_eq!(serde_json::from_str::<Environment>(&json).unwrap(), wire);
        }
    }

    #[test]
    fn luck_is_named_until_it_is_small_or_something_was_late() {
        assert!(environment(0.1, 12, 0).link.note.is_some_and(|note| note.contains("0.54")));
        assert_eq!(environment(0.1, 59, 0).link.note, None);
        assert_eq!(environment(0.1, 12, 1).link.note, None);
    }
}
