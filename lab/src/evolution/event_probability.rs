//! The experiment from which the thesis starts (its eq. 1-2, after Ramirez & Marshall 2017): individuals whose prior
//! about the probability of an event has evolved predict it better than samples alone.
//!
//! Here the event is a late packet. Nature draws links, each with its own late-packet rate; an individual is a prior
//! Beta(alpha, beta), sees a few packets of each link and predicts the rate of every one. The genome has two genes
//! instead of a prior's twelve, the genetic algorithm is the same.

use super::genetic::{self, GeneticSettings};
use super::genome::Gene;
use super::seeds::{self, Purpose};
use rand::{Rng, RngExt};
use rand_distr::{Beta, Distribution};
use umwelt_core::conjugate::BetaBernoulli;

/// Genes of (alpha, beta): up to what a hundred packets would say.
const GENES: [Gene; 2] = [Gene::logarithmic(0.01, 100.0); 2];

/// What nature and evolution are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Rates of the links are drawn from Beta(alpha, beta), which the individuals do not know.
    pub nature: BetaBernoulli,
    /// Links per generation, the set S of eq. 2.
    pub links: usize,
    /// Packets n that are seen of each link.
    pub packets: u32,
    /// Individuals.
    pub population: usize,
    /// Generations.
    pub generations: usize,
    /// Of everything random.
    pub seed: u64,
}

/// Mean squared errors over fresh links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Samples alone: k/n.
    pub samples: f64,
    /// The uniform prior, Beta(1, 1).
    pub uniform: f64,
    /// The evolved prior.
    pub evolved: f64,
    /// The prior from which nature draws: no prediction from so many packets can be better.
    pub nature: f64,
}

/// One link: its rate, and how many of the packets seen were late.
type Seen = (f64, u32);

/// phi_x = (k + alpha)/(n + alpha + beta), thesis eq. 1.
pub fn predict(prior: &BetaBernoulli, late: u32, packets: u32) -> f64 {
    let (alpha, beta) = (prior.alpha(), prior.beta());
    (f64::from(late) + alpha) / (f64::from(packets) + alpha + beta)
}

/// f = 1/(1 + sum (p_i - phi(p_i))^2), thesis eq. 2.
fn fitness(prior: &BetaBernoulli, seen: &[Seen], packets: u32) -> f64 {
    let squares = seen.iter().map(|&(p, late)| (p - predict(prior, late, packets)).powi(2));
    1.0 / (1.0 + squares.sum::<f64>())
}

fn prior(genome: &[f64]) -> BetaBernoulli {
    BetaBernoulli::new(genome[0], genome[1]).expect("genes are positive")
}

impl Experiment {
    /// Links of nature, and what is seen of them.
    fn see(&self, links: usize, rng: &mut impl Rng) -> Vec<Seen> {
        let nature = Beta::new(self.nature.alpha(), self.nature.beta()).expect("positive");
        let link = |_| {
            let p = nature.sample(rng);
            (p, (0..self.packets).filter(|_| rng.random::<f64>() < p).count() as u32)
        };
        (0..links).map(link).collect()
    }

    /// Evolves a prior; the mean fitness of each generation goes to `show`. Returns the mean of the last population:
    /// it has no single winner's luck.
    pub fn evolve(&self, mut show: impl FnMut(usize, f64)) -> BetaBernoulli {
        let settings = GeneticSettings::default();
        let mut rng = seeds::rng(self.seed, Purpose::Populate, 0);
        let mut population = genetic::populate(&GENES, self.population, &mut rng);
        for generation in 0..self.generations {
            let mut rng = seeds::rng(self.seed, Purpose::Train, generation);
            let seen = self.see(self.links, &mut rng);
            let fitness: Vec<f64> =
                population.iter().map(|it| fitness(&prior(it), &seen, self.packets)).collect();
            show(generation, fitness.iter().sum::<f64>() / fitness.len() as f64);
            let mut rng = seeds::rng(self.seed, Purpose::Breed, generation);
            population = genetic::breed(&GENES, &settings, &population, &fitness, &mut rng);
        }
        let mean = |gene: usize| {
            population.iter().map(|genome| genome[gene].ln()).sum::<f64>() / population.len() as f64
        };
        prior(&[mean(0).exp(), mean(1).exp()])
    }

    /// How well `evolved` predicts the rates of `links` fresh links, beside what it has to beat.
    pub fn errors(&self, evolved: &BetaBernoulli, links: usize) -> Errors {
        let mut rng = seeds::rng(self.seed, Purpose::Report, 0);
        let seen = self.see(links, &mut rng);
        let error = |predict: &dyn Fn(u32) -> f64| {
            seen.iter().map(|&(p, late)| (p - predict(late)).powi(2)).sum::<f64>() / links as f64
        };
        let packets = self.packets;
        let of = |prior: &BetaBernoulli| error(&|late| predict(prior, late, packets));
        Errors {
            samples: error(&|late| f64::from(late) / f64::from(packets)),
            uniform: BetaBernoulli::new(1.0, 1.0).map_or(f64::NAN, |uniform| of(&uniform)),
            evolved: of(evolved),
            nature: of(&self.nature),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn experiment(packets: u32, seed: u64) -> Experiment {
        Experiment {
            nature: BetaBernoulli::new(2.0, 38.0).unwrap(),
            links: 100,
            packets,
            population: 60,
            generations: 40,
            seed,
        }
    }

    #[test]
    fn predictions_and_fitness_are_those_of_equations_1_and_2() {
        let prior = BetaBernoulli::new(1.0, 3.0).unwrap();
        assert_eq!(predict(&prior, 2, 6), 0.3);
        let fit = fitness(&prior, &[(0.3, 2), (0.5, 2)], 6);
        assert!((fit - 1.0 / 1.04).abs() < 1e-12);
        // eq. 1 is the mean of the posterior
        let posterior = prior.update(true).update(false);
        assert!((predict(&prior, 1, 2) - posterior.predictive()).abs() < 1e-12);
    }

    /// Whatever the seed, the evolved prior is better than samples alone and than no opinion, and nearly as good as
    /// can be.
    #[test]
    fn evolved_individuals_predict_better_than_samples_alone() {
        for seed in 1..=5 {
            let experiment = experiment(10, seed);
            let errors = experiment.errors(&experiment.evolve(|_, _| {}), 5000);
            assert!(errors.evolved < 0.5 * errors.samples, "{errors:?}");
            assert!(errors.evolved < 0.5 * errors.uniform, "{errors:?}");
            assert!(errors.evolved < 1.6 * errors.nature, "{errors:?}");
        }
    }

    #[test]
    fn fitness_grows_over_the_generations() {
        let mut means = Vec::new();
        experiment(10, 1).evolve(|_, mean| means.push(mean));
        let mean = |range: std::ops::Range<usize>| means[range].iter().sum::<f64>() / 5.0;
        assert!(mean(35..40) > mean(0..5), "{means:?}");
    }

    #[test]
    fn the_same_seed_evolves_the_same_prior() {
        let evolve = |seed| experiment(10, seed).evolve(|_, _| {});
        assert_eq!(evolve(3), evolve(3));
        assert_ne!(evolve(3), evolve(4));
    }
}
