//! Observations and commands in flight become error samples, and these a belief.
//!
//! Each slip channel has a normal with unknown mean and variance (thesis eq. 32-38, corrected), the link a
//! normal on the logarithm of its loop delay and a Bernoulli for late packets.

mod channel;
pub mod estimate;
pub mod fixed;
mod link;
mod prior;
mod status;
mod window;

pub use channel::ChannelBelief;
pub use link::LinkBelief;
pub use prior::{BUILT_IN_PRIORS, about_built_in};
pub use status::{LEAST_SAMPLES, Status, progress};
pub use window::{MAX_WINDOW_SLOTS, Sample, Samples, Verdict, WINDOW_SLOTS, Window};

use super::condition::Condition;
use crate::prediction::{ChannelModel, ErrorModel, Scale};
use crate::settings::{Method, Prior};
use crate::time::RobotTime;
use estimate::{Channel, Estimates};
use serde::{Deserialize, Serialize};

/// What is believed of a robot's floor and link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Stored")]
pub struct Belief {
    method: Method,
    drift: bool,
    channels: [ChannelBelief; 4],
    /// The link.
    pub link: LinkBelief,
    /// Windows of motion that gave no sample because the commanded motion changed in them.
    pub windows_rejected: u64,
    /// Poses set aside because the robot cannot have moved there.
    pub poses_set_aside: u64,
}

/// A [`Belief`] as it is stored, by this version or an earlier one.
#[derive(Deserialize)]
struct Stored {
    method: Method,
    drift: bool,
    channels: [ChannelBelief; 4],
    link: LinkBelief,
    windows_rejected: u64,
    poses_set_aside: u64,
}

impl From<Stored> for Belief {
    fn from(stored: Stored) -> Self {
        let Stored { method, drift, channels, link, windows_rejected, poses_set_aside } = stored;
        // Earlier versions had one prior per channel whatever the method.
        let channels = match method {
            Method::Adaptive => channels.map(ChannelBelief::with_unknown_spread),
            _ => channels,
        };
        Self { method, drift, channels, link, windows_rejected, poses_set_aside }
    }
}

/// Sees what a controller learns, as it learns it.
pub trait SampleObserver {
    /// A window of motion from `start` on gave `samples`, which `belief` has not taken in yet.
    fn on_samples(&mut self, belief: &Belief, samples: &Samples, start: RobotTime);
}

/// Sees nothing.
impl SampleObserver for () {
    fn on_samples(&mut self, _: &Belief, _: &Samples, _: RobotTime) {}
}

impl Belief {
    /// The belief before any observation.
    pub fn new(method: Method, prior: &Prior, drift: bool) -> Self {
        let of_channel = match method {
            Method::Adaptive => ChannelBelief::of_unknown_spread,
            _ => ChannelBelief::new,
        };
        let channels = [
            of_channel(Channel::Forward, prior.forward),
            of_channel(Channel::Lateral, prior.lateral),
            of_channel(Channel::Turn, prior.turn),
            of_channel(Channel::Drift, prior.drift),
        ];
        Self {
            method,
            drift,
            channels,
            link: LinkBelief::default(),
            windows_rejected: 0,
            poses_set_aside: 0,
        }
    }

    /// Takes in the samples of a window from `start` to `end`.
    pub fn update(&mut self, samples: &Samples, start: RobotTime, end: RobotTime) {
        for (channel, sample) in self.channels.iter_mut().zip(samples) {
            if let Some(sample) = sample {
                channel.update(sample, start, end);
            }
        }
    }

    /// Samples of every channel.
    pub fn samples(&self) -> u64 {
        self.channels.iter().map(ChannelBelief::samples).sum()
    }

    /// What is believed of every channel, to come back to.
    pub fn channels(&self) -> [ChannelBelief; 4] {
        self.channels
    }

    /// Back to an earlier belief of every channel.
    pub fn restore(&mut self, channels: [ChannelBelief; 4]) {
        self.channels = channels;
    }

    /// One channel's belief.
    pub fn channel(&self, channel: Channel) -> &ChannelBelief {
        &self.channels[channel as usize]
    }

