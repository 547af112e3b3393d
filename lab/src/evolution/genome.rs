//! A genome: numbers, each with its domain; as a prior, four for every channel that the method uses.

use rand::{Rng, RngExt};
use umwelt_core::conjugate::NormalInverseChiSquared;
use umwelt_core::settings::Prior;

/// Largest error ratio that a prior may expect (`MAX_mu` of thesis eq. 48, drawn symmetrically): beyond it no
/// prediction follows, since learned means are clamped.
pub const MAX_MU: f64 = 0.5;

/// Largest k, r and s (`MAX_c` of thesis eq. 49-51, which it does not give). As many samples as the calibration gives,
/// some 80, and a few more: a prior may outweigh it, or evolution would have nothing to choose. With s as large as r
/// an error may be as large as the motion, so that the first population holds the careless as well as those whom the
/// variance rule slows down (it binds from a standard deviation of about 0.5).
pub const MAX_C: f64 = 100.0;

/// Smallest k, r and s: below them a prior says nothing that a single sample does not.
pub const MIN_K: f64 = 0.01;
/// See [`MIN_K`].
pub const MIN_R: f64 = 0.1;
/// See [`MIN_K`]; a standard deviation of half a percent at r = 4.
pub const MIN_S: f64 = 1e-4;

/// What one gene may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gene {
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Whether a search by steps walks in its logarithm; where it is, `low` is positive.
    pub logarithmic: bool,
}

impl Gene {
    /// A gene in [low, high] that is searched as it is.
    pub const fn linear(low: f64, high: f64) -> Self {
        Self { low, high, logarithmic: false }
    }

    /// A positive gene in [low, high] that is searched by its logarithm.
    pub const fn logarithmic(low: f64, high: f64) -> Self {
        Self { low, high, logarithmic: true }
    }

    /// A value drawn uniformly from the domain (thesis eq. 48-51).
    pub fn draw(&self, rng: &mut impl Rng) -> f64 {
        rng.random_range(self.low..=self.high)
    }

    /// Whether `value` is in the domain.
    #[cfg(test)]
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// The value at `place` in [0, 1] of the domain, in logarithms where it is searched so; places outside are
    /// those of the nearer end.
    pub fn at(&self, place: f64) -> f64 {
        let value = if self.logarithmic {
            self.low * (self.high / self.low).powf(place)
        } else {
            self.low + (self.high - self.low) * place
        };
        value.clamp(self.low, self.high)
    }

    /// The place of `value`, the inverse of [`Gene::at`].
    pub fn place(&self, value: f64) -> f64 {
        let value = value.clamp(self.low, self.high);
        if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }
}

/// One individual: a value per gene.
pub type Genome = Vec<f64>;

/// Genes of one channel's (mu, k, r, s).
pub const CHANNEL_GENES: [Gene; 4] = [
    Gene::linear(-MAX_MU, MAX_MU),
    Gene::logarithmic(MIN_K, MAX_C),
    Gene::logarithmic(MIN_R, MAX_C),
    Gene::logarithmic(MIN_S, MAX_C),
];

/// The genes of a prior: forward, lateral and turn (the thesis), and drift where the method uses it.
pub fn prior_genes(drift: bool) -> Vec<Gene> {
    CHANNEL_GENES.repeat(if drift { 4 } else { 3 })
}

/// The prior that a genome of [`prior_genes`] is; a channel without genes has its weak default.
pub fn to_prior(genome: &[f64]) -> Prior {
    let weak = Prior::default();
    let channel =
        |index: usize, weak: NormalInverseChiSquared| match genome.get(4 * index..4 * index + 4) {
            Some(&[mu, k, r, s]) => NormalInverseChiSquared::new(mu, k, r, s).unwrap_or(weak),
            _ => weak,
        };
    Prior {
        forward: channel(0, weak.forward),
        lateral: channel(1, weak.lateral),
        turn: channel(2, weak.turn),
        drift: channel(3, weak.drift),
    }
}

/// The genome nearest to `prior`.
pub fn of_prior(prior: &Prior, drift: bool) -> Genome {
    let channels = [prior.forward, prior.lateral, prior.turn, prior.drift];
    let values = channels.iter().flat_map(|it| [it.mu(), it.k(), it.r(), it.s()]);
    let genes = prior_genes(drift);
    values.zip(&genes).map(|(value, gene)| value.clamp(gene.low, gene.high)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_weak_default_is_in_the_domain_and_comes_back() {
        let prior = Prior::default();
        for drift in [false, true] {
            let genome = of_prior(&prior, drift);
            assert_eq!(genome.len(), if drift { 16 } else { 12 });
            assert_eq!(to_prior(&genome), prior);
        }
    }

    proptest! {
        #[test]
        fn places_and_values_are_inverse(place in 0.0..=1.0_f64) {
            for gene in CHANNEL_GENES {
                prop_assert!(gene.holds(gene.at(place)));
                prop_assert!((gene.place(gene.at(place)) - place).abs() < 1e-9);
            }
        }

        #[test]
        fn places_outside_are_those_of_the_nearer_end(place in 1.0..1e3_f64) {
            for gene in CHANNEL_GENES {
                prop_assert_eq!((gene.at(-place), gene.at(place)), (gene.low, gene.high));
            }
        }
    }
}
