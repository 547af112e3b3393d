//! An evolution as work: a generation is a batch.

use super::{
    Episode, Evaluation, Evolution, EvolutionSettings, Generation, Report, STATE_VERSION, Spread,
    Stage, State,
};
use crate::work::{BatchOutcome, Work};

impl Work for Evolution {
    const STATE_VERSION: u32 = STATE_VERSION;
    type Settings = EvolutionSettings;
    type State = State;
    type Stage = Stage;
    /// Fitness of the last generation that has ended.
    type Latest = Spread;
    type Part = Generation;
    type Report = Report;
    type Episode = Episode;
    type Evaluation = Evaluation;

    fn new(settings: EvolutionSettings) -> Result<Self, String> {
        Evolution::new(settings).map_err(|error| error.to_string())
    }

    fn resume(settings: EvolutionSettings, state: State) -> Result<Self, String> {
        Evolution::resume(settings, state).map_err(|error| error.to_string())
    }

    fn settings(&self) -> &EvolutionSettings {
        self.settings()
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

    fn failure(&self) -> Option<String> {
        self.failure().map(ToString::to_string)
    }

    fn batch(&self) -> Vec<Episode> {
        self.batch()
    }

    fn evaluate(settings: &EvolutionSettings, episode: &Episode) -> Evaluation {
        Self::evaluate(settings, episode)
    }

    fn tell(&mut self, evaluations: &[Evaluation]) -> Result<BatchOutcome<Self>, String> {
        let generation = self.tell(evaluations).map_err(|error| error.to_string())?;
        let latest = generation.as_ref().map(|generation| generation.fitness);
        let parts = generation.into_iter().map(|it| (it.index, it)).collect();
        Ok(BatchOutcome { parts, latest })
    }
}
