//! Sine, cosine, exponential and logarithm for the inner loops of simulation and prediction.
//!
//! Those of the C library are calls that cannot be inlined, and their last bit depends on the processor. These are a
//! few inlined multiplications each, the same on every machine, with errors below 2^-52 relative (absolute for sine and
//! cosine, whose arguments here are angles of a few turns). Kernels: the minimax polynomials of fdlibm (Sun 1993), in
//! pairs rather than by Horner's rule: what counts is how long the next step waits.

#[cfg(any(feature = "controller", test))]
use core::f64::consts::FRAC_1_SQRT_2;
use core::f64::consts::{FRAC_2_PI, FRAC_PI_4, LOG2_E};

/// 1.5 x 2^52: added to a number of moderate size, it leaves the nearest whole number in the last bits of the sum.
const SHIFT: f64 = 6_755_399_441_055_744.0;

/// 2^52: the last bits of a float between it and twice as much are a whole number.
#[cfg(any(feature = "controller", test))]
const TWO_TO_52: f64 = 4_503_599_627_370_496.0;

/// pi/2 as a number of few digits, whose multiples are exact, and the rest.
const HALF_PI: (f64, f64) = (1.570_796_326_734_125_6, 6.077_100_506_506_192e-11);

/// ln 2, likewise.
const LN_2: (f64, f64) = (0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10);

/// Arguments of [`exp`] are kept within -+ this: e^700 = 1e304.
const LARGEST_EXPONENT: f64 = 700.0;

/// Beyond this many rad [`sin_cos`] is the C library's: multiples of pi/2 are exact up to here, and far beyond.
const LARGEST_ANGLE: f64 = 1e5;

/// (sin x/x, cos x) for x within -+ pi/4.
#[inline]
fn sinc_cos_near_zero(x: f64) -> (f64, f64) {
    let (z, z2) = (x * x, x * x * (x * x));
    let sinc = (-0.166_666_666_666_666_32 + z * 0.008_333_333_333_322_49)
        + z2 * ((-0.000_198_412_698_298_579_5 + z * 2.755_731_370_707_006_8e-6)
            + z2 * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10));
    let cos = (0.041_666_666_666_666_6 + z * -0.001_388_888_888_887_411)
        + z2 * ((2.480_158_728_947_673e-5 + z * -2.755_731_435_139_066_3e-7)
            + z2 * (2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11));
    (1.0 + z * sinc, 1.0 - z * (0.5 - z * cos))
}

/// The smaller of two numbers: one instruction, where the standard library's also says what is to be done with NaN.
#[inline]
pub fn least(one: f64, other: f64) -> f64 {
    if one < other { one } else { other }
}

/// The larger of two numbers.
#[inline]
pub fn most(one: f64, other: f64) -> f64 {
    if one > other { one } else { other }
}

/// The square root of `x`: the number next to it, with the standard library and without.
#[inline]
pub(crate) fn sqrt(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(not(feature = "std"))]
    libm::sqrt(x)
}

/// Sine and cosine of `x` rad beyond [`LARGEST_ANGLE`]: the C library's, or what stands for it where there is none, whose
/// last bit may be another.
fn sin_cos_far(x: f64) -> (f64, f64) {
    #[cfg(feature = "std")]
    return x.sin_cos();
    #[cfg(not(feature = "std"))]
    libm::sincos(x)
}

/// Sine and cosine of `x` rad.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    if x.abs() > LARGEST_ANGLE {
        return sin_cos_far(x);
    }
    let shifted = x * FRAC_2_PI + SHIFT;
    let (quarters, turns) = (shifted.to_bits(), shifted - SHIFT);
    let rest = (x - turns * HALF_PI.0) - turns * HALF_PI.1;
    let (sinc, cos) = sinc_cos_near_zero(rest);
    let sin = rest * sinc;
    let (sin, cos) = if quarters & 1 == 0 { (sin, cos) } else { (cos, -sin) };
    if quarters & 2 == 0 { (sin, cos) } else { (-sin, -cos) }
}

/// (sin x/x, cos x); 1 and 1 at 0.
#[inline]
pub(crate) fn sinc_cos(x: f64) -> (f64, f64) {
    if x.abs() <= FRAC_PI_4 {
        return sinc_cos_near_zero(x);
    }
    let (sin, cos) = sin_cos(x);
    (sin / x, cos)
}

