//! What the optimiser knows between two generations.

use super::cma_es::CmaEs;
use super::genetic;
use super::genome::{self, Genome};
use super::settings::{EvolutionSettings, Optimizer};
use crate::seeds::{self, Purpose};
use serde::{Deserialize, Serialize};
use umwelt_core::settings::Prior;

/// What the optimiser knows between two generations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Search {
    Genetic {
        population: Vec<Genome>,
    },
    CmaEs {
        search: CmaEs,
        population: Vec<Genome>,
    },
    /// One individual, which has the trials of a whole population.
    EmpiricalBayes {
        fitted: [Genome; 1],
    },
}

impl Search {
    /// The search before the first generation.
    pub(super) fn new(settings: &EvolutionSettings) -> Self {
        let drift = settings.controller.drift;
        let genes = genome::prior_genes(drift);
        let mut rng = seeds::rng(settings.seed, Purpose::Populate, 0);
        let weak = genome::of_prior(&Prior::default(), drift);
        match settings.optimizer {
            Optimizer::Genetic => {
                let population = genetic::populate(&genes, settings.population, &mut rng);
                Self::Genetic { population }
            }
            Optimizer::CmaEs => {
                let search = CmaEs::new(&genes, &weak);
                let population = search.ask(&genes, settings.population, &mut rng);
                Self::CmaEs { search, population }
            }
            Optimizer::EmpiricalBayes => Self::EmpiricalBayes { fitted: [weak] },
        }
    }

    /// Those of the generation.
    pub(super) fn individuals(&self) -> &[Genome] {
        match self {
            Self::Genetic { population } | Self::CmaEs { population, .. } => population,
            Self::EmpiricalBayes { fitted } => fitted,
        }
    }
}
