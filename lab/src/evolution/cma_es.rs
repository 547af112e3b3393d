//! CMA-ES: a normal search distribution that adapts its mean, step and covariance to the fittest
//! (Hansen, "The CMA Evolution Strategy: A Tutorial", 2016, arXiv 1604.00772, figure 6).
//!
//! Ours rather than a crate: the ones there are draw from a generator of their own or cannot be stored between two
//! generations. It walks in the places of the genes' domains (`Gene::place`), so positive genes by their logarithm.

use super::genetic::ranking;
use super::genome::{Gene, Genome};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// First standard deviation, in parts of a domain.
const FIRST_STEP: f64 = 0.2;

/// Tries to draw an individual inside the domains, before its places are clamped to them.
const TRIES: usize = 20;

/// The state between two generations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CmaEs {
    mean: Vec<f64>,
    step: f64,
    /// Covariance by columns.
    covariance: Vec<f64>,
    step_path: Vec<f64>,
    covariance_path: Vec<f64>,
    generation: u32,
}

/// Constants of a dimension and population (Hansen 2016, table 1, without negative weights).
struct Constants {
    weights: Vec<f64>,
    /// Variance-effective number of parents.
    mu_eff: f64,
    c_sigma: f64,
    d_sigma: f64,
    c_c: f64,
    c_1: f64,
    c_mu: f64,
    /// Expected length of a standard normal vector.
    chi: f64,
}

