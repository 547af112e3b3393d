//! The identified environment: per channel and for the link.
//!
//! Simulated environments, which have names, stand in [`crate::training`].

use crate::id::PriorId;
use crate::number::known;
use crate::prior::Source;
use crate::robot::{DEFAULT_PRIOR, Method};
use crate::watch;
use serde::{Deserialize, Serialize};
use umwelt_core::identification::Status as CoreStatus;
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
    /// What was believed before any sample, and why that.
    pub prior: Prior,
}

/// The prior behind what is identified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = environment::Prior)]
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
            Method::Bayesian => "",
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

/// How far an estimate has got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = environment::Status)]
pub enum Status {
    /// No sample can change it: it is a constant of a fixed model.
    Unestimated,
    /// The prior still dominates.
    Estimating,
    /// The samples say at least as much as the prior.
    Estimated,
    /// Samples are set aside: the watch holds the robot at rest because its motion is not what was commanded.
    Rejected,
    /// Something of another version.
    #[default]
    #[serde(other)]
    Other,
}

impl From<CoreStatus> for Status {
    fn from(core: CoreStatus) -> Self {
        match core {
            CoreStatus::Unestimated => Self::Unestimated,
            CoreStatus::Estimating { .. } => Self::Estimating,
            CoreStatus::Estimated => Self::Estimated,
            CoreStatus::Rejected { .. } => Self::Rejected,
        }
    }
}

impl Status {
    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unestimated => "unestimated",
            Self::Estimating => "estimating",
            Self::Estimated => "estimated",
            Self::Rejected => "rejected",
            Self::Other => "other",
        }
    }
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

impl Environment {
    /// What was identified, beginning with `prior`.
    pub fn new(core: &estimate::Estimates, prior: Prior) -> Self {
        let [forward, lateral, turn, drift] = core.channels.map(Channel::from);
        Self {
            method: core.method.into(),
            level: LEVEL,
            channels: Channels { forward, lateral, turn, drift },
            link: core.link.into(),
            windows_rejected: core.windows_rejected,
            poses_set_aside: core.poses_set_aside,
            prior,
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
            status: core.status.into(),
            estimated_fraction: core.status.fraction().and_then(known),
            rejected_for: match core.status {
                CoreStatus::Rejected { reason } => Some(reason.into()),
                _ => None,
            },
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
            delay_status: core.delay_status.into(),
            delay_estimated_fraction: core.delay_status.fraction().and_then(known),
            late_status: core.late_status.into(),
            late_estimated_fraction: core.late_status.fraction().and_then(known),
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
    use crate::evolution::Optimizer;
    use umwelt_core::settings;

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
            status: CoreStatus::Estimating { fraction: 0.25 },
        };
        let link = estimate::LinkEstimate {
            samples,
            median: Some(number),
            p99: Some(number),
            late,
            late_probability: number,
            late_interval: (number, number),
            chance_of_luck: 0.95f64.powf(samples as f64),
            delay_status: CoreStatus::Estimated,
            late_status: CoreStatus::Estimating { fraction: 0.5 },
        };
        let core = estimate::Estimates {
            method: settings::Method::Bayesian,
            channels: estimate::Channel::ALL.map(channel),
            link,
            windows_rejected: 1,
            poses_set_aside: 2,
        };
        Environment::new(&core, Prior::of(None, Source::Inline, Method::Bayesian))
    }

    #[test]
    fn what_core_knows_is_told_unchanged() {
        let wire = environment(0.125, 7, 1);
        assert_eq!(wire.channels.turn.mean, Some(0.125));
        assert_eq!(wire.channels.drift.mean_interval, Some(Interval { low: 0.125, high: 0.125 }));
        assert_eq!(wire.link.late_probability, Some(0.125));
        assert_eq!((wire.channels.turn.samples, wire.windows_rejected), (7, 1));
        let turn = wire.channels.turn;
        assert_eq!((turn.status, turn.estimated_fraction), (Status::Estimating, Some(0.25)));
        let Link { delay_status, delay_estimated_fraction, late_status, .. } = wire.link;
        assert_eq!((delay_status, delay_estimated_fraction), (Status::Estimated, Some(1.0)));
        assert_eq!(late_status, Status::Estimating);
    }

    #[test]
    fn every_status_has_the_name_of_core() {
        use umwelt_core::watch::Condition;
        for core in [
            CoreStatus::Unestimated,
            CoreStatus::Estimating { fraction: 0.5 },
            CoreStatus::Estimated,
            CoreStatus::Rejected { reason: Condition::Stuck },
        ] {
            let status = Status::from(core);
            assert_eq!(serde_json::to_value(status).unwrap(), core.name());
            assert_eq!(status.name(), core.name());
        }
        assert_eq!(serde_json::from_str::<Status>("\"of-tomorrow\"").unwrap(), Status::Other);
    }

    #[test]
    fn what_samples_are_set_aside_for_is_named() {
        use umwelt_core::identification::Belief;
        use umwelt_core::settings::Prior as CorePrior;
        use umwelt_core::watch::Condition;
        let shown = |method, rejected| {
            let belief = Belief::new(method, &CorePrior::default(), false);
            let prior = Prior::of(None, Source::Inline, method.into());
            Environment::new(&belief.estimates(rejected), prior).channels.forward
        };
        let stuck = shown(settings::Method::Bayesian, Some(Condition::Stuck));
        assert_eq!(
            (stuck.status, stuck.rejected_for),
            (Status::Rejected, Some(watch::State::Stuck))
        );
        assert_eq!(stuck.estimated_fraction, None);
        let fixed = shown(settings::Method::FixedBad, None);
        assert_eq!((fixed.status, fixed.rejected_for), (Status::Unestimated, None));
    }

    /// A server of an earlier version says nothing of it.
    #[test]
    fn an_environment_without_statuses_is_read() {
        let mut json = serde_json::to_value(environment(0.5, 7, 1)).unwrap();
        let forward = json["channels"]["forward"].as_object_mut().unwrap();
        forward.retain(|name, _| {
            !["status", "estimated_fraction", "rejected_for"].contains(&name.as_str())
        });
        let wire: Environment = serde_json::from_value(json).unwrap();
        assert_eq!(wire.channels.forward.status, Status::Other);
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
