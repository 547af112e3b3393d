//! Conjugate beliefs: a normal quantity of unknown mean and variance, and an event of unknown probability.
//!
//! Beliefs are values: each update returns the next belief. All logs are natural; nothing here allocates.

mod beta_bernoulli;
mod noisy;
mod special;
mod statistics;

pub use beta_bernoulli::BetaBernoulli;
pub(crate) use special::student_t_half_width;
pub use statistics::SampleStatistics;

use serde::{Deserialize, Serialize};
use special::{ln_gamma, ln_gamma_half_step};
use std::f64::consts::PI;

/// A parameter outside the domain of its distribution.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ConjugateError {
    /// The mean is infinite or not a number.
    #[error("mu must be finite, not {0}")]
    MuNotFinite(f64),
    /// The weight of the mean is not positive and finite.
    #[error("k must be positive and finite, not {0}")]
    KNotPositive(f64),
    /// The degrees of freedom are not positive and finite.
    #[error("r must be positive and finite, not {0}")]
    RNotPositive(f64),
    /// The sum of squares is not positive and finite.
    #[error("s must be positive and finite, not {0}")]
    SNotPositive(f64),
    /// The number of successes is not positive and finite.
    #[error("alpha must be positive and finite, not {0}")]
    AlphaNotPositive(f64),
    /// The number of failures is not positive and finite.
    #[error("beta must be positive and finite, not {0}")]
    BetaNotPositive(f64),
}

/// Belief about a normal quantity of unknown mean and variance: normal, inverse chi-squared.
///
/// sigma^2 ~ Inv-chi^2 with `r` degrees of freedom and sum of squares `s` (s/sigma^2 ~ chi^2 with r degrees), and
/// mean | sigma^2 ~ N(mu, sigma^2/k): thesis eq. 32-34, Gelman et al. 2013, section 3.3, with s = nu_0 sigma_0^2.
/// `k` counts the samples that stand behind the mean, `r` those behind the variance.
///
/// ```
/// use umwelt_core::conjugate::NormalInverseChiSquared;
/// # fn main() -> Result<(), umwelt_core::conjugate::ConjugateError> {
/// let prior = NormalInverseChiSquared::new(0.0, 1.0, 2.0, 2.0)?;
/// let posterior = prior.update(1.0).update(2.0).update(4.0);
/// assert_eq!((posterior.mu(), posterior.k(), posterior.r()), (1.75, 4.0, 5.0));
/// assert!((posterior.s() / posterior.r() - 2.15).abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct NormalInverseChiSquared {
    mu: f64,
    k: f64,
    r: f64,
    s: f64,
}

/// What a serialised [`NormalInverseChiSquared`] holds before it is checked.
#[derive(Deserialize)]
struct Unchecked {
    mu: f64,
    k: f64,
    r: f64,
    s: f64,
}

impl TryFrom<Unchecked> for NormalInverseChiSquared {
    type Error = ConjugateError;

    fn try_from(raw: Unchecked) -> Result<Self, ConjugateError> {
        Self::new(raw.mu, raw.k, raw.r, raw.s)
    }
}

