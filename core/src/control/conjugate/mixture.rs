//! A mixture of beliefs: one of several conjugate priors holds, and samples say which.

use super::normal_inverse_chi_squared::NormalInverseChiSquared;
use super::special::{student_t_at, student_t_half_width};

/// Beliefs in a mixture at most.
pub const COMPONENTS: usize = 8;

/// Steps that a quantile takes at most; Newton's take some five.
const STEPS: usize = 60;

/// Part of the bracket it began in to which a quantile is known.
const EXACT: f64 = 1e-12;

/// One belief of a mixture, and how probable it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighted {
    /// Its probability; 0 where there is none.
    pub weight: f64,
    /// The belief.
    pub belief: NormalInverseChiSquared,
}

/// A mixture of at most [`COMPONENTS`] beliefs, whose weights add up to 1.
///
/// Given its prior, each component is updated by itself, and its weight by the density that the sample had under it:
/// w' = w p(x) / sum of w p(x). A mixture of conjugate priors so is conjugate itself (Diaconis & Ylvisaker 1985).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixture(pub [Weighted; COMPONENTS]);

/// What a mixture expects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// The expected mean.
    pub mu: f64,
    /// The expected variance of a sample about its mean, E\[sigma^2\]; none where one of the beliefs has none.
    pub variance: Option<f64>,
    /// The variance of the mean.
    pub mean_variance: Option<f64>,
    /// E\[1/sigma^2\].
    pub precision: f64,
}

impl Moments {
    /// The one belief that expects the same.
    ///
    /// Of one belief E\[sigma^2\] E\[1/sigma^2\] = r/(r - 2); so with q that product r = 2 q/(q - 1), s = (r - 2) E\[sigma^2\],
    /// k = E\[sigma^2\]/Var(mean).
    pub fn merged(&self) -> Option<NormalInverseChiSquared> {
        let (variance, of_mean) = (self.variance?, self.mean_variance?);
        let q = self.precision * variance;
        let r = 2.0 * q / (q - 1.0);
        NormalInverseChiSquared::new(self.mu, variance / of_mean, r, (r - 2.0) * variance).ok()
    }
}

/// A Student t distribution as a part of a mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudentT {
    /// Its probability.
    pub weight: f64,
    /// Its centre.
    pub centre: f64,
    /// Its scale.
    pub scale: f64,
    /// Its degrees of freedom.
    pub degrees: f64,
}

impl Mixture {
    fn each(&self) -> impl Iterator<Item = Weighted> {
        self.0.into_iter().filter(|it| it.weight > 0.0)
    }

    /// The one belief where all others are gone.
    fn only(&self) -> Option<NormalInverseChiSquared> {
        let mut beliefs = self.each();
        let first = beliefs.next()?;
        beliefs.next().is_none().then_some(first.belief)
    }

    /// What it expects: sums of w mu, w E\[sigma^2\], w (E\[sigma^2\]/k + (mu - E\[mu\])^2) and w E\[1/sigma^2\].
    pub fn moments(&self) -> Moments {
        let (mut mu, mut square, mut of_mean, mut precision) = (0.0, 0.0, 0.0, 0.0);
        let mut variance = Some(0.0);
        for Weighted { weight, belief } in self.each() {
            mu += weight * belief.mu();
            square += weight * belief.mu() * belief.mu();
            precision += weight * belief.r() / belief.s();
            let own = belief.expected_variance();
            variance = variance.and_then(|sum| Some(sum + weight * own?));
            of_mean += own.map_or(0.0, |own| weight * own / belief.k());
        }
        let mean_variance = variance.map(|_| of_mean + (square - mu * mu).max(0.0));
        Moments { mu, variance, mean_variance, precision }
    }

    /// The one belief that is most like it: with its expected mean, variance of the mean, E\[sigma^2\] and E\[1/sigma^2\].
    /// Where one of several has no variance, the heaviest.
    pub fn merged(&self) -> NormalInverseChiSquared {
        self.only().or_else(|| self.moments().merged()).unwrap_or_else(|| self.heaviest())
    }

