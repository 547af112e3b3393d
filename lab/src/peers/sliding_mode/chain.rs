//! The loop delay as a Markov chain over whole slots, learned while it runs.

/// States: delays of 0 to 0.69 s in slots of 30 ms. The last one stands for everything longer and for packets lost.
const STATES: usize = 24;

/// The prior of each row of the transition matrix before any delivery, in deliveries.
const PRIOR: f64 = 1.0;

/// The part of it that is spread over all states alike (Laplace); the rest is on the nominal delay.
const SPREAD: f64 = 0.1;

/// Transition counts between delays of consecutive deliveries.
///
/// Each row is a Dirichlet posterior. A late packet on a link that keeps the order is followed by those that it held back,
/// each a slot less late than the one before: such runs are what the chain learns.
#[derive(Clone, Debug, PartialEq)]
pub struct DelayChain {
    counts: Box<[[f64; STATES]; STATES]>,
    /// Deliveries counted in each row.
    totals: [f64; STATES],
    last: usize,
    nominal: usize,
    slot: f64,
}

impl DelayChain {
    /// A chain of slots of `slot` s that expects a delay of `nominal` s.
    pub fn new(slot: f64, nominal: f64) -> Self {
        let nominal = state(nominal, slot);
        Self {
            counts: Box::new([[0.0; STATES]; STATES]),
            totals: [0.0; STATES],
            last: nominal,
            nominal,
            slot,
        }
    }

    /// The next delivery took `delay` s.
    pub fn learn(&mut self, delay: f64) {
        let next = state(delay, self.slot);
        self.counts[self.last][next] += 1.0;
        self.totals[self.last] += 1.0;
        self.last = next;
    }

    /// The probability that a delay of `from` slots is followed by one of `to`.
    pub fn probability(&self, from: usize, to: usize) -> f64 {
        let sure = if to == self.nominal { 1.0 - SPREAD } else { 0.0 };
        let prior = PRIOR * (sure + SPREAD / STATES as f64);
        (self.counts[from][to] + prior) / (self.totals[from] + PRIOR)
    }

    /// The delay in s expected `steps` deliveries after the last one.
    pub fn expected(&self, steps: usize) -> f64 {
        let mut now = [0.0; STATES];
        now[self.last] = 1.0;
        for _ in 0..steps {
            let mut next = [0.0; STATES];
            for (from, share) in now.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                // The prior of a row apart from its counts: most of those are zero.
                let weight = share / (self.totals[from] + PRIOR);
                for (next, count) in next.iter_mut().zip(&self.counts[from]) {
                    *next += weight * (count + PRIOR * SPREAD / STATES as f64);
                }
                next[self.nominal] += weight * PRIOR * (1.0 - SPREAD);
            }
            now = next;
        }
        now.iter().enumerate().map(|(state, share)| state as f64 * share).sum::<f64>() * self.slot
    }
}

/// The state of a delay in s: whole slots, rounded.
fn state(delay: f64, slot: f64) -> usize {
    // A float beyond the range of a usize becomes its end.
    ((delay / slot).round() as usize).min(STATES - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    #[test]
    fn a_chain_of_two_states_is_learned() {
        let (stay, back, steps) = (0.9, 0.3, 20_000);
        let mut rng = Pcg64::seed_from_u64(3);
        let (mut chain, mut late) = (DelayChain::new(0.03, 0.18), false);
        for _ in 0..steps {
            let draw: f64 = rng.random();
            late = if late { draw >= back } else { draw >= stay };
            chain.learn(if late { 0.57 } else { 0.18 });
        }
        // Standard error of a share: sqrt(0.25/5000) at most, as the late state has a quarter of the steps.
        assert!((chain.probability(6, 6) - stay).abs() < 0.02);
        assert!((chain.probability(19, 6) - back).abs() < 0.02);
        // Far ahead nothing is left but the stationary share of late ones: 0.1/(0.1 + 0.3).
        let expected = 0.25 * 0.57 + 0.75 * 0.18;
        assert!((chain.expected(60) - expected).abs() < 0.02, "{}", chain.expected(60));
        // One step ahead, it is what follows the last one.
        chain.learn(0.57);
        let expected = 0.3 * 0.18 + 0.7 * 0.57;
        assert!((chain.expected(1) - expected).abs() < 0.01, "{}", chain.expected(1));
    }

    #[test]
    fn every_row_is_a_distribution_and_the_first_belief_is_the_nominal_delay() {
        let mut chain = DelayChain::new(0.03, 0.24);
        assert!((chain.expected(1) - 0.24).abs() < 0.015);
        assert_eq!(chain.expected(0), 0.24);
        for delay in [0.1, 0.2, 9.0, 0.0, f64::INFINITY, 0.2] {
            chain.learn(delay);
        }
        for from in 0..STATES {
            let sum: f64 = (0..STATES).map(|to| chain.probability(from, to)).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
        // Whatever is longer, or was never delivered, is the last state.
        assert!(chain.probability(0, STATES - 1) > 0.5 && chain.probability(STATES - 1, 0) > 0.3);
    }

    /// The expectation by powers of the transition matrix, the naive way.
    #[test]
    fn the_expectation_is_that_of_the_transition_matrix() {
        let mut chain = DelayChain::new(0.03, 0.24);
        for delay in [0.18, 0.57, 0.54, 0.51, 0.18, 0.15, 0.18, 0.57, 0.18] {
            chain.learn(delay);
        }
        let mut now = vec![0.0; STATES];
        now[6] = 1.0;
        for _ in 0..3 {
            now = (0..STATES)
                .map(|to| (0..STATES).map(|from| now[from] * chain.probability(from, to)).sum())
                .collect();
        }
        let naive: f64 = now.iter().enumerate().map(|(i, share)| i as f64 * 0.03 * share).sum();
        assert!((chain.expected(3) - naive).abs() < 1e-12);
    }
}
