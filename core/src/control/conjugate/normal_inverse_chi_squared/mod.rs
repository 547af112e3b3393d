//! A normal quantity of unknown mean and variance.

use super::error::ConjugateError;
use super::special::{ln_gamma, ln_gamma_half_step, student_t_half_width};
use super::statistics::SampleStatistics;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

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
    pub(super) mu: f64,
    pub(super) k: f64,
    pub(super) r: f64,
    pub(super) s: f64,
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

    /// The scale^2 of the predictive Student t: (s/r)(1 + 1/k).
    pub(super) fn predictive_scale_squared(self) -> f64 {
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
mod tests;
