//! An event of unknown probability.

use super::error::ConjugateError;
use super::special::{beta_quantile, ln_beta};
use serde::{Deserialize, Serialize};

/// Belief about the probability of an event: Beta(alpha, beta).
///
/// `alpha` and `beta` count successes and failures, those that the prior claims to have seen included
/// (Gelman et al. 2013, section 2.4; thesis eq. 1-2 after Ramirez & Marshall 2017).
///
/// ```
/// use umwelt_core::conjugate::BetaBernoulli;
/// # fn main() -> Result<(), umwelt_core::conjugate::ConjugateError> {
/// let late = BetaBernoulli::new(1.0, 19.0)?.update(true).update(false);
/// assert_eq!(late.predictive(), 2.0 / 22.0);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct BetaBernoulli {
    alpha: f64,
    beta: f64,
}

/// What a serialised [`BetaBernoulli`] holds before it is checked.
#[derive(Deserialize)]
struct Unchecked {
    alpha: f64,
    beta: f64,
}

impl TryFrom<Unchecked> for BetaBernoulli {
    type Error = ConjugateError;

    fn try_from(raw: Unchecked) -> Result<Self, ConjugateError> {
        Self::new(raw.alpha, raw.beta)
    }
}

impl BetaBernoulli {
    /// The belief of having seen `alpha` successes and `beta` failures; both positive and finite, not whole numbers.
    pub fn new(alpha: f64, beta: f64) -> Result<Self, ConjugateError> {
        if !(alpha.is_finite() && alpha > 0.0) {
            return Err(ConjugateError::AlphaNotPositive(alpha));
        }
        if !(beta.is_finite() && beta > 0.0) {
            return Err(ConjugateError::BetaNotPositive(beta));
        }
        Ok(Self { alpha, beta })
    }

    /// Successes seen, the prior's included.
    pub fn alpha(self) -> f64 {
        self.alpha
    }

    /// Failures seen, the prior's included.
    pub fn beta(self) -> f64 {
        self.beta
    }

    /// The belief after one more event: alpha += 1 after a success, beta += 1 after a failure.
    pub fn update(self, success: bool) -> Self {
        if success {
            Self { alpha: self.alpha + 1.0, ..self }
        } else {
            Self { beta: self.beta + 1.0, ..self }
        }
    }

    /// The belief as if one event had not been seen: the inverse of [`update`](Self::update).
    ///
    /// An error where no event of this kind can have been seen.
    pub fn retract(self, success: bool) -> Result<Self, ConjugateError> {
        if success {
            Self::new(self.alpha - 1.0, self.beta)
        } else {
            Self::new(self.alpha, self.beta - 1.0)
        }
    }

    /// The probability that the next event is a success: alpha/(alpha + beta) (thesis eq. 1).
    pub fn predictive(self) -> f64 {
        self.alpha / (self.alpha + self.beta)
    }

    /// Natural log of the probability that the next event is `success`.
    pub fn ln_predictive(self, success: bool) -> f64 {
        (if success { self.alpha } else { self.beta } / (self.alpha + self.beta)).ln()
    }

    /// Natural log of the probability of one given sequence of `successes` and `failures` under this prior:
    /// ln B(alpha + successes, beta + failures) - ln B(alpha, beta).
    ///
    /// Of one sequence, whatever its order; no binomial coefficient counts the orders.
    pub fn ln_evidence(self, successes: u64, failures: u64) -> f64 {
        ln_beta(self.alpha + successes as f64, self.beta + failures as f64)
            - ln_beta(self.alpha, self.beta)
    }

