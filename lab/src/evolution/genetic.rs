//! The thesis's genetic algorithm: roulette selection, crossover with expansion, reproduction, mutation
//! (section 4.3, table 2, eq. 39-51, corrected).

use super::genome::{Gene, Genome};
use rand::{Rng, RngExt};

/// What may happen to an individual of the next generation, and how often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneticSettings {
    /// Probability of being crossed from two selected parents.
    pub crossover: f64,
    /// Probability of being one selected parent again.
    pub reproduction: f64,
    /// Probability of being drawn anew. The three sum to one.
    pub mutation: f64,
    /// By how many times their distance a child may lie outside its parents (a of eq. 40-43), 0..=10.
    pub expansion: f64,
    /// Fittest individuals that are taken over unchanged; none in the thesis. They are evaluated anew all the same.
    pub elites: usize,
}

impl Default for GeneticSettings {
    /// Thesis table 2.
    fn default() -> Self {
        Self { crossover: 0.49, reproduction: 0.49, mutation: 0.02, expansion: 1.2, elites: 0 }
    }
}

/// A first population, drawn from the domains (thesis section 4.3; eq. 48-51).
pub fn populate(genes: &[Gene], population: usize, rng: &mut impl Rng) -> Vec<Genome> {
    (0..population).map(|_| draw(genes, rng)).collect()
}

/// The generation after `population`, whose fitness is not negative and as long.
pub fn breed(
    genes: &[Gene],
    settings: &GeneticSettings,
    population: &[Genome],
    fitness: &[f64],
    rng: &mut impl Rng,
) -> Vec<Genome> {
    let roulette = Roulette::new(fitness);
    let elites = ranking(fitness).into_iter().take(settings.elites);
    let mut next: Vec<Genome> = elites.map(|index| population[index].clone()).collect();
    while next.len() < population.len() {
        let fate = rng.random::<f64>();
        next.push(if fate < settings.crossover {
            let (one, other) = (roulette.spin(rng), roulette.spin(rng));
            cross(genes, settings.expansion, &population[one], &population[other], rng)
        } else if fate < settings.crossover + settings.reproduction {
            population[roulette.spin(rng)].clone()
        } else {
            draw(genes, rng)
        });
    }
    next
}

/// Indices by falling fitness; equal ones in their order.
pub(super) fn ranking(fitness: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..fitness.len()).collect();
    order.sort_by(|&one, &other| fitness[other].total_cmp(&fitness[one]));
    order
}

fn draw(genes: &[Gene], rng: &mut impl Rng) -> Genome {
    genes.iter().map(|gene| gene.draw(rng)).collect()
}

/// A child of two parents: each gene uniform in [min - a I, max + a I] with I = |difference| (thesis eq. 40-47).
/// As printed, k, r or s can come out negative: draws outside the domain are drawn again, which is the same as
/// drawing from the part of the interval that is inside. It is never empty: the parents are in it.
fn cross(genes: &[Gene], expansion: f64, one: &[f64], other: &[f64], rng: &mut impl Rng) -> Genome {
    let parents = one.iter().zip(other);
    parents
        .zip(genes)
        .map(|((one, other), gene)| {
            let reach = expansion * (one - other).abs();
            let low = (one.min(*other) - reach).max(gene.low);
            let high = (one.max(*other) + reach).min(gene.high);
            rng.random_range(low..=high)
        })
        .collect()
}

/// Selection with probability proportional to fitness: `p_i = f_i / sum f` (thesis eq. 39).
/// Where every fitness is zero, all are equally likely.
struct Roulette {
    /// Running sums.
    sums: Vec<f64>,
}

impl Roulette {
    fn new(fitness: &[f64]) -> Self {
        let is_uniform = fitness.iter().all(|&fitness| fitness <= 0.0);
        let share = |fitness: f64| if is_uniform { 1.0 } else { fitness.max(0.0) };
        let sums = fitness.iter().scan(0.0, |sum, &fitness| {
            *sum += share(fitness);
            Some(*sum)
        });
        Self { sums: sums.collect() }
    }