    /// The most probable of its beliefs.
    fn heaviest(&self) -> NormalInverseChiSquared {
        let [first, rest @ ..] = &self.0;
        rest.iter().fold(first, |most, it| if it.weight > most.weight { it } else { most }).belief
    }

    /// The central intervals that hold the mean and the next sample with probability `level`, 0 < level < 1.
    pub fn intervals(&self, level: f64) -> [(f64, f64); 2] {
        if let Some(only) = self.only() {
            return only.intervals(level);
        }
        let scales: [fn(NormalInverseChiSquared) -> f64; 2] =
            [|it| it.s() / it.r() / it.k(), NormalInverseChiSquared::predictive_scale_squared];
        scales.map(|scale_squared| {
            let parts = self.0.map(|Weighted { weight, belief }| StudentT {
                weight,
                centre: belief.mu(),
                scale: scale_squared(belief).sqrt(),
                degrees: belief.r(),
            });
            let tail = (1.0 - level) / 2.0;
            (quantile(&parts, tail), quantile(&parts, 1.0 - tail))
        })
    }
}

/// The probability that a mixture of Student t distributions lies below `x`, and its density there.
pub fn mass_below(parts: &[StudentT], x: f64) -> (f64, f64) {
    parts.iter().filter(|part| part.weight > 0.0).fold((0.0, 0.0), |(mass, density), part| {
        let (below, at) = student_t_at(part.degrees, (x - part.centre) / part.scale);
        (mass + part.weight * below, density + part.weight * at / part.scale)
    })
}

