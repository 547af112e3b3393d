//! What is identified.

use super::known;
use crate::environment::{
    Channel, Channels, Drive, Environment, Interval, LUCK, Link, Noise, Prior, Status,
};
use umwelt_core::identification::Status as CoreStatus;
use umwelt_core::identification::estimate::{self, LEVEL};

impl Environment {
    /// What was identified, beginning with `prior`, of the drive and of the noise of poses too.
    pub fn new(
        core: &estimate::Estimates,
        drive: Drive,
        noise: Option<Noise>,
        prior: Prior,
    ) -> Self {
        let [forward, lateral, turn, drift] = core.channels.map(Channel::from);
        Self {
            method: core.method.into(),
            level: LEVEL,
            channels: Channels { forward, lateral, turn, drift },
            drive: Some(drive),
            noise,
            link: core.link.into(),
            windows_rejected: core.windows_rejected,
            poses_set_aside: core.poses_set_aside,
            prior,
        }
    }
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

pub(super) fn interval((low, high): (f64, f64)) -> Option<Interval> {
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
    use crate::prior::Source;
    use crate::robot::Method;
    use crate::watch;
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
        Environment::new(&core, given(), None, Prior::of(None, Source::Inline, Method::Bayesian))
    }

    fn given() -> Drive {
        Drive::new(None, &settings::Settings::default())
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
            Environment::new(&belief.estimates(rejected), given(), None, prior).channels.forward
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
}
