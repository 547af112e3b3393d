//! The few special functions of the conjugate models: log gamma, incomplete beta, Beta and Student-t quantiles.

use std::f64::consts::PI;

/// Above this many degrees of freedom the Student-t quantile is extrapolated in 1/r: the continued fraction
/// takes O(sqrt(r)) steps, and the neglected term is below 1e-9 there.
const MANY_DEGREES: f64 = 1e5;

/// Lanczos coefficients for g = 7, n = 9 (Godfrey 2001): relative error of gamma below 1e-14.
const LANCZOS: [f64; 9] = [
    0.999_999_999_999_809_9,
    676.520_368_121_885_1,
    -1_259.139_216_722_402_8,
    771.323_428_777_653_1,
    -176.615_029_162_140_6,
    12.507_343_278_686_905,
    -0.138_571_095_265_720_12,
    9.984_369_578_019_572e-6,
    1.505_632_735_149_311_6e-7,
];

/// ln Gamma(x) for x > 0 (Lanczos approximation).
pub(super) fn ln_gamma(x: f64) -> f64 {
    if x < 0.5 {
        return ln_gamma(x + 1.0) - x.ln();
    }
    let (mut sum, mut x_plus) = (LANCZOS[0], x - 1.0);
    let base = x_plus + 7.5;
    for coefficient in &LANCZOS[1..] {
        x_plus += 1.0;
        sum += coefficient / x_plus;
    }
    0.5 * (2.0 * PI).ln() + (x - 0.5) * base.ln() - base + sum.ln()
}

/// ln Gamma(x + 1/2) - ln Gamma(x), without the cancellation of two large numbers.
///
/// Asymptotic from x = 12 on (DLMF 5.11.13), where the next term is below 1e-14; smaller x are brought there by
/// Gamma(x + 1/2)/Gamma(x) = x/(x + 1/2) Gamma(x + 3/2)/Gamma(x + 1).
pub(super) fn ln_gamma_half_step(x: f64) -> f64 {
    let (mut far, mut ratio) = (x, 1.0);
    while far < 12.0 {
        ratio *= far / (far + 0.5);
        far += 1.0;
    }
    let v = 1.0 / (far * far);
    let series = 1.0 / 192.0 + v * (-1.0 / 640.0 + v * (17.0 / 14_336.0 - v * (31.0 / 18_432.0)));
    0.5 * (far * ratio * ratio).ln() + (series * v - 0.125) / far
}

/// ln B(a, b) = ln Gamma(a) + ln Gamma(b) - ln Gamma(a + b).
pub(super) fn ln_beta(a: f64, b: f64) -> f64 {
    match (a == 0.5, b == 0.5) {
        (true, _) => 0.5 * PI.ln() - ln_gamma_half_step(b),
        (_, true) => 0.5 * PI.ln() - ln_gamma_half_step(a),
        _ => ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b),
    }
}

/// A Beta(a, b) distribution of a share, at one place given as the logit z = ln(x/(1-x)).
#[derive(Clone, Copy, Debug)]
struct AtLogit {
    /// P(X <= x), the regularised incomplete beta function I_x(a, b).
    lower: f64,
    /// P(X > x).
    upper: f64,
    /// dP/dz = x^a (1-x)^b / B(a, b).
    slope: f64,
}

/// Both tails of Beta(a, b) at logit `z`: continued fraction on the side where it converges fast (DLMF 8.17.22).
///
/// The logit keeps both tails exact where x or 1 - x would round to zero.
fn beta_at(a: f64, b: f64, z: f64) -> AtLogit {
    let (ln_x, ln_rest) = (-softplus(-z), -softplus(z));
    let slope = (a * ln_x + b * ln_rest - ln_beta(a, b)).exp();
    let x = ln_x.exp();
    if x < (a + 1.0) / (a + b + 2.0) {
        let lower = (slope * continued_fraction(a, b, x) / a).min(1.0);
        AtLogit { lower, upper: 1.0 - lower, slope }
    } else {
        let upper = (slope * continued_fraction(b, a, ln_rest.exp()) / b).min(1.0);
        AtLogit { lower: 1.0 - upper, upper, slope }
    }
}

/// ln(1 + e^z) without overflow.
fn softplus(z: f64) -> f64 {
    z.max(0.0) + (-z.abs()).exp().ln_1p()
}

