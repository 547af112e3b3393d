//! How far an estimate has got: whether it rests on samples yet, or still on what was believed before.

use crate::control::condition::Condition;

/// Least information, in samples, for which an estimate counts as one, however little the prior says: the standard
/// deviation of n samples is known to 1/sqrt(2 n) of itself, 35 % of four.
pub const LEAST_SAMPLES: f64 = 4.0;

/// How far an estimate has got.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// No sample can change it: it is a constant of a fixed model.
    Unestimated,
    /// The prior still dominates.
    Estimating {
        /// The part of the samples that it takes until the prior no longer dominates, at least 0 and below 1.
        fraction: f64,
    },
    /// The samples say at least as much as the prior.
    Estimated,
    /// Samples are set aside: the watch holds the robot at rest because its motion is not what was commanded.
    Rejected {
        /// What the watch found.
        reason: Condition,
    },
}

impl Status {
    /// That of an estimate which has the part `progress` of the samples that it takes; see [`progress`].
    pub fn of(progress: f64) -> Self {
        if progress >= 1.0 { Self::Estimated } else { Self::Estimating { fraction: progress } }
    }

    /// The part of the samples that it takes until the prior no longer dominates: 1 once it does not; none where that is
    /// not asked.
    pub fn fraction(self) -> Option<f64> {
        match self {
            Self::Estimating { fraction } => Some(fraction),
            Self::Estimated => Some(1.0),
            Self::Unestimated | Self::Rejected { .. } => None,
        }
    }

    /// The name used on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unestimated => "unestimated",
            Self::Estimating { .. } => "estimating",
            Self::Estimated => "estimated",
            Self::Rejected { .. } => "rejected",
        }
    }
}

/// How far samples worth `gained` have brought an estimate whose prior is worth `prior` samples: from 0 to 1.
///
/// In a conjugate posterior samples have the weight w = gained/(gained + prior), the prior has 1 - w. The prior no longer
/// dominates from w = 1/2 on, which is gained = prior. So progress = min(1, gained/max(prior, [`LEAST_SAMPLES`])): it grows
/// evenly with the samples. An outlier that widens a belief takes some of what was gained back.
///
/// ```
/// use umwelt_core::identification::progress;
/// assert_eq!(progress(5.0, 20.0), 0.25);
/// assert_eq!(progress(20.0, 20.0), 1.0);
/// assert_eq!(progress(1.0, 0.01), 0.25);
/// ```
pub fn progress(gained: f64, prior: f64) -> f64 {
    (gained / prior.max(LEAST_SAMPLES)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The definition: an estimate is complete where the samples' weight is a half or more.
        #[test]
        fn the_prior_no_longer_dominates_from_half_the_weight_on(gained in 0.0..1e6f64, prior in LEAST_SAMPLES..1e6f64) {
            let weight = gained / (gained + prior);
            let status = Status::of(progress(gained, prior));
            prop_assert_eq!(status == Status::Estimated, gained >= prior);
            prop_assert!((weight - 0.5).abs() < 1e-12 || (status == Status::Estimated) == (weight >= 0.5));
            let fraction = status.fraction().unwrap();
            prop_assert!((0.0..=1.0).contains(&fraction));
            prop_assert!((fraction - (weight / (1.0 - weight)).min(1.0)).abs() < 1e-9);
        }

        #[test]
        fn more_samples_never_bring_it_back(gained in 0.0..1e3f64, more in 0.0..1e3f64, prior in 0.0..1e3f64) {
            prop_assert!(progress(gained + more, prior) >= progress(gained, prior));
        }
    }

    #[test]
    fn nothing_gained_or_less_is_none_of_it() {
        assert_eq!(Status::of(progress(0.0, 0.0)), Status::Estimating { fraction: 0.0 });
        assert_eq!(progress(-1.0, 4.0), 0.0);
    }

    #[test]
    fn a_status_without_a_fraction_has_none() {
        assert_eq!(Status::Unestimated.fraction(), None);
        assert_eq!(Status::Rejected { reason: Condition::Stuck }.fraction(), None);
        assert_eq!(Status::Estimated.fraction(), Some(1.0));
    }
}