/// e^x; above 700 that of 700, below -700 nothing at all.
#[inline]
pub fn exp(x: f64) -> f64 {
    let rather_nothing = if x < -LARGEST_EXPONENT { 0.0 } else { 1.0 };
    let x = x.clamp(-LARGEST_EXPONENT, LARGEST_EXPONENT);
    let shifted = x * LOG2_E + SHIFT;
    let twos = shifted - SHIFT;
    let rest = (x - twos * LN_2.0) - twos * LN_2.1;
    let (z, z2) = (rest * rest, rest * rest * (rest * rest));
    let c = rest
        - z * ((0.166_666_666_666_666_02 + z * -0.002_777_777_777_701_559_3)
            + z2 * ((6.613_756_321_437_934e-5 + z * -1.653_390_220_546_525_2e-6)
                + z2 * 4.138_136_797_057_238_5e-8));
    let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
    // A factor, not a branch: loops over several values at a time have none.
    (1.0 + (rest + rest * c / (2.0 - c))) * (power * rather_nothing)
}

/// ln x for a normal positive x.
#[cfg(any(feature = "controller", test))]
#[inline]
pub(crate) fn ln(x: f64) -> f64 {
    // x = m 2^k with m from sqrt(1/2) to sqrt(2). Bit patterns of floats are in their order, with the exponent in front:
    // the distance from sqrt(1/2) begins with k. As an unsigned number, k + 1024 becomes a float the way SHIFT works.
    let from = x.to_bits().wrapping_sub(FRAC_1_SQRT_2.to_bits());
    let m = f64::from_bits(x.to_bits().wrapping_sub(from & (0xfff << 52)));
    let k_above = from.wrapping_add(1024 << 52) >> 52;
    let k = f64::from_bits(k_above | TWO_TO_52.to_bits()) - (TWO_TO_52 + 1024.0);
    let f = m - 1.0;
    let (s, half) = (f / (2.0 + f), 0.5 * f * f);
    let z = s * s;
    let r = z
        * (0.666_666_666_666_673_5
            + z * (0.399_999_999_994_094_2
                + z * (0.285_714_287_436_623_9
                    + z * (0.222_221_984_321_497_84
                        + z * (0.181_835_721_616_180_5
                            + z * (0.153_138_376_992_093_73 + z * 0.147_981_986_051_165_86))))));
    k * LN_2.0 - ((half - (s * (half + r) + k * LN_2.1)) - f)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TOLERANCE: f64 = f64::EPSILON;

    #[test]
    fn at_zero_and_one_they_are_exact() {
        assert_eq!((sin_cos(0.0), sinc_cos(0.0)), ((0.0, 1.0), (1.0, 1.0)));
        assert_eq!((exp(0.0), ln(1.0)), (1.0, 0.0));
        assert!(sin_cos(f64::NAN).0.is_nan() && exp(f64::NAN).is_nan());
        assert!(exp(f64::INFINITY) > 1e304 && exp(f64::NEG_INFINITY) == 0.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn sine_and_cosine_are_those_of_the_standard_library(x in prop_oneof![-1.0..1.0f64, -10.0..10.0f64, -2e5..2e5f64]) {
            let ((sin, cos), (sinc, same)) = (sin_cos(x), sinc_cos(x));
            prop_assert!((sin - x.sin()).abs() <= TOLERANCE && (cos - x.cos()).abs() <= TOLERANCE);
            prop_assert!((sinc * x - sin).abs() <= TOLERANCE && (same - cos).abs() <= TOLERANCE);
        }

        #[test]
        fn exponential_and_logarithm_are_those_of_the_standard_library(x in prop_oneof![-1.0..1.0f64, -690.0..690.0f64]) {
            prop_assert!((exp(x) / x.exp() - 1.0).abs() <= 2.0 * TOLERANCE, "{} {}", exp(x), x.exp());
            let y = x.exp();
            prop_assert!((ln(y) - y.ln()).abs() <= TOLERANCE * y.ln().abs(), "{} {}", ln(y), y.ln());
        }
    }
}
