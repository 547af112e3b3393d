//! Empirical Bayes: the prior under which the samples of many episodes are likeliest (type II maximum likelihood).
//!
//! Each episode is a group with its own mean and variance, drawn from the prior. The evidence of a group is closed
//! form (`NormalInverseChiSquared::ln_evidence`); the sum over all groups is maximised channel by channel.

use super::cma_es::CmaEs;
use super::genome::{CHANNEL_GENES, Genome};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use umwelt_core::conjugate::{NormalInverseChiSquared, SampleStatistics};

/// Individuals and generations of the inner search over four numbers: it is on its optimum to three digits long
/// before.
const INNER: (usize, usize) = (12, 60);

/// The genome whose prior maximises the evidence of `groups`, one per episode: for each of the genome's channels the
/// statistics of its samples. Starts from `start`; a channel without samples stays as it is there.
pub fn fit(groups: &[[SampleStatistics; 4]], start: &[f64], seed: u64) -> Genome {
    let mut genome = start.to_vec();
    for (channel, genes) in genome.chunks_exact_mut(4).enumerate() {
        let groups: Vec<SampleStatistics> =
            groups.iter().map(|group| group[channel]).filter(|group| group.samples > 0).collect();
        if groups.is_empty() {
            continue;
        }
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut search = CmaEs::new(&CHANNEL_GENES, genes);
        for _ in 0..INNER.1 {
            let population = search.ask(&CHANNEL_GENES, INNER.0, &mut rng);
            let fitness: Vec<f64> =
                population.iter().map(|genome| ln_evidence(genome, &groups)).collect();
            search.tell(&CHANNEL_GENES, &population, &fitness);
        }
        let fitted = search.mean(&CHANNEL_GENES);
        if ln_evidence(&fitted, &groups) > ln_evidence(genes, &groups) {
            genes.copy_from_slice(&fitted);
        }
    }
    genome
}

/// Sum of the groups' evidence under the prior (mu, k, r, s), up to a constant that depends on the samples' weights
/// alone.
fn ln_evidence(genes: &[f64], groups: &[SampleStatistics]) -> f64 {
    let &[mu, k, r, s] = genes else { return f64::NEG_INFINITY };
    let Ok(prior) = NormalInverseChiSquared::new(mu, k, r, s) else { return f64::NEG_INFINITY };
    groups.iter().map(|group| prior.ln_evidence(prior.update_all(group))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{ChiSquared, Distribution, StandardNormal};

    /// Groups drawn from a known prior: it is found again. 4000 groups of 8 samples know the scale s/r to a few
    /// percent and k to ten.
    #[test]
    fn the_prior_that_made_the_groups_is_found() {
        let (mu, k, r, s) = (-0.1_f64, 2.0_f64, 8.0_f64, 0.08_f64);
        let mut rng = Pcg64::seed_from_u64(11);
        let normal = |rng: &mut Pcg64| -> f64 { StandardNormal.sample(rng) };
        let chi = ChiSquared::new(r).unwrap();
        let groups: Vec<[SampleStatistics; 4]> = (0..4000)
            .map(|_| {
                let variance: f64 = s / chi.sample(&mut rng);
                let mean = mu + (variance / k).sqrt() * normal(&mut rng);
                let mut group = SampleStatistics::default();
                for _ in 0..8 {
                    group.add(mean + (variance / 1.2).sqrt() * normal(&mut rng), 1.2);
                }
                [group; 4]
            })
            .collect();
        let start = [0.0, 1.0, 4.0, 0.045].repeat(3);
        let genome = fit(&groups, &start, 1);
        assert_eq!(genome.len(), 12);
        for found in genome.chunks_exact(4) {
            let &[mu_found, k_found, r_found, s_found] = found else { unreachable!() };
            assert!((mu_found - mu).abs() < 0.01, "{found:?}");
            assert!((k_found / k - 1.0).abs() < 0.15, "{found:?}");
            assert!((r_found / r - 1.0).abs() < 0.15, "{found:?}");
            assert!((s_found / r_found / (s / r) - 1.0).abs() < 0.05, "{found:?}");
        }
    }

    #[test]
    fn a_channel_without_samples_stays_as_it_is() {
        let start = [0.0, 1.0, 4.0, 0.045].repeat(3);
        assert_eq!(fit(&[[SampleStatistics::default(); 4]], &start, 1), start);
    }
}
