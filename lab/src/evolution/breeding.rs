//! The end of a generation, and the next one.

use super::episode::Evaluation;
use super::generation::{self, Generation};
use super::genome::{self, Genome};
use super::search::Search;
use super::state::Stage;
use super::{CANDIDATES, Evolution, empirical_bayes, genetic};
use crate::seeds::{self, Purpose};

impl Evolution {
    /// Takes in a generation, breeds the next one, and gives its results.
    pub(super) fn end_generation(
        &mut self,
        generation: usize,
        evaluations: &[Evaluation],
    ) -> Generation {
        let drift = self.settings.controller.drift;
        let genes = genome::prior_genes(drift);
        let individuals = self.state.search.individuals();
        let fitness = self.fitness(individuals.len(), evaluations);
        let environments = &self.settings.environments;
        let summary =
            generation::summary(generation, environments, individuals, &fitness, evaluations);
        let order = genetic::ranking(&fitness);
        if generation == 0 {
            self.state.first_generation = Some(individuals[order[0]].clone());
        }
        let is_last = generation + 1 == self.settings.generations;
        let mut rng = seeds::rng(self.settings.seed, Purpose::Breed, generation);
        let mut candidates: Vec<Genome> = Vec::new();
        for index in order {
            let individual = &individuals[index];
            if candidates.len() < CANDIDATES && !candidates.contains(individual) {
                candidates.push(individual.clone());
            }
        }
        match &mut self.state.search {
            Search::Genetic { population } if !is_last => {
                let settings = &self.settings.genetic;
                *population = genetic::breed(&genes, settings, population, &fitness, &mut rng);
            }
            Search::Genetic { .. } => {}
            Search::CmaEs { search, population } => {
                search.tell(&genes, population, &fitness);
                candidates.push(search.mean(&genes));
                if !is_last {
                    *population = search.ask(&genes, population.len(), &mut rng);
                }
            }
            Search::EmpiricalBayes { fitted: [fitted] } => {
                let groups: Vec<_> = evaluations.iter().map(|it| it.samples).collect();
                let seed = seeds::seed(self.settings.seed, Purpose::Breed, [generation, 0, 0]);
                *fitted = empirical_bayes::fit(&groups, fitted, seed);
                candidates = vec![fitted.clone()];
            }
        }
        self.state.stage = Stage::Generations { generation: generation + 1 };
        if is_last {
            self.state.candidates = candidates;
            self.state.stage = match &self.state.candidates[..] {
                [only] => {
                    self.state.champion = Some(only.clone());
                    Stage::Report
                }
                _ => Stage::Selection,
            };
        }
        summary
    }
}
