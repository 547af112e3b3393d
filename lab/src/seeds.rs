//! Seeds of everything random in an evolution or a comparison: each is a function of the root seed and of what it is for.
//!
//! Nothing is drawn in sequence, so no result depends on the order in which episodes run, on how many threads run
//! them, or on whether the evolution was resumed.

use rand::SeedableRng;
use rand_pcg::Pcg64;
use umwelt_core::draws::mix;

/// What a seed is for; each purpose has seeds of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// The first population.
    Populate = 1,
    /// What is bred after a generation.
    Breed = 2,
    /// Episodes of fixed-normal, to which fitness is normalised.
    Reference = 3,
    /// Episodes of a generation.
    Train = 4,
    /// Episodes that choose the champion.
    Select = 5,
    /// Episodes on which the champion is reported.
    Report = 6,
    /// Episodes that say how each environment of a comparison shows in the samples.
    Recognise = 7,
    /// Episodes that are compared.
    Compare = 8,
    /// What is drawn again from them for intervals.
    Resample = 9,
    /// Robots with whom beliefs are checked.
    Calibrate = 10,
}

/// The seed for `purpose` at `place`, which are at most a few small numbers such as generation and trial.
pub(crate) fn seed(root: u64, purpose: Purpose, place: [usize; 3]) -> u64 {
    let start = mix(mix(root).wrapping_add(purpose as u64));
    place.into_iter().fold(start, |seed, number| mix(seed.wrapping_add(number as u64 + 1)))
}

/// A generator for `purpose` in `generation`.
pub(crate) fn rng(root: u64, purpose: Purpose, generation: usize) -> Pcg64 {
    Pcg64::seed_from_u64(seed(root, purpose, [generation, 0, 0]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn no_two_places_share_a_seed() {
        let mut seen = BTreeSet::new();
        for root in 0..3 {
            for purpose in [Purpose::Reference, Purpose::Train, Purpose::Select, Purpose::Compare] {
                for generation in 0..10 {
                    for environment in 0..5 {
                        for trial in 0..10 {
                            let place = [generation, environment, trial];
                            assert!(seen.insert(seed(root, purpose, place)));
                        }
                    }
                }
            }
        }
    }
}