/// The `p`-quantile of a mixture: Newton's steps in a bracket, which the quantiles of its parts are at first.
fn quantile(parts: &[StudentT], p: f64) -> f64 {
    let of_parts = parts.iter().filter(|part| part.weight > 0.0).map(|part| {
        let half = student_t_half_width(part.degrees, (1.0 - 2.0 * p).abs()) * part.scale;
        if p < 0.5 { part.centre - half } else { part.centre + half }
    });
    let (mut low, mut high) = of_parts
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let exact = EXACT * (high - low);
    let mut x = f64::midpoint(low, high);
    for _ in 0..STEPS {
        let (mass, density) = mass_below(parts, x);
        if mass < p {
            low = x;
        } else {
            high = x;
        }
        let newton = x + (p - mass) / density;
        let next = if newton > low && newton < high { newton } else { f64::midpoint(low, high) };
        if (next - x).abs() <= exact {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn known(mu: f64, k: f64, r: f64, s: f64) -> NormalInverseChiSquared {
        NormalInverseChiSquared::new(mu, k, r, s).expect("valid")
    }

    /// Three beliefs far apart, the places of the others empty.
    fn mixture() -> Mixture {
        let none = Weighted { weight: 0.0, belief: known(9.0, 1.0, 3.0, 1.0) };
        let mut all = [none; COMPONENTS];
        all[0] = Weighted { weight: 0.5, belief: known(0.0, 1.0, 4.0, 0.045) };
        all[3] = Weighted { weight: 0.3, belief: known(-0.05, 20.0, 9.0, 0.001) };
        all[5] = Weighted { weight: 0.2, belief: known(0.3, 4.0, 30.0, 0.5) };
        Mixture(all)
    }

    /// P(X <= x) of the next sample, the naive way: the midpoint rule over the predictive density.
    fn below(mixture: &Mixture, x: f64) -> f64 {
        let (low, steps) = (-60.0_f64, 400_000);
        let width = (x - low) / f64::from(steps);
        let density = |x| -> f64 {
            mixture.each().map(|it| it.weight * it.belief.ln_predictive(x).exp()).sum()
        };
        (0..steps).map(|step| density(low + (f64::from(step) + 0.5) * width) * width).sum()
    }

    #[test]
    fn the_predictive_interval_leaves_a_twentieth_on_either_side() {
        let [_, (low, high)] = mixture().intervals(0.9);
        assert!((below(&mixture(), low) - 0.05).abs() < 1e-5, "{}", below(&mixture(), low));
        assert!((below(&mixture(), high) - 0.95).abs() < 1e-5, "{}", below(&mixture(), high));
    }

    #[test]
    fn the_moments_are_sums_over_the_beliefs() {
        let Moments { mu, variance, mean_variance, precision } = mixture().moments();
        let of = |sum: fn(NormalInverseChiSquared) -> f64| -> f64 {
            mixture().each().map(|it| it.weight * sum(it.belief)).sum()
        };
        assert!((mu - of(NormalInverseChiSquared::mu)).abs() < 1e-12);
        let own = |it: NormalInverseChiSquared| it.s() / (it.r() - 2.0);
        assert!((variance.unwrap() - of(own)).abs() < 1e-12);
        let square = of(|it| it.s() / (it.r() - 2.0) / it.k() + it.mu() * it.mu());
        assert!((mean_variance.unwrap() - (square - mu * mu)).abs() < 1e-12);
        assert!((precision - of(|it| it.r() / it.s())).abs() < 1e-9);
    }

    #[test]
    fn the_merged_belief_expects_what_the_mixture_does() {
        let (moments, one) = (mixture().moments(), mixture().merged());
        let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        assert!(close(one.mu(), moments.mu));
        assert!(close(one.expected_variance().unwrap(), moments.variance.unwrap()));
        assert!(close(one.mean_variance().unwrap(), moments.mean_variance.unwrap()));
        assert!(close(one.r() / one.s(), moments.precision));
    }

    #[test]
    fn a_mixture_of_one_is_that_one() {
        let belief = known(0.1, 3.0, 7.0, 0.2);
        let none = Weighted { weight: 0.0, belief: known(9.0, 1.0, 3.0, 1.0) };
        let mut all = [none; COMPONENTS];
        all[4] = Weighted { weight: 1.0, belief };
        assert_eq!(Mixture(all).merged(), belief);
        assert_eq!(Mixture(all).intervals(0.9), belief.intervals(0.9));
    }

    /// Guards against: a variance made up where one of the beliefs has none.
    #[test]
    fn what_has_no_variance_is_not_given_one() {
        let mut all = mixture().0;
        all[0].belief = known(0.0, 0.01, 0.01, 1e-4);
        assert_eq!(Mixture(all).moments().variance, None);
        assert_eq!(Mixture(all).merged(), all[0].belief);
        let [_, (low, high)] = Mixture(all).intervals(0.9);
        assert!(low < high && low.is_finite() && high.is_finite());
    }

    proptest! {
        #[test]
        fn intervals_leave_the_same_on_either_side(w in 0.01..0.98f64, mu in -1.0..1.0f64, ln_s in -14.0..2.0f64, r in 0.5..300.0f64, level in 0.1..0.99f64) {
            let mut all = mixture().0.map(|it| Weighted { weight: 0.0, ..it });
            all[0] = Weighted { weight: w, belief: known(0.0, 1.0, 4.0, 0.045) };
            all[1] = Weighted { weight: 1.0 - w, belief: known(mu, 2.0, r, ln_s.exp()) };
            let [_, (low, high)] = Mixture(all).intervals(level);
            let parts = all.map(|it| StudentT {
                weight: it.weight,
                centre: it.belief.mu(),
                scale: it.belief.predictive_scale_squared().sqrt(),
                degrees: it.belief.r(),
            });
            let tail = (1.0 - level) / 2.0;
            prop_assert!((mass_below(&parts, low).0 - tail).abs() < 1e-8);
            prop_assert!((mass_below(&parts, high).0 - (1.0 - tail)).abs() < 1e-8);
        }
    }
}