    fn spin(&self, rng: &mut impl Rng) -> usize {
        let ball = rng.random::<f64>() * self.sums.last().copied().unwrap_or(0.0);
        // The first sum above the ball: an individual without fitness adds nothing to the sums and is never it.
        self.sums.partition_point(|&sum| sum <= ball).min(self.sums.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::super::genome::CHANNEL_GENES;
    use super::*;
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    fn rng() -> Pcg64 {
        Pcg64::seed_from_u64(7)
    }

    /// Four standard deviations of a share p of n.
    fn tolerance(p: f64, n: usize) -> f64 {
        4.0 * (p * (1.0 - p) / n as f64).sqrt()
    }

    #[test]
    fn roulette_selects_in_proportion_to_fitness() {
        let (roulette, mut rng, n) = (Roulette::new(&[1.0, 0.0, 3.0, 4.0]), rng(), 100_000);
        let mut counts = [0_usize; 4];
        (0..n).for_each(|_| counts[roulette.spin(&mut rng)] += 1);
        assert_eq!(counts[1], 0, "without fitness none is selected");
        for (count, p) in counts.into_iter().zip([0.125, 0.0, 0.375, 0.5]) {
            assert!((count as f64 / n as f64 - p).abs() <= tolerance(p, n), "{counts:?}");
        }
    }

    #[test]
    fn without_any_fitness_all_are_equally_likely() {
        let (roulette, mut rng, n) = (Roulette::new(&[0.0; 5]), rng(), 100_000);
        let mut counts = [0_usize; 5];
        (0..n).for_each(|_| counts[roulette.spin(&mut rng)] += 1);
        for count in counts {
            assert!((count as f64 / n as f64 - 0.2).abs() <= tolerance(0.2, n), "{counts:?}");
        }
    }

    /// A uniform on [min - 1.2 I, max + 1.2 I] has the parents' middle as mean and (3.4 I)^2/12 as variance.
    #[test]
    fn a_child_is_uniform_around_its_parents() {
        let (genes, mut rng, n) = ([Gene::linear(-100.0, 100.0)], rng(), 100_000);
        let children: Vec<f64> =
            (0..n).map(|_| cross(&genes, 1.2, &[1.0], &[3.0], &mut rng)[0]).collect();
        let mean = children.iter().sum::<f64>() / n as f64;
        let variance = children.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64;
        let expected = (3.4_f64 * 2.0).powi(2) / 12.0;
        assert!((mean - 2.0).abs() < 4.0 * (expected / n as f64).sqrt(), "{mean}");
        // the variance of a uniform's sample variance is 0.8 variance^2/n
        assert!((variance / expected - 1.0).abs() < 4.0 * (0.8 / n as f64).sqrt(), "{variance}");
        assert!(children.iter().all(|x| (-1.4..=5.4).contains(x)));
    }

    #[test]
    fn the_next_generation_is_made_in_the_stated_shares() {
        let genes = [Gene::linear(0.0, 1.0)];
        let population: Vec<Genome> = vec![vec![0.25], vec![0.25]];
        // Equal parents have themselves as children: what differs is a mutant.
        let settings = GeneticSettings {
            crossover: 0.3,
            reproduction: 0.5,
            mutation: 0.2,
            ..Default::default()
        };
        let (mut rng, mut mutants, n) = (rng(), 0, 20_000);
        for _ in 0..n / 2 {
            let next = breed(&genes, &settings, &population, &[1.0, 1.0], &mut rng);
            mutants += next.iter().filter(|genome| genome[0] != 0.25).count();
        }
        assert!((mutants as f64 / f64::from(n) - 0.2).abs() < tolerance(0.2, n as usize));
    }

    #[test]
    fn elites_are_taken_over_and_none_by_default() {
        let genes = [Gene::linear(0.0, 1.0)];
        let population: Vec<Genome> = (0..10).map(|i| vec![f64::from(i) / 10.0]).collect();
        let fitness: Vec<f64> = (0..10).map(f64::from).collect();
        let all_mutants = GeneticSettings {
            crossover: 0.0,
            reproduction: 0.0,
            mutation: 1.0,
            ..Default::default()
        };
        let next = breed(&genes, &all_mutants, &population, &fitness, &mut rng());
        assert!(next.iter().all(|genome| !population.contains(genome)));
        let settings = GeneticSettings { elites: 2, ..all_mutants };
        let next = breed(&genes, &settings, &population, &fitness, &mut rng());
        assert_eq!(next[..2], [vec![0.9], vec![0.8]]);
        assert_eq!(next.len(), 10);
    }

    proptest! {
        #[test]
        fn every_gene_stays_in_its_domain(
            seed in any::<u64>(), fitness in prop::collection::vec(0.0..3.0_f64, 20),
        ) {
            let mut rng = Pcg64::seed_from_u64(seed);
            let mut population = populate(&CHANNEL_GENES, 20, &mut rng);
            let settings = GeneticSettings { expansion: 10.0, ..Default::default() };
            for _ in 0..20 {
                population = breed(&CHANNEL_GENES, &settings, &population, &fitness, &mut rng);
                for genome in &population {
                    prop_assert!(genome.iter().zip(CHANNEL_GENES).all(|(x, gene)| gene.holds(*x)));
                }
            }
        }
    }
}
