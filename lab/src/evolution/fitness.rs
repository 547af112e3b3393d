//! Fitness: 1 is that of fixed-normal.

use super::episode::Evaluation;
use super::settings::EvolutionSettings;
use super::{Evolution, REFERENCE_TRIALS};

impl Evolution {
    /// Mean fitness of fixed-normal in each environment, or what just keeps the limits where it has none.
    pub(super) fn measure_units(&self, evaluations: &[Evaluation]) -> Vec<f64> {
        let EvolutionSettings { environments, limits, .. } = &self.settings;
        let chunks = evaluations.chunks_exact(REFERENCE_TRIALS);
        let units = environments.iter().zip(chunks).map(|(environment, trials)| {
            let fitness = trials.iter().map(|trial| environment.fitness.of(limits, trial));
            let mean = fitness.sum::<f64>() / trials.len() as f64;
            if mean > 0.0 { mean } else { environment.fitness.at_limit(limits) }
        });
        units.collect()
    }

    /// Fitness of one episode in an environment; 1 is that of fixed-normal.
    pub(super) fn normalised(&self, environment: usize, evaluation: &Evaluation) -> f64 {
        let fitness = self.settings.environments[environment].fitness;
        fitness.of(&self.settings.limits, evaluation) / self.state.units[environment]
    }

    /// Fitness of `subjects`: the weighted mean over environments of the mean over trials.
    pub(super) fn fitness(&self, subjects: usize, evaluations: &[Evaluation]) -> Vec<f64> {
        let environments = &self.settings.environments;
        let trials = evaluations.len() / (subjects * environments.len());
        let total: f64 = environments.iter().map(|environment| environment.weight).sum();
        let of_subject = |evaluations: &[Evaluation]| {
            let chunks = evaluations.chunks_exact(trials).enumerate();
            let means = chunks.map(|(environment, trials)| {
                let sum: f64 = trials.iter().map(|it| self.normalised(environment, it)).sum();
                environments[environment].weight * sum / trials.len() as f64
            });
            means.sum::<f64>() / total
        };
        evaluations.chunks_exact(trials * environments.len()).map(of_subject).collect()
    }
}
