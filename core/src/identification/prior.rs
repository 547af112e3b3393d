//! The documented default prior.

use crate::conjugate::NormalInverseChiSquared;
use crate::controller::settings::Prior;

impl Default for Prior {
    /// A weak prior for a floor and a link of which nothing is known: a ratio of standard deviation 0.15 over
    /// 100 ms (what recorded robots show), four degrees of freedom so that its variance exists, and a mean that
    /// one sample can move half way. Lateral slip and drift are expected to be three times smaller.
    fn default() -> Self {
        let weak = |sd: f64| {
            let (k, r) = (1.0, 4.0);
            NormalInverseChiSquared::new(0.0, k, r, sd * sd * (r - 2.0))
                .expect("constants in their domain")
        };
        Self { forward: weak(0.15), lateral: weak(0.05), turn: weak(0.15), drift: weak(0.05) }
    }
}