impl NormalInverseChiSquared {
    /// The belief with these parameters: all finite; `k`, `r` and `s` positive.
    pub fn new(mu: f64, k: f64, r: f64, s: f64) -> Result<Self, ConjugateError> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        if !mu.is_finite() {
            return Err(ConjugateError::MuNotFinite(mu));
        }
        if !positive(k) {
            return Err(ConjugateError::KNotPositive(k));
        }
        if !positive(r) {
            return Err(ConjugateError::RNotPositive(r));
        }
        if !positive(s) {
            return Err(ConjugateError::SNotPositive(s));
        }
        Ok(Self { mu, k, r, s })
    }

    /// The expected mean.
    pub fn mu(self) -> f64 {
        self.mu
    }

    /// The number of samples that stand behind the mean.
    pub fn k(self) -> f64 {
        self.k
    }

    /// The degrees of freedom of the variance.
    pub fn r(self) -> f64 {
        self.r
    }

    /// The sum of squares of the variance: s = r times its scale.
    pub fn s(self) -> f64 {
        self.s
    }

    /// The belief after one sample `x` ~ N(mean, sigma^2): [`update_weighted`](Self::update_weighted) with weight 1.
    ///
    /// Thesis eq. 35-38, corrected: (k_0+n)/n of eq. 35 is n/(k_0+n), (k_0+n)/(k_0 n) of eq. 38 is k_0 n/(k_0+n).
    pub fn update(self, x: f64) -> Self {
        self.update_weighted(x, 1.0)
    }

    /// The belief after one sample `x` ~ N(mean, sigma^2/m) of weight `m` > 0.
    ///
    /// k += m, r += 1, s += (k m/(k+m)) (x - mu)^2, mu = (k mu + m x)/(k+m), right sides before the update.
    ///
    /// ```
    /// use umwelt_core::conjugate::NormalInverseChiSquared;
    /// # fn main() -> Result<(), umwelt_core::conjugate::ConjugateError> {
    /// let next = NormalInverseChiSquared::new(0.0, 2.0, 3.0, 1.0)?.update_weighted(1.0, 0.5);
    /// assert_eq!((next.mu(), next.k(), next.r(), next.s()), (0.2, 2.5, 4.0, 1.4));
    /// # Ok(())
    /// # }
    /// ```
    pub fn update_weighted(self, x: f64, m: f64) -> Self {
        debug_assert!(x.is_finite() && m.is_finite() && m > 0.0, "x {x}, m {m}");
        let (k, deviation) = (self.k + m, x - self.mu);
        Self {
            mu: self.mu + m / k * deviation,
            k,
            r: self.r + 1.0,
            s: self.s + self.k * (m / k) * deviation * deviation,
        }
    }

    /// The belief after many samples at once: the same as one [`update_weighted`](Self::update_weighted) after another.
    ///
    /// With W = sum m: k += W, r += n, s += squares + (k W/(k+W)) (mean - mu)^2, mu = (k mu + W mean)/(k+W)
    /// (thesis eq. 35-38, corrected).
    pub fn update_all(self, samples: &SampleStatistics) -> Self {
        let SampleStatistics { samples, weight, mean, squares } = *samples;
        let (k, deviation) = (self.k + weight, mean - self.mu);
        Self {
            mu: self.mu + weight / k * deviation,
            k,
            r: self.r + samples as f64,
            s: self.s + squares + self.k * (weight / k) * deviation * deviation,
        }
    }

    /// The belief as if the sample `x` had not been seen: the inverse of [`update`](Self::update).
    ///
    /// An error where the result leaves the domain: this sample cannot have been seen.
    pub fn retract(self, x: f64) -> Result<Self, ConjugateError> {
        self.retract_weighted(x, 1.0)
    }

    /// The inverse of [`update_weighted`](Self::update_weighted).
    ///
    /// k -= m, r -= 1, mu = (k mu - m x)/(k-m), s -= ((k-m) m/k) (x - mu_before)^2 with k the one before this call.
    /// An error where the result leaves the domain.
    pub fn retract_weighted(self, x: f64, m: f64) -> Result<Self, ConjugateError> {
        debug_assert!(x.is_finite() && m.is_finite() && m > 0.0, "x {x}, m {m}");
        let k = self.k - m;
        let mu = self.mu - m / k * (x - self.mu);
        let deviation = x - mu;
        let s = self.s - k * (m / self.k) * deviation * deviation;
        // k is checked first: where it is zero mu is not a number.
        if k <= 0.0 {
            return Err(ConjugateError::KNotPositive(k));
        }
        Self::new(mu, k, self.r - 1.0, s)
    }

    /// The belief after one sample `x` ~ N(mean, sigma^2/m + `noise_variance`): what was measured, noise included.
    ///
    /// The noise is discounted by the likelihood, never by subtracting a variance: a sample that is mostly noise
    /// moves the belief little, and no variance comes out negative. Not conjugate, so the exact posterior is
    /// projected back: assumed-density filtering (Opper 1998), by quadrature over ln sigma^2.
    /// The result has the exact posterior's expected mean, its first two moments of w = 1/sigma^2, E\[w\] = r/s and
    /// E\[w^2\] = r (r+2)/s^2, and its expected precision of the mean given sigma^2, k E\[w\]. r may fall, not below 3
    /// where it was above, and rises by at most 1. With no noise, or so little that it does not matter (m R below
    /// 1e-9 of s/r), it is [`update_weighted`](Self::update_weighted) exactly.
    ///
    /// Limit: the order of samples matters a little, and where nearly all is noise (R ten times sigma^2) under a
    /// prior ten times too high the variance is still 25 % above the exact posterior's after 20 000 samples.
    ///
    /// ```
    /// use umwelt_core::conjugate::NormalInverseChiSquared;
    /// # fn main() -> Result<(), umwelt_core::conjugate::ConjugateError> {
    /// let prior = NormalInverseChiSquared::new(0.0, 1.0, 4.0, 0.04)?;
    /// let (clean, noisy) = (prior.update(0.5), prior.update_noisy(0.5, 1.0, 0.25));
    /// assert!(noisy.mu() < clean.mu() && noisy.s() < clean.s());
    /// assert_eq!(prior.update_noisy(0.5, 1.0, 0.0), clean);
    /// # Ok(())
    /// # }
    /// ```
    pub fn update_noisy(self, x: f64, m: f64, noise_variance: f64) -> Self {
        debug_assert!(x.is_finite() && m.is_finite() && m > 0.0, "x {x}, m {m}");
        debug_assert!(noise_variance.is_finite() && noise_variance >= 0.0, "R {noise_variance}");
        if m * noise_variance < noisy::NEGLIGIBLE * self.s / self.r {
            return self.update_weighted(x, m);
        }
        noisy::update(self, x, m, noise_variance)
    }

    /// The scale^2 of the predictive Student t: (s/r)(1 + 1/k).
    fn predictive_scale_squared(self) -> f64 {
        self.s / self.r * (1.0 + 1.0 / self.k)
    }

    /// Natural log of the density of the next sample at `x`.
    ///
    /// Student t with r degrees of freedom, centre mu, scale^2 = (s/r)(1 + 1/k) (Gelman et al. 2013, section 3.3).
    pub fn ln_predictive(self, x: f64) -> f64 {
        let spread = self.r * self.predictive_scale_squared();
        let deviation = x - self.mu;
        ln_gamma_half_step(self.r / 2.0)
            - 0.5 * (PI * spread).ln()
            - (self.r + 1.0) / 2.0 * (deviation * deviation / spread).ln_1p()
    }

    /// The standard deviation of the next sample: sqrt((s/(r-2))(1 + 1/k)). It exists for r > 2 only.
    pub fn predictive_sd(self) -> Option<f64> {
        self.expected_variance().map(|variance| (variance * (1.0 + 1.0 / self.k)).sqrt())
    }

    /// The central interval that holds the next sample with probability `level`, 0 < level < 1.
    pub fn predictive_interval(self, level: f64) -> (f64, f64) {
        self.intervals(level)[1]
    }

    /// The central interval that holds the mean with credibility `level`, 0 < level < 1.
    ///
    /// The mean is Student t with r degrees of freedom, centre mu, scale^2 = s/(r k).
    pub fn mean_interval(self, level: f64) -> (f64, f64) {
        self.intervals(level)[0]
    }

    /// Both intervals at once, of the mean and of the next sample: they share the quantile, which is what costs.
    pub fn intervals(self, level: f64) -> [(f64, f64); 2] {
        let quantile = student_t_half_width(self.r, level);
        [self.s / self.r / self.k, self.predictive_scale_squared()].map(|scale_squared| {
            let half = quantile * scale_squared.sqrt();
            (self.mu - half, self.mu + half)
        })
    }

    /// Natural log of the density of the samples that lead from this prior to `posterior` by [`update`](Self::update).
    ///
    /// ln Gamma(r_n/2) - ln Gamma(r/2) + ln(k/k_n)/2 + (r/2) ln s - (r_n/2) ln s_n - (n/2) ln pi with n = r_n - r
    /// (Gelman et al. 2013, section 3.3). Of samples of weight 1 without noise only.
    pub fn ln_evidence(self, posterior: Self) -> f64 {
        let n = posterior.r - self.r;
        ln_gamma(posterior.r / 2.0) - ln_gamma(self.r / 2.0) + 0.5 * (self.k / posterior.k).ln()
            - self.r / 2.0 * (posterior.s / self.s).ln()
            - n / 2.0 * (PI * posterior.s).ln()
    }

    /// The expected variance of a sample about its mean: E\[sigma^2\] = s/(r-2). It exists for r > 2 only.
    pub fn expected_variance(self) -> Option<f64> {
        (self.r > 2.0).then(|| self.s / (self.r - 2.0))
    }

    /// The variance of the mean itself: E\[sigma^2\]/k. It exists for r > 2 only.
    pub fn mean_variance(self) -> Option<f64> {
        self.expected_variance().map(|variance| variance / self.k)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_distr::{ChiSquared, Distribution, StandardNormal};
    use rand_pcg::Pcg64Mcg;
    use rv::data::DataOrSuffStat;
    use rv::dist::{Gaussian, NormalInvChiSquared};
    use rv::traits::ConjugatePrior;

    fn golden_prior() -> NormalInverseChiSquared {
        NormalInverseChiSquared::new(0.0, 1.0, 2.0, 2.0).unwrap()
    }

    fn after(prior: NormalInverseChiSquared, data: &[f64]) -> NormalInverseChiSquared {
        data.iter().fold(prior, |belief, &x| belief.update(x))
    }

    fn oracle(belief: NormalInverseChiSquared) -> NormalInvChiSquared {
        NormalInvChiSquared::new(belief.mu, belief.k, belief.r, belief.s / belief.r).unwrap()
    }

    fn belief() -> impl Strategy<Value = NormalInverseChiSquared> {
        (-2.0..2.0f64, 0.1..20.0f64, 0.5..30.0f64, 0.01..20.0f64)
            .prop_map(|(mu, k, r, s)| NormalInverseChiSquared::new(mu, k, r, s).unwrap())
    }

    fn data() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(-5.0..5.0f64, 1..30)
    }

    fn same(a: NormalInverseChiSquared, b: NormalInverseChiSquared) -> bool {
        [(a.mu, b.mu), (a.k, b.k), (a.r, b.r), (a.s, b.s)]
            .into_iter()
            .all(|(a, b)| (a - b).abs() <= 1e-8 * b.abs().max(1.0))
    }

    #[test]
    fn the_golden_numbers() {
        let posterior = after(golden_prior(), &[1.0, 2.0, 4.0]);
        assert!((posterior.mu - 1.75).abs() < 1e-14);
        assert_eq!((posterior.k, posterior.r), (4.0, 5.0));
        assert!((posterior.s / posterior.r - 2.15).abs() < 1e-14);
        assert!((posterior.ln_predictive(0.7) - -1.699_487_784_434_09).abs() < 1e-13);
        assert!((golden_prior().ln_evidence(posterior) - -7.369_676_344_735_36).abs() < 1e-13);
    }

    #[test]
    fn moments_are_those_of_the_formulas_and_exist_above_two_degrees_only() {
        let belief = NormalInverseChiSquared::new(0.0, 4.0, 5.0, 6.0).unwrap();
        assert_eq!(belief.expected_variance(), Some(2.0));
        assert_eq!(belief.mean_variance(), Some(0.5));
        assert_eq!(belief.predictive_sd(), Some(2.5_f64.sqrt()));
        assert_eq!(golden_prior().expected_variance(), None);
        assert_eq!(golden_prior().mean_variance(), None);
        assert_eq!(golden_prior().predictive_sd(), None);
    }

    #[test]
    fn parameters_outside_the_domain_are_named() {
        let new = NormalInverseChiSquared::new;
        assert_eq!(
            new(f64::INFINITY, 1.0, 1.0, 1.0),
            Err(ConjugateError::MuNotFinite(f64::INFINITY))
        );
        assert_eq!(new(0.0, 0.0, 1.0, 1.0), Err(ConjugateError::KNotPositive(0.0)));
        assert_eq!(new(0.0, 1.0, -1.0, 1.0), Err(ConjugateError::RNotPositive(-1.0)));
        assert_eq!(new(0.0, 1.0, 1.0, 0.0), Err(ConjugateError::SNotPositive(0.0)));
        assert!(new(0.0, f64::NAN, 1.0, 1.0).is_err());
        let message = ConjugateError::KNotPositive(-2.5).to_string();
        assert_eq!(message, "k must be positive and finite, not -2.5");
    }

    #[test]
    fn a_sample_that_cannot_have_been_seen_is_not_retracted() {
        let belief = NormalInverseChiSquared::new(0.0, 3.0, 4.0, 1.0).unwrap();
        assert!(matches!(belief.retract(10.0), Err(ConjugateError::SNotPositive(_))));
        let belief = NormalInverseChiSquared::new(0.0, 1.0, 4.0, 1.0).unwrap();
        assert_eq!(belief.retract(0.0), Err(ConjugateError::KNotPositive(0.0)));
        let belief = NormalInverseChiSquared::new(0.0, 3.0, 1.0, 1.0).unwrap();
        assert_eq!(belief.retract(0.0), Err(ConjugateError::RNotPositive(0.0)));
    }

    #[test]
    fn deserialising_goes_through_the_check() {
        let text = serde_json::to_string(&golden_prior()).unwrap();
        assert_eq!(text, r#"{"mu":0.0,"k":1.0,"r":2.0,"s":2.0}"#);
        let back: NormalInverseChiSquared = serde_json::from_str(&text).unwrap();
        assert_eq!(back, golden_prior());
        let error = serde_json::from_str::<NormalInverseChiSquared>(
            r#"{"mu":0.0,"k":1.0,"r":2.0,"s":-2.0}"#,
        );
        assert!(error.unwrap_err().to_string().contains("s must be positive"));
    }

    proptest! {
        #[test]
        fn the_posterior_is_that_of_the_sufficient_statistics(prior in belief(), data in data()) {
            // Thesis eq. 35-38, corrected: n samples at once.
            let n = data.len() as f64;
            let mean = data.iter().sum::<f64>() / n;
            let squares: f64 = data.iter().map(|x| (x - mean) * (x - mean)).sum();
            let k = prior.k + n;
            let at_once = NormalInverseChiSquared {
                mu: (prior.k * prior.mu + n * mean) / k,
                k,
                r: prior.r + n,
                s: prior.s + squares + prior.k * n / k * (prior.mu - mean) * (prior.mu - mean),
            };
            prop_assert!(same(after(prior, &data), at_once));
        }

        #[test]
        fn the_posterior_agrees_with_rv(prior in belief(), data in data()) {
            let stat = DataOrSuffStat::<f64, Gaussian>::Data(&data);
            let expected = oracle(prior).posterior(stat);
            let (mu, k, r, scale) = expected.params();
            let expected = NormalInverseChiSquared { mu, k, r, s: r * scale };
            prop_assert!(same(after(prior, &data), expected));
        }

        #[test]
        fn predictive_and_evidence_agree_with_rv(prior in belief(), data in data(), x in -9.0..9.0f64) {
            let stat = || DataOrSuffStat::<f64, Gaussian>::Data(&data);
            let posterior = after(prior, &data);
            let ln_predictive = oracle(prior).ln_pp(&x, stat());
            prop_assert!((posterior.ln_predictive(x) - ln_predictive).abs() < 1e-8);
            let ln_evidence = oracle(prior).ln_m(stat());
            prop_assert!((prior.ln_evidence(posterior) - ln_evidence).abs() < 1e-8);
        }

        #[test]
        fn many_samples_at_once_are_one_after_another(prior in belief(), data in data(), m in 0.1..3.0_f64) {
            let mut all = SampleStatistics::default();
            data.iter().for_each(|&x| all.add(x, m));
            let one_by_one = data.iter().fold(prior, |it, &x| it.update_weighted(x, m));
            let at_once = prior.update_all(&all);
            for (one, other) in [
                (one_by_one.mu(), at_once.mu()),
                (one_by_one.k(), at_once.k()),
                (one_by_one.r(), at_once.r()),
                (one_by_one.s(), at_once.s()),
            ] {
                prop_assert!((one - other).abs() <= 1e-9 * (1.0 + one.abs()), "{one} {other}");
            }
        }

        #[test]
        fn the_order_of_updates_does_not_matter(prior in belief(), data in data()) {
            let reversed: Vec<f64> = data.iter().rev().copied().collect();
            prop_assert!(same(after(prior, &data), after(prior, &reversed)));
        }

        #[test]
        fn the_weight_of_one_is_the_plain_update(prior in belief(), x in -5.0..5.0f64) {
            prop_assert_eq!(prior.update_weighted(x, 1.0), prior.update(x));
        }

        #[test]
        fn two_half_weights_move_the_mean_like_one_sample(prior in belief(), x in -5.0..5.0f64) {
            let (halves, whole) = (prior.update_weighted(x, 0.5).update_weighted(x, 0.5), prior.update(x));
            let expected = NormalInverseChiSquared { r: whole.r + 1.0, ..whole };
            prop_assert!(same(halves, expected));
        }

        #[test]
        fn retract_undoes_update(prior in belief(), x in -5.0..5.0f64, m in 0.05..2.0f64) {
            prop_assert!(same(prior.update(x).retract(x).unwrap(), prior));
            prop_assert!(same(prior.update_weighted(x, m).retract_weighted(x, m).unwrap(), prior));
        }

        #[test]
        fn the_predictive_integrates_to_one(prior in belief()) {
            // Even steps in asinh of the standardised place: the tails of half a degree of freedom are long.
            let (scale, end, steps) = (prior.predictive_scale_squared().sqrt(), 60.0, 8000);
            let width = 2.0 * end / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|step| -end + width * (f64::from(step) + 0.5))
                .map(|y| (prior.ln_predictive(prior.mu + scale * y.sinh())).exp() * scale * y.cosh() * width)
                .sum();
            prop_assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        }

        #[test]
        fn the_evidence_is_the_product_of_predictives(prior in belief(), data in data()) {
            let (mut belief, mut naive) = (prior, 0.0);
            for &x in &data {
                naive += belief.ln_predictive(x);
                belief = belief.update(x);
            }
            prop_assert!((prior.ln_evidence(belief) - naive).abs() < 1e-8);
        }

        #[test]
        fn intervals_hold_their_level(prior in belief(), level in 0.1..0.99f64) {
            let (low, high) = prior.predictive_interval(level);
            // Naive: the midpoint rule over the density, even steps in asinh.
            let scale = prior.predictive_scale_squared().sqrt();
            let (end, steps) = (((high - prior.mu) / scale).asinh(), 20_000);
            let width = 2.0 * end / f64::from(steps);
            let mass: f64 = (0..steps)
                .map(|step| -end + width * (f64::from(step) + 0.5))
                .map(|y| (prior.ln_predictive(prior.mu + scale * y.sinh())).exp() * scale * y.cosh() * width)
                .sum();
            prop_assert!((mass - level).abs() < 1e-5, "{mass} {level}");
            prop_assert!((low + high - 2.0 * prior.mu).abs() < 1e-6 * (high - low));
            // The mean's interval is the predictive's, narrower by sqrt(k + 1).
            let (from, to) = prior.mean_interval(level);
            prop_assert!(((to - from) * (prior.k + 1.0).sqrt() / (high - low) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn moments_are_those_of_draws() {
        // 200 000 draws at r = 12: standard errors are about 0.2 % of E[sigma^2] and 0.4 % of Var(mean).
        let belief = NormalInverseChiSquared::new(0.5, 3.0, 12.0, 6.0).unwrap();
        let (mut rng, chi_squared) = (Pcg64Mcg::seed_from_u64(3), ChiSquared::new(12.0).unwrap());
        let (mut variances, mut squares, draws) = (0.0, 0.0, 200_000);
        for _ in 0..draws {
            let variance = belief.s / chi_squared.sample(&mut rng);
            let z: f64 = StandardNormal.sample(&mut rng);
            variances += variance;
            squares += z * z * variance / belief.k;
        }
        let (expected, of_mean) = (variances / f64::from(draws), squares / f64::from(draws));
        assert!((expected / belief.expected_variance().unwrap() - 1.0).abs() < 0.01);
        assert!((of_mean / belief.mean_variance().unwrap() - 1.0).abs() < 0.02);
    }
}
