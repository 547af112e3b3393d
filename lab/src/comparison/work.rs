//! A comparison as work: a batch is one or several trials of every contender in every environment.

use super::{
    Comparison, ComparisonSettings, Distribution, Episode, Evaluation, Report, STATE_VERSION,
    Stage, State,
};
use crate::work::{BatchOutcome, Work};

impl Work for Comparison {
    const STATE_VERSION: u32 = STATE_VERSION;
    type Settings = ComparisonSettings;
    type State = State;
    type Stage = Stage;
    type Latest = ();
    /// All trials of a contender in an environment. They are kept at the end: until then the checkpoint holds them.
    type Part = Distribution;
    type Report = Report;
    type Episode = Episode;
    type Evaluation = Evaluation;

    fn new(settings: ComparisonSettings) -> Result<Self, String> {
        Comparison::new(settings).map_err(|error| error.to_string())
    }

    fn resume(settings: ComparisonSettings, state: State) -> Result<Self, String> {
        Comparison::resume(settings, state).map_err(|error| error.to_string())
    }

    fn settings(&self) -> &ComparisonSettings {
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

    fn batch(&self) -> Vec<Episode> {
        self.batch()
    }

    fn evaluate(settings: &ComparisonSettings, episode: &Episode) -> Evaluation {
        Self::evaluate(settings, episode)
    }

    fn tell(&mut self, evaluations: &[Evaluation]) -> Result<BatchOutcome<Self>, String> {
        self.tell(evaluations).map_err(|error| error.to_string())?;
        let is_done = self.report().is_some();
        let parts = if is_done { self.distributions() } else { Vec::new() };
        Ok(BatchOutcome { parts: parts.into_iter().enumerate().collect(), latest: None })
    }
}