    /// What predictions assume, by the method.
    ///
    /// Learned means are clamped so that 1 + mu stays in \[0.3, 1.5\]: no prior, however evolved, reverses or
    /// explodes a prediction; means of lateral and drift stay within half a metre or radian per metre.
    pub fn model(&self) -> ErrorModel {
        self.unclamped().clamped()
    }

    /// The same for commands of a drive of this `scale` against that described, known to `sd`.
    pub fn model_of(&self, scale: &Scale, sd: &Scale) -> ErrorModel {
        self.unclamped().relative_to(scale, sd).clamped()
    }

    fn unclamped(&self) -> ErrorModel {
        let [forward, lateral, turn, drift] =
            Channel::ALL.map(|channel| self.channel_model(channel));
        let drift = if self.drift { drift } else { ChannelModel::PERFECT };
        ErrorModel { forward, lateral, turn, drift }
    }

    fn channel_model(&self, channel: Channel) -> ChannelModel {
        let belief = self.channel(channel);
        match self.method {
            Method::FixedNormal => fixed::channel(&fixed::FIXED_NORMAL, channel),
            Method::FixedBad => fixed::channel(&fixed::FIXED_BAD, channel),
            Method::Statistic => {
                belief.statistic().unwrap_or_else(|| fixed::channel(&fixed::FIXED_NORMAL, channel))
            }
            Method::Bayesian | Method::Adaptive => belief.model(),
        }
    }

    /// Every channel back to its prior.
    pub fn reset_channels(&mut self) {
        for channel in &mut self.channels {
            channel.reset();
        }
    }

    /// Back to the prior, the link included.
    pub fn reset(&mut self) {
        self.reset_channels();
        self.link = LinkBelief::default();
        self.windows_rejected = 0;
        self.poses_set_aside = 0;
    }

    /// How far the estimate of a channel has got, where the watch has samples set aside for `rejected`.
    ///
    /// With a prior, mean and variance both have to have got there ([`ChannelBelief::progress`]). Samples alone have no
    /// prior: their variance has n - 1 degrees of freedom.
    pub fn status(&self, channel: Channel, rejected: Option<Condition>) -> Status {
        let belief = self.channel(channel);
        let progress = match self.method {
            Method::FixedNormal | Method::FixedBad => return Status::Unestimated,
            Method::Statistic => progress(belief.samples() as f64 - 1.0, 0.0),
            Method::Bayesian | Method::Adaptive => belief.progress(),
        };
        match rejected {
            Some(reason) => Status::Rejected { reason },
            None => Status::of(progress),
        }
    }

