//! What one asks of an evolution.

use super::spec::{self, Optimizer, Preset};
use crate::body;
use crate::check::{Check, Validate};
use crate::checked::Checked;
use crate::problem::{Problems, reason};
use crate::robot::MAX_INTEGER;
use crate::robot::MAX_SLOTS;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// What is asked of an evolution. Everything may be left out and then comes from the preset.
///
/// ```
/// use umwelt_api::evolution::Request;
/// let request = Request::read(br#"{"preset": "quick", "environments": ["normal"], "seed": 7}"#)?;
/// assert_eq!(request.seed, Some(7));
///
/// let problems = Request::read(br#"{"population": 1, "seeds": 7, "trials": 500}"#).unwrap_err();
/// let fields: Vec<_> = problems.details().iter().map(|detail| detail.field.as_str()).collect();
/// assert_eq!(fields, ["seeds", "population", "trials"]);
/// # Ok::<(), umwelt_api::Problems>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = EvolutionRequest)]
pub struct Request {
    /// Where the rest comes from; null for `default`.
    pub preset: Option<Preset>,
    /// Names of simulated environments, each once.
    pub environments: Option<Vec<String>>,
    /// How the prior is searched for.
    pub optimizer: Option<Optimizer>,
    /// Individuals of a generation.
    pub population: Option<u64>,
    /// Generations. Population, generations, trials and environments multiply to at most 20 million episodes.
    pub generations: Option<u64>,
    /// Trials of each individual in each environment.
    pub trials: Option<u64>,
    /// Fresh trials in each environment of each of those from whom the champion is chosen.
    pub selection_trials: Option<u64>,
    /// Fresh trials in each environment on which the champion is reported.
    pub report_trials: Option<u64>,
    /// Of everything random: the same seed gives the same champion.
    pub seed: Option<u64>,
    /// Probability that two parents are crossed; the three probabilities sum to one.
    pub crossover_probability: Option<f64>,
    /// Probability that an individual is copied.
    pub reproduction_probability: Option<f64>,
    /// Probability that one is drawn anew.
    pub mutation_probability: Option<f64>,
    /// How far beyond their parents children may lie; 0 for not at all.
    pub expansion: Option<f64>,
    /// The fittest that go on as they are; fewer than the population.
    pub elites: Option<u64>,
    /// Deviation beyond which an individual has no fitness in a normal environment.
    pub max_deviation_m: Option<f64>,
    /// Time beyond which an individual has no fitness in a bad environment.
    pub max_time_s: Option<f64>,
    /// Slots of 30 ms per horizon; 1 is the thesis.
    pub horizon_slots: Option<u64>,
    /// The name that the champion is to have as a prior; null for the evolution's own id.
    pub prior: Option<String>,
}

impl Validate for Request {
    /// What is left out is in range: it comes from a preset.
    fn check(&self, check: &mut Check) {
        self.check_environments(check);
        for (name, value, range) in [
            ("population", self.population, spec::POPULATION),
            ("generations", self.generations, spec::GENERATIONS),
            ("trials", self.trials, spec::TRIALS),
            ("selection_trials", self.selection_trials, spec::SELECTION_TRIALS),
            ("report_trials", self.report_trials, spec::REPORT_TRIALS),
            ("seed", self.seed, 0..=MAX_INTEGER),
            ("elites", self.elites, 0..=spec::POPULATION.end() - 1),
            ("horizon_slots", self.horizon_slots, 1..=MAX_SLOTS as u64),
        ] {
            check.integer(name, value.unwrap_or(*range.start()), range);
        }
        for (name, value, range) in [
            ("crossover_probability", self.crossover_probability, spec::PROBABILITY),
            ("reproduction_probability", self.reproduction_probability, spec::PROBABILITY),
            ("mutation_probability", self.mutation_probability, spec::PROBABILITY),
            ("expansion", self.expansion, spec::EXPANSION),
            ("max_deviation_m", self.max_deviation_m, spec::MAX_DEVIATION),
            ("max_time_s", self.max_time_s, spec::MAX_TIME),
        ] {
            check.number(name, value.unwrap_or(range.min), range);
        }
        if let Some(prior) = &self.prior {
            check.new_id("prior", prior);
        }
    }
}

impl Request {
    /// Reads the body of a POST; neither what the preset adds nor which environments there are is asked.
    ///
    /// # Errors
    /// Every problem of it: unknown fields, values out of range, names that are none or stand twice.
    pub fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        body::read_shared(json)
    }

    fn check_environments(&self, check: &mut Check) {
        let names = self.environments.as_deref();
        let count = names.map_or(*spec::ENVIRONMENTS.start(), <[String]>::len);
        check.length("environments", count, spec::ENVIRONMENTS);
        check.each_once("environments");
        for (index, name) in names.unwrap_or_default().iter().enumerate() {
            let field = format!("environments[{index}]");
            check.id(&field, name);
            if names.unwrap_or_default()[..index].contains(name) {
                check.report(reason::REPEATED, &field, name.as_str(), "name it once");
            }
        }
    }
}