/// The continued fraction of the incomplete beta function by Lentz's method, for x below (a+1)/(a+b+2).
fn continued_fraction(a: f64, b: f64, x: f64) -> f64 {
    /// More than O(sqrt(max(a, b))) steps of any shape below 1e8.
    const STEPS: u32 = 20_000;
    /// Keeps Lentz's method away from a division by zero.
    const TINY: f64 = 1e-300;
    let away = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / away(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    for step in 1..STEPS {
        let m = f64::from(step);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / away(1.0 + even * d);
        c = away(1.0 + even / c);
        fraction *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / away(1.0 + odd * d);
        c = away(1.0 + odd / c);
        fraction *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    fraction
}

/// The logit of the `p`-quantile of Beta(a, b), 0 < p < 1: Newton on the log of the smaller tail, kept in a bracket.
fn beta_quantile_logit(a: f64, b: f64, p: f64) -> f64 {
    let start = (a / b).ln();
    let (mut low, mut high, mut reach) = (start - 1.0, start + 1.0, 1.0);
    while beta_at(a, b, low).lower > p && low > -1e6 {
        reach *= 2.0;
        low -= reach;
    }
    reach = 1.0;
    while beta_at(a, b, high).lower < p && high < 1e6 {
        reach *= 2.0;
        high += reach;
    }
    let mut z = start.clamp(low, high);
    for _ in 0..200 {
        let at = beta_at(a, b, z);
        if at.lower < p {
            low = z;
        } else {
            high = z;
        }
        let step = if p < 0.5 {
            (p / at.lower).ln() * at.lower / at.slope
        } else {
            (at.upper / (1.0 - p)).ln() * at.upper / at.slope
        };
        let newton = z + step;
        let next = if newton > low && newton < high { newton } else { low + (high - low) / 2.0 };
        if (next - z).abs() <= 1e-14 * z.abs().max(1.0) {
            return next;
        }
        z = next;
    }
    z
}

/// The `p`-quantile of Beta(a, b), 0 < p < 1.
pub(super) fn beta_quantile(a: f64, b: f64, p: f64) -> f64 {
    (-softplus(-beta_quantile_logit(a, b, p))).exp()
}

/// The t for which a standard Student t with `degrees` degrees of freedom lies in -t..t with probability `level`.
///
/// t^2/(r + t^2) ~ Beta(1/2, r/2), thus t = sqrt(r) e^(z/2) with z the logit of that Beta's quantile. Beyond
/// `MANY_DEGREES` the leading term of Fisher's expansion in 1/r, (t^3 + t)/4r, continues it to the normal.
pub fn student_t_half_width(degrees: f64, level: f64) -> f64 {
    debug_assert!(level > 0.0 && level < 1.0, "level {level}");
    let r = degrees.min(MANY_DEGREES);
    let t = (0.5 * (r.ln() + beta_quantile_logit(0.5, r / 2.0, level))).exp();
    if degrees <= MANY_DEGREES {
        return t;
    }
    t - (t * t * t + t) / 4.0 * (1.0 / MANY_DEGREES - 1.0 / degrees)
}

/// P(T <= t) of a standard Student t with `degrees` degrees of freedom, and its density there.
///
/// t^2/(r + t^2) ~ Beta(1/2, r/2). Beyond `MANY_DEGREES` that many are taken, which differs by less than 1e-6.
pub(super) fn student_t_at(degrees: f64, t: f64) -> (f64, f64) {
    let r = degrees.min(MANY_DEGREES);
    let density =
        (ln_gamma_half_step(r / 2.0) - 0.5 * (PI * r).ln() - (r + 1.0) / 2.0 * (t * t / r).ln_1p())
            .exp();
    if t == 0.0 {
        return (0.5, density);
    }
    let outside = beta_at(0.5, r / 2.0, (t * t / r).ln()).upper / 2.0;
    (if t < 0.0 { outside } else { 1.0 - outside }, density)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rv::dist::{Beta, StudentsT};
    use rv::traits::{Cdf, HasDensity};

    fn close(a: f64, b: f64, tolerance: f64) -> bool {
        (a - b).abs() <= tolerance * b.abs().max(1.0)
    }

    #[test]
    fn ln_gamma_of_a_natural_number_is_the_log_of_a_product() {
        let mut ln_factorial = 0.0;
        for n in 1..170_u32 {
            assert!(close(ln_gamma(f64::from(n)), ln_factorial, 1e-13), "{n}");
            ln_factorial += f64::from(n).ln();
        }
        assert!(close(ln_gamma(0.5), PI.sqrt().ln(), 1e-14));
        assert!(close(ln_gamma(1e-9), 1e9_f64.ln(), 1e-9));
    }

    #[test]
    fn the_half_step_is_the_difference_of_two_log_gammas() {
        for x in [0.01, 0.5, 3.0, 199.9, 200.0, 200.1, 1234.5, 1e5] {
            let naive = ln_gamma(x + 0.5) - ln_gamma(x);
            assert!(close(ln_gamma_half_step(x), naive, 1e-9), "{x}");
        }
        // Twice the half step is a whole one: Gamma(x + 1) = x Gamma(x).
        for x in [0.3, 7.0, 199.8, 300.0, 1e6, 1e12] {
            let whole = ln_gamma_half_step(x) + ln_gamma_half_step(x + 0.5);
            assert!(close(whole, x.ln(), 1e-12), "{x}");
        }
    }

    #[test]
    fn the_student_t_quantile_agrees_with_the_printed_table() {
        // Two-sided 90 %, 95 % and 99 %, from the usual table; the last row is the normal's.
        for (degrees, t90, t95, t99) in [
            (1.0, 6.313_752, 12.706_205, 63.656_741),
            (2.0, 2.919_986, 4.302_653, 9.924_843),
            (5.0, 2.015_048, 2.570_582, 4.032_143),
            (10.0, 1.812_461, 2.228_139, 3.169_273),
            (30.0, 1.697_261, 2.042_272, 2.749_996),
            (1e12, 1.644_854, 1.959_964, 2.575_829),
        ] {
            for (level, t) in [(0.9, t90), (0.95, t95), (0.99, t99)] {
                let found = student_t_half_width(degrees, level);
                assert!((found - t).abs() < 1e-6 * t, "{degrees} {level}: {found} is not {t}");
            }
        }
    }

    #[test]
    fn the_extrapolated_quantile_joins_the_exact_one() {
        for level in [0.5, 0.9, 0.999] {
            let exact = {
                let r = 4e5_f64;
                (0.5 * (r.ln() + beta_quantile_logit(0.5, r / 2.0, level))).exp()
            };
            assert!(close(student_t_half_width(4e5, level), exact, 1e-8));
        }
    }

    proptest! {
        #[test]
        fn the_incomplete_beta_agrees_with_rv(a in 0.1..80.0f64, b in 0.1..80.0f64, x in 0.001..0.999f64) {
            let at = beta_at(a, b, (x / (1.0 - x)).ln());
            let oracle = Beta::new(a, b).unwrap().cdf(&x);
            prop_assert!((at.lower - oracle).abs() < 1e-10, "{} {}", at.lower, oracle);
            prop_assert!((at.lower + at.upper - 1.0).abs() < 1e-12);
        }

        #[test]
        fn the_beta_quantile_inverts_the_distribution(ln_a in -4.0..9.0f64, ln_b in -4.0..9.0f64, p in 0.001..0.999f64) {
            let (a, b) = (ln_a.exp(), ln_b.exp());
            let at = beta_at(a, b, beta_quantile_logit(a, b, p));
            prop_assert!((at.lower - p).abs() < 1e-9, "{} {}", at.lower, p);
        }

        #[test]
        fn the_student_t_holds_its_level_between_the_quantiles(r in 0.7..200.0f64, level in 0.05..0.99f64) {
            // Naive: the midpoint rule over rv's density.
            let (t, steps) = (student_t_half_width(r, level), 20_000);
            let density = StudentsT::new(r).unwrap();
            // Even steps in asinh(x) resolve both the bulk and the long tail.
            let (end, mut mass) = (t.asinh(), 0.0);
            for step in 0..steps {
                let y = end * (f64::from(step) + 0.5) / f64::from(steps);
                let ln_f: f64 = density.ln_f(&y.sinh());
                mass += 2.0 * ln_f.exp() * y.cosh() * end / f64::from(steps);
            }
            prop_assert!((mass - level).abs() < 1e-6, "{mass} {level}");
        }

        #[test]
        fn quantiles_of_any_shape_are_not_nan(ln_r in -14.0..30.0f64, level in 1e-6..0.999_999f64) {
            prop_assert!(student_t_half_width(ln_r.exp(), level) >= 0.0);
        }
    }
}
