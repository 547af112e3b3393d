//! Evolutions of priors: what they are among the jobs of the server.

mod champion;
mod kept;
mod wire;

pub(crate) use champion::{claim, claimant};

use crate::jobs::{Gift, Record, Told, Work};
use crate::library::priors::Priors;
use crate::store::document::Form;
use crate::store::{JobId, JobKind};
use umwelt_api::PriorId;
use umwelt_lab::evolution::{
    Evaluation, Evolution, EvolutionSettings, Generation, Job, Report, STATE_VERSION, Spread,
    Stage, State,
};

impl Work for Evolution {
    const KIND: JobKind = JobKind::Evolution;
    const STATE_VERSION: u32 = STATE_VERSION;
    const FORM: &'static Form = &kept::FORM;
    type Settings = EvolutionSettings;
    type Spec = kept::Spec;
    type State = State;
    /// The name that the champion gets.
    type Own = PriorId;
    type Stage = Stage;
    /// Fitness of the last generation that has ended.
    type Latest = Spread;
    type Part = Generation;
    type Report = Report;
    type Episode = Job;
    type Evaluation = Evaluation;
    type House = Priors;

    fn spec(settings: &EvolutionSettings) -> kept::Spec {
        settings.into()
    }

    fn settings(spec: &kept::Spec) -> Result<EvolutionSettings, String> {
        spec.convert()
    }

    fn new(settings: EvolutionSettings) -> Result<Self, String> {
        Evolution::new(settings).map_err(|error| error.to_string())
    }

    fn resume(settings: EvolutionSettings, state: State) -> Result<Self, String> {
        Evolution::resume(settings, state).map_err(|error| error.to_string())
    }

    fn state(&self) -> &State {
        self.state()
    }

    fn stage(&self) -> Stage {
        self.stage()
    }

    fn episodes(&self) -> u64 {
        self.episodes()
    }

    fn total_episodes(&self) -> u64 {
        self.total_episodes()
    }

    fn report(&self) -> Option<&Report> {
        self.report()
    }

    fn hopeless(&self) -> Option<String> {
        self.hopeless().map(ToString::to_string)
    }

    fn batch(&self) -> Vec<Job> {
        self.jobs()
    }

    fn evaluate(&self, job: &Job) -> Evaluation {
        self.evaluate(job)
    }

    fn tell(&mut self, evaluations: &[Evaluation]) -> Result<Told<Self>, String> {
        let generation = self.tell(evaluations).map_err(|error| error.to_string())?;
        let latest = generation.as_ref().map(|generation| generation.fitness);
        let parts = generation.into_iter().map(|it| (it.index, it)).collect();
        Ok(Told { parts, latest })
    }

    fn gift(priors: &Priors, id: JobId, record: &Record<Self>) -> Option<Gift> {
        champion::gift(priors, id, record)
    }
}

#[cfg(test)]
mod tests;