impl Constants {
    fn new(dimension: usize, population: usize) -> Self {
        let (n, lambda) = (dimension as f64, population as f64);
        let parents = (population / 2).max(1);
        let raw: Vec<f64> =
            (1..=parents).map(|rank| ((lambda + 1.0) / 2.0).ln() - (rank as f64).ln()).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.into_iter().map(|weight| weight / sum).collect();
        let mu_eff = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let c_sigma = (mu_eff + 2.0) / (n + mu_eff + 5.0);
        let c_1 = 2.0 / ((n + 1.3).powi(2) + mu_eff);
        let c_mu = 2.0 * (mu_eff - 2.0 + 1.0 / mu_eff) / ((n + 2.0).powi(2) + mu_eff);
        Self {
            mu_eff,
            c_sigma,
            d_sigma: 1.0 + 2.0 * (((mu_eff - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma,
            c_c: (4.0 + mu_eff / n) / (n + 4.0 + 2.0 * mu_eff / n),
            c_1,
            c_mu: c_mu.clamp(0.0, 1.0 - c_1),
            chi: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
            weights,
        }
    }
}

impl CmaEs {
    /// A search that starts at `start`.
    pub fn new(genes: &[Gene], start: &[f64]) -> Self {
        let n = genes.len();
        let mean = start.iter().zip(genes).map(|(value, gene)| gene.place(*value)).collect();
        Self {
            mean,
            step: FIRST_STEP,
            covariance: DMatrix::<f64>::identity(n, n).as_slice().to_vec(),
            step_path: vec![0.0; n],
            covariance_path: vec![0.0; n],
            generation: 0,
        }
    }

    /// The mean of the search distribution: its best guess.
    pub fn mean(&self, genes: &[Gene]) -> Genome {
        self.mean.iter().zip(genes).map(|(place, gene)| gene.at(*place)).collect()
    }

    /// Individuals of the next generation, inside the domains.
    pub fn ask(&self, genes: &[Gene], population: usize, rng: &mut impl Rng) -> Vec<Genome> {
        let (vectors, lengths) = self.axes();
        let mut individual = || {
            let mut places = self.mean.clone();
            for _ in 0..TRIES {
                let z = DVector::from_fn(genes.len(), |_, _| rng.sample::<f64, _>(StandardNormal));
                let step = &vectors * z.component_mul(&lengths) * self.step;
                places = self.mean.iter().zip(step.iter()).map(|(mean, by)| mean + by).collect();
                if places.iter().all(|place| (0.0..=1.0).contains(place)) {
                    break;
                }
            }
            places.iter().zip(genes).map(|(place, gene)| gene.at(*place)).collect()
        };
        (0..population).map(|_| individual()).collect()
    }

    /// Learns from the fitness of what was asked.
    pub fn tell(&mut self, genes: &[Gene], population: &[Genome], fitness: &[f64]) {
        let n = genes.len();
        let constants = Constants::new(n, population.len());
        let steps: Vec<DVector<f64>> = ranking(fitness)
            .into_iter()
            .take(constants.weights.len())
            .map(|index| {
                let places = population[index].iter().zip(genes).map(|(x, gene)| gene.place(*x));
                let moved = places.zip(&self.mean).map(|(place, mean)| (place - mean) / self.step);
                DVector::from_iterator(n, moved)
            })
            .collect();
        let weighted = constants.weights.iter().zip(&steps);
        let mean_step =
            weighted.fold(DVector::zeros(n), |sum, (weight, step)| sum + step * *weight);
        for (mean, by) in self.mean.iter_mut().zip(mean_step.iter()) {
            *mean += self.step * by;
        }
        let step_path = self.lengthen_step_path(&constants, &mean_step);
        self.generation += 1;

        // The covariance path halts while the step grows fast.
        let Constants { c_sigma, d_sigma, c_c, c_1, c_mu, chi, mu_eff, .. } = constants;
        let settled = 1.0 - (1.0 - c_sigma).powi(2 * self.generation as i32);
        let follows = step_path / settled.sqrt() < (1.4 + 2.0 / (n as f64 + 1.0)) * chi;
        let part = if follows { (c_c * (2.0 - c_c) * mu_eff).sqrt() } else { 0.0 };
        let path =
            DVector::from_column_slice(&self.covariance_path) * (1.0 - c_c) + mean_step * part;
        let forgotten = if follows { 0.0 } else { c_1 * c_c * (2.0 - c_c) };
        let mut covariance =
            self.covariance() * (1.0 - c_1 - c_mu + forgotten) + &path * path.transpose() * c_1;
        for (weight, step) in constants.weights.iter().zip(&steps) {
            covariance += step * step.transpose() * (c_mu * weight);
        }
        self.covariance_path = path.as_slice().to_vec();
        self.covariance = covariance.as_slice().to_vec();
        self.step *= (c_sigma / d_sigma * (step_path / chi - 1.0)).exp().min(std::f64::consts::E);
        // A step beyond the domains finds nothing that one as wide as they are does not.
        self.step = self.step.clamp(1e-8, 1.0);
    }

    /// Adds the step to its path, in the axes of the covariance; the new length of the path.
    fn lengthen_step_path(&mut self, constants: &Constants, mean_step: &DVector<f64>) -> f64 {
        let (vectors, lengths) = self.axes();
        let white = &vectors * (vectors.transpose() * mean_step).component_div(&lengths);
        let c = constants.c_sigma;
        let path = DVector::from_column_slice(&self.step_path) * (1.0 - c)
            + white * (c * (2.0 - c) * constants.mu_eff).sqrt();
        self.step_path = path.as_slice().to_vec();
        path.norm()
    }

    fn covariance(&self) -> DMatrix<f64> {
        DMatrix::from_column_slice(self.mean.len(), self.mean.len(), &self.covariance)
    }

    /// Principal axes of the covariance, and standard deviations along them.
    fn axes(&self) -> (DMatrix<f64>, DVector<f64>) {
        let eigen = SymmetricEigen::new(self.covariance());
        (eigen.eigenvectors, eigen.eigenvalues.map(|value| value.max(1e-20).sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    /// How far in ln f a search comes on the ellipsoid sum (10^(i/(n-1)))^2 (x_i - 0.3)^2 in the domain [-1, 1]^n.
    fn remaining(generations: usize) -> f64 {
        let genes = [Gene::linear(-1.0, 1.0); 6];
        let cost = |genome: &Genome| -> f64 {
            let scaled = genome.iter().enumerate();
            scaled.map(|(i, x)| (10.0_f64.powf(i as f64 / 5.0) * (x - 0.3)).powi(2)).sum()
        };
        let mut rng = Pcg64::seed_from_u64(3);
        let mut search = CmaEs::new(&genes, &[-0.8; 6]);
        for _ in 0..generations {
            let population = search.ask(&genes, 12, &mut rng);
            let fitness: Vec<f64> = population.iter().map(|genome| -cost(genome)).collect();
            search.tell(&genes, &population, &fitness);
        }
        cost(&search.mean(&genes))
    }

    /// Linear convergence: a search without covariance or step adaptation does not come near.
    #[test]
    fn an_ellipsoid_is_descended_to_its_bottom() {
        let (soon, late) = (remaining(30), remaining(150));
        assert!(soon < 1.0 && late < 1e-10, "{soon} {late}");
    }

    /// The optimum in a corner of the domain is found though half of the distribution lies outside.
    #[test]
    fn an_optimum_on_the_border_is_reached() {
        let genes = [Gene::logarithmic(0.01, 100.0), Gene::linear(-1.0, 1.0)];
        let mut rng = Pcg64::seed_from_u64(5);
        let mut search = CmaEs::new(&genes, &[1.0, 0.0]);
        for _ in 0..100 {
            let population = search.ask(&genes, 10, &mut rng);
            let inside = |genome: &Genome| genome.iter().zip(genes).all(|(x, gene)| gene.holds(*x));
            assert!(population.iter().all(inside));
            let fitness: Vec<f64> = population.iter().map(|it| it[0].ln() + it[1]).collect();
            search.tell(&genes, &population, &fitness);
        }
        let mean = search.mean(&genes);
        assert!(mean[0] > 90.0 && mean[1] > 0.98, "{mean:?}");
    }
}
