//! The identified environment: per channel and for the link.
//!
//! Simulated environments, which have names, stand in [`crate::training`].

mod band;
mod drive;
mod estimate;
mod kind;
mod noise;
mod scale;

pub use band::DeadBand;
pub use drive::Drive;
pub use estimate::{Estimate, Interval, Status};
pub use kind::{Kind, NOTE};
pub use noise::Noise;
pub use scale::{Scale, Split};

use crate::id::PriorId;
use crate::prior::Source;
use crate::robot::{DEFAULT_PRIOR, Method};
use crate::schema::ToSchema;
use crate::watch;
use serde::{Deserialize, Serialize};

/// Probability mass of every interval.
pub const LEVEL: f64 = 0.90;

/// Above this chance of luck a record without late packets says little, and the response says so.
pub const LUCK: f64 = 0.05;

/// What is identified of the environment of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Environment)]
pub struct Environment {
    /// How it was identified.
    pub method: Method,
    /// Probability mass of every interval.
    pub level: f64,
    /// Control errors per channel, in the body frame.
    pub channels: Channels,
    /// How late the drive follows its commands. It stays when the robot comes to another environment: a reset keeps it.
    #[serde(default)]
    pub drive: Option<Drive>,
    /// How noisy the poses are, where the method fuses them with what the commands predict; null where it takes them as they
    /// are.
    #[serde(default)]
    pub noise: Option<Noise>,
    /// The link.
    pub link: Link,
    /// Windows of motion that gave no sample because the commanded motion was not constant.
    pub windows_rejected: u64,
    /// Poses set aside because the robot cannot have moved there.
    pub poses_set_aside: u64,
    /// What was believed before any sample, and why that.
    pub prior: Prior,
}

/// The prior behind what is identified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EnvironmentPrior)]
pub struct Prior {
    /// Its name; null where the description of the robot has its own numbers.
    pub name: Option<PriorId>,
    /// Where it comes from.
    pub source: Source,
    /// Why this one, in one sentence.
    pub why: String,
}

impl Prior {
    /// The prior of this name and source, as a robot identified by `method` uses it.
    ///
    /// ```
    /// use umwelt_api::environment::Prior;
    /// use umwelt_api::{prior::Source, robot::Method};
    /// let prior = Prior::of(Some("wet-hall".parse()?), Source::Put, Method::Bayesian);
    /// assert_eq!(prior.why, "the description of the robot names wet-hall, which somebody put");
    /// # Ok::<(), umwelt_api::InvalidId>(())
    /// ```
    pub fn of(name: Option<PriorId>, source: Source, method: Method) -> Self {
        let used = match &name {
            Some(name) if name.as_str() == DEFAULT_PRIOR => format!(
                "the description of the robot names no other than {name}, which is weak: samples soon outweigh it"
            ),
            Some(name) => format!("the description of the robot names {name}, {}", origin(&source)),
            None => "the description of the robot has numbers of its own".to_owned(),
        };
        let unused = match method {
            Method::Bayesian | Method::Adaptive => "",
            Method::Statistic => "; method statistic does not use it: it has samples only",
            Method::FixedNormal => "; method fixed-normal does not use it: it learns nothing",
            Method::FixedBad => "; method fixed-bad does not use it: it learns nothing",
        };
        Self { name, source, why: used + unused }
    }
}

/// Where a named prior comes from, in words.
fn origin(source: &Source) -> String {
    match source {
        Source::BuiltIn => "which comes with the server".to_owned(),
        Source::Put => "which somebody put".to_owned(),
        Source::Evolution { evolution, seed, optimizer, fitness } => {
            let optimizer = optimizer.name();
            let fitness = fitness.map(|it| format!(", fitness {it:.3}")).unwrap_or_default();
            format!("which {evolution} found ({optimizer}, seed {seed}{fitness})")
        }
        Source::Inline => "which stands there in numbers".to_owned(),
    }
}

/// Control errors per channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Channels)]
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
#[schema(as = Channel)]
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
    /// How far the estimate has got.
    #[serde(default)]
    pub status: Status,
    /// Part of the samples that it takes until the prior no longer dominates, 1 once it does not; null where `status` is
    /// `unestimated` or `rejected`.
    #[serde(default)]
    pub estimated_fraction: Option<f64>,
    /// What the watch found, for which samples are set aside; null where `status` is not `rejected`.
    #[serde(default)]
    pub rejected_for: Option<watch::State>,
}

/// What is believed about the link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EnvironmentLink)]
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
    /// How far the estimate of the loop delay has got.
    #[serde(default)]
    pub delay_status: Status,
    /// Part of the deliveries that it takes until the prior no longer dominates; 1 once it does not.
    #[serde(default)]
    pub delay_estimated_fraction: Option<f64>,
    /// How far the estimate of the probability of late packets has got.
    #[serde(default)]
    pub late_status: Status,
    /// Part of the deliveries that it takes until a link with 5 % late packets would have shown one; 1 once it would.
    #[serde(default)]
    pub late_estimated_fraction: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolution::Optimizer;

    #[test]
    fn why_this_prior_is_said_in_a_sentence() {
        let why = |name: &str, source, method| Prior::of(name.parse().ok(), source, method).why;
        let evolved = |fitness| Source::Evolution {
            evolution: "evolution-12".parse().unwrap(),
            seed: 7,
            optimizer: Optimizer::CmaEs,
            fitness,
        };
        let words = why("hall", evolved(Some(1.25)), Method::Bayesian);
        assert!(
            words.ends_with("names hall, which evolution-12 found (cma-es, seed 7, fitness 1.250)")
        );
        assert!(why("hall", evolved(None), Method::Bayesian).ends_with("(cma-es, seed 7)"));
        assert!(why("default", Source::BuiltIn, Method::Bayesian).contains("weak"));
        assert!(why("", Source::Inline, Method::Bayesian).contains("of its own"));
        assert!(why("hall", Source::Put, Method::Statistic).contains("does not use it"));
        assert!(why("hall", Source::Put, Method::FixedBad).contains("does not use it"));
    }
}
