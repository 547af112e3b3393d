//! What all kinds of jobs have in common: batches of simulated episodes, evaluated one after the other.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// Something that is kept as JSON and shown to many.
pub trait Plain:
    Clone + Debug + PartialEq + Serialize + DeserializeOwned + Send + Sync + 'static
{
}

impl<T: Clone + Debug + PartialEq + Serialize + DeserializeOwned + Send + Sync + 'static> Plain
    for T
{
}

/// A state machine that asks for batches of simulated episodes until there is a report, or a reason why there will be
/// none. Between two batches its whole state can be written down and taken up again: the report is the same, bit for
/// bit, whoever evaluates the episodes.
pub trait Work: Clone + Debug + PartialEq + Send + Sync + 'static {
    /// Version of its state: a state of another one is not taken up.
    const STATE_VERSION: u32;
    /// What is asked for.
    type Settings: Clone + Debug + PartialEq + Send + Sync + 'static;
    /// How far it has got, as it is kept; its version stands in its field `version`.
    type State: Plain;
    /// How far it has got.
    type Stage: Plain + Copy;
    /// What is shown of the batches so far beyond the stage.
    type Latest: Plain + Copy;
    /// What is kept for good of a batch, beside the report.
    type Part: Plain;
    /// Its final result.
    type Report: Plain;
    /// One episode to drive: with the settings all that it takes, so that another process can drive it.
    type Episode: Plain;
    /// What is measured in one episode.
    type Evaluation: Plain;

    /// One that has not begun.
    ///
    /// # Errors
    /// What is wrong with the settings.
    fn new(settings: Self::Settings) -> Result<Self, String>;

    /// One that goes on where another one of these settings was.
    ///
    /// # Errors
    /// What is wrong with the settings.
    fn resume(settings: Self::Settings, state: Self::State) -> Result<Self, String>;

    /// What was asked for.
    fn settings(&self) -> &Self::Settings;

    /// How far it has got, as it is kept.
    fn state(&self) -> &Self::State;

    /// How far it has got.
    fn stage(&self) -> Self::Stage;

    /// Episodes driven so far.
    fn episodes(&self) -> u64;

    /// Episodes that the whole of it takes.
    fn total_episodes(&self) -> u64;

    /// Its final result, once it is done.
    fn report(&self) -> Option<&Self::Report>;

    /// Why it ends without a report, where it does: for people, with a remedy.
    fn failure(&self) -> Option<String> {
        None
    }

    /// What is to be driven now.
    fn batch(&self) -> Vec<Self::Episode>;

    /// Drives one episode of work of these settings. The same episode gives the same evaluation, bit for bit, on any
    /// thread and in any process.
    fn evaluate(settings: &Self::Settings, episode: &Self::Episode) -> Self::Evaluation;

    /// Takes in the evaluations of the batch, in its order, and goes on.
    ///
    /// # Errors
    /// Where they are not those of the batch; nothing has happened then.
    fn tell(&mut self, evaluations: &[Self::Evaluation]) -> Result<BatchOutcome<Self>, String>;
}

/// What a batch leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct BatchOutcome<W: Work> {
    /// What is kept of it, with its index.
    pub parts: Vec<(usize, W::Part)>,
    /// What is shown from now on; none where that stays.
    pub latest: Option<W::Latest>,
}