    /// The equal-tailed interval that holds the probability with credibility `level`, 0 < level < 1.
    pub fn interval(self, level: f64) -> (f64, f64) {
        debug_assert!(level > 0.0 && level < 1.0, "level {level}");
        let tail = (1.0 - level) / 2.0;
        // The upper end is one minus the lower end of the failures: no digits are lost near one.
        (
            beta_quantile(self.alpha, self.beta, tail),
            1.0 - beta_quantile(self.beta, self.alpha, tail),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rv::data::DataOrSuffStat;
    use rv::dist::{Bernoulli, Beta};
    use rv::traits::{Cdf, ConjugatePrior};

    fn belief() -> impl Strategy<Value = BetaBernoulli> {
        (0.05..50.0f64, 0.05..50.0f64)
            .prop_map(|(alpha, beta)| BetaBernoulli::new(alpha, beta).unwrap())
    }

    fn after(prior: BetaBernoulli, events: &[bool]) -> BetaBernoulli {
        events.iter().fold(prior, |belief, &event| belief.update(event))
    }

    #[test]
    fn the_predictive_of_a_uniform_prior_is_laplaces_rule() {
        let belief = after(BetaBernoulli::new(1.0, 1.0).unwrap(), &[true, true, false]);
        assert_eq!(belief.predictive(), 3.0 / 5.0);
    }

    #[test]
    fn the_interval_of_a_uniform_prior_is_the_middle() {
        let (low, high) = BetaBernoulli::new(1.0, 1.0).unwrap().interval(0.9);
        assert!((low - 0.05).abs() < 1e-12 && (high - 0.95).abs() < 1e-12);
    }

    #[test]
    fn counts_outside_the_domain_are_named() {
        assert_eq!(BetaBernoulli::new(0.0, 1.0), Err(ConjugateError::AlphaNotPositive(0.0)));
        assert_eq!(BetaBernoulli::new(1.0, -1.0), Err(ConjugateError::BetaNotPositive(-1.0)));
        assert!(BetaBernoulli::new(1.0, f64::INFINITY).is_err());
        assert_eq!(
            BetaBernoulli::new(0.5, 1.0).unwrap().retract(true),
            Err(ConjugateError::AlphaNotPositive(-0.5))
        );
    }

    #[test]
    fn deserialising_goes_through_the_check() {
        let belief = BetaBernoulli::new(0.3, 4.0).unwrap();
        let text = serde_json::to_string(&belief).unwrap();
        assert_eq!(text, r#"{"alpha":0.3,"beta":4.0}"#);
        assert_eq!(serde_json::from_str::<BetaBernoulli>(&text).unwrap(), belief);
        assert!(serde_json::from_str::<BetaBernoulli>(r#"{"alpha":0.0,"beta":4.0}"#).is_err());
    }

    proptest! {
        #[test]
        fn retract_undoes_update(prior in belief(), success: bool) {
            let back = prior.update(success).retract(success).unwrap();
            prop_assert!((back.alpha - prior.alpha).abs() < 1e-12);
            prop_assert!((back.beta - prior.beta).abs() < 1e-12);
        }

        #[test]
        fn the_predictive_sums_to_one(prior in belief()) {
            let sum = prior.ln_predictive(true).exp() + prior.ln_predictive(false).exp();
            prop_assert!((sum - 1.0).abs() < 1e-12);
        }

        #[test]
        fn the_evidence_is_the_product_of_predictives(prior in belief(), events in prop::collection::vec(any::<bool>(), 0..40)) {
            let (mut belief, mut naive) = (prior, 0.0);
            for &event in &events {
                naive += belief.ln_predictive(event);
                belief = belief.update(event);
            }
            let successes = events.iter().filter(|&&event| event).count() as u64;
            let ln_evidence = prior.ln_evidence(successes, events.len() as u64 - successes);
            prop_assert!((ln_evidence - naive).abs() < 1e-9);
        }

        #[test]
        fn evidence_and_predictive_agree_with_rv(prior in belief(), events in prop::collection::vec(any::<bool>(), 1..20)) {
            let oracle = Beta::new(prior.alpha, prior.beta).unwrap();
            let data = || DataOrSuffStat::<bool, Bernoulli>::Data(&events);
            let successes = events.iter().filter(|&&event| event).count() as u64;
            let ln_evidence = prior.ln_evidence(successes, events.len() as u64 - successes);
            prop_assert!((ln_evidence - oracle.ln_m(data())).abs() < 1e-9);
            let ln_predictive = after(prior, &events).ln_predictive(true);
            prop_assert!((ln_predictive - oracle.ln_pp(&true, data())).abs() < 1e-9);
        }

        #[test]
        fn the_interval_holds_its_level_with_equal_tails(prior in belief(), level in 0.1..0.99f64) {
            let (low, high) = prior.interval(level);
            let oracle = Beta::new(prior.alpha, prior.beta).unwrap();
            prop_assert!(low < high && low >= 0.0 && high <= 1.0);
            // Close to 1 the place itself has too few digits for the distribution function to be compared.
            if low > 1e-12 && high < 1.0 - 1e-6 {
                prop_assert!((oracle.cdf(&low) - (1.0 - level) / 2.0).abs() < 1e-8);
                prop_assert!((oracle.cdf(&high) - (1.0 + level) / 2.0).abs() < 1e-8);
            }
        }
    }
}