    /// As it is shown, where the watch has samples set aside for `rejected`.
    pub fn estimates(&self, rejected: Option<Condition>) -> Estimates {
        let channels = Channel::ALL.map(|channel| {
            let used = self.drift || channel != Channel::Drift;
            let status = self.status(channel, rejected);
            self.channel(channel).estimate(&self.channel_model(channel), used, status)
        });
        Estimates {
            method: self.method,
            channels,
            link: self.link.estimate(),
            windows_rejected: self.windows_rejected,
            poses_set_aside: self.poses_set_aside,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(ratio: f64) -> Sample {
        Sample { ratio, weight: 1.2, motion: 0.0156, pose_variance: 0.0, other_variance: 0.0 }
    }

    fn learned(method: Method, ratios: &[f64]) -> Belief {
        let mut belief = Belief::new(method, &Prior::default(), false);
        for (i, &ratio) in ratios.iter().enumerate() {
            let at = RobotTime::new(i as f64);
            belief.update(&[Some(sample(ratio)), None, None, None], at, at + 0.12);
        }
        belief
    }

    #[test]
    fn fixed_methods_never_learn() {
        for (method, fixed) in
            [(Method::FixedNormal, fixed::FIXED_NORMAL), (Method::FixedBad, fixed::FIXED_BAD)]
        {
            let model = learned(method, &[0.5; 50]).model();
            assert_eq!((model.forward.mean, model.forward.variance), fixed[0]);
        }
    }

    #[test]
    fn statistic_uses_samples_only_from_two_on() {
        let one = learned(Method::Statistic, &[0.2]).model().forward;
        assert_eq!((one.mean, one.variance), fixed::FIXED_NORMAL[0]);
        let two = learned(Method::Statistic, &[0.2, 0.4]).model().forward;
        assert!((two.mean - 0.3).abs() < 1e-12);
        // sigma^2 of 100 ms from windows of weight 1.2: sum of 1.2 (x - mean)^2 over n - 1.
        assert!((two.variance - 1.2 * 0.02).abs() < 1e-12);
    }

    #[test]
    fn a_rotation_leaves_the_forward_channel_at_its_prior() {
        let mut belief = Belief::new(Method::Bayesian, &Prior::default(), false);
        belief.update(
            &[None, None, Some(sample(0.1)), None],
            RobotTime::ZERO,
            RobotTime::new(0.12),
        );
        assert_eq!(belief.channel(Channel::Forward).posterior(), Prior::default().forward);
        assert_ne!(belief.channel(Channel::Turn).posterior(), Prior::default().turn);
    }

    #[test]
    fn no_belief_reverses_a_prediction() {
        let model = learned(Method::Bayesian, &[-3.0; 100]).model();
        assert_eq!(model.forward.mean, -0.7);
    }

    #[test]
    fn a_fixed_model_is_not_estimated() {
        for method in [Method::FixedNormal, Method::FixedBad] {
            let belief = learned(method, &[0.5; 50]);
            assert_eq!(belief.status(Channel::Forward, None), Status::Unestimated);
            assert_eq!(
                belief.status(Channel::Forward, Some(Condition::Stuck)),
                Status::Unestimated
            );
        }
    }

    #[test]
    fn samples_alone_are_an_estimate_from_four_degrees_of_freedom_on() {
        let status = |n| {
            learned(Method::Statistic, &[0.2, 0.3, 0.1, 0.2, 0.3][..n])
                .status(Channel::Forward, None)
        };
        assert_eq!(status(0), Status::Estimating { fraction: 0.0 });
        assert_eq!(status(3), Status::Estimating { fraction: 0.5 });
        assert_eq!(status(5), Status::Estimated);
    }

    /// With samples free of noise the information is counted: each adds its weight to k and one to r.
    #[test]
    fn a_channel_is_estimated_once_its_samples_outweigh_the_prior() {
        let strong = |k, r| {
            let forward = crate::conjugate::NormalInverseChiSquared::new(0.0, k, r, 0.1);
            Prior { forward: forward.expect("valid"), ..Prior::default() }
        };
        let status = |prior: &Prior, n: usize| {
            let mut belief = Belief::new(Method::Bayesian, prior, false);
            for i in 0..n {
                let at = RobotTime::new(i as f64);
                belief.update(&[Some(sample(0.1)), None, None, None], at, at + 0.12);
            }
            [Channel::Forward, Channel::Turn].map(|channel| belief.status(channel, None).fraction())
        };
        // Samples of weight 1.2: the variance is what takes longer, 10 samples of 20, and at last the mean, 36 of 30 x 1.2.
        let [forward, turn] = status(&strong(1.0, 20.0), 10);
        assert!((forward.expect("estimating") - 0.5).abs() < 1e-12);
        assert_eq!(turn, Some(0.0), "no sample of a turn");
        let [forward, _] = status(&strong(36.0, 1.0), 15);
        assert!((forward.expect("estimating") - 0.5).abs() < 1e-12);
        assert_eq!(status(&strong(36.0, 1.0), 31), [Some(1.0), Some(0.0)]);
    }

    #[test]
    fn what_the_watch_sets_aside_is_rejected_with_its_reason() {
        let belief = learned(Method::Bayesian, &[0.2; 50]);
        let shown = belief.estimates(Some(Condition::Frozen));
        for channel in shown.channels {
            assert_eq!(channel.status, Status::Rejected { reason: Condition::Frozen });
        }
        assert_eq!(belief.estimates(None).channels[0].status, Status::Estimated);
    }

    #[test]
    fn a_reset_goes_back_to_the_prior() {
        let mut belief = learned(Method::Bayesian, &[0.2, 0.3]);
        belief.reset();
        assert_eq!(belief, Belief::new(Method::Bayesian, &Prior::default(), false));
    }
}
