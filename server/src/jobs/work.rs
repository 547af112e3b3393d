//! What tells one kind of job from another.

use super::record::Record;
use crate::store::document::Form;
use crate::store::{Change, JobId, JobKind};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// Something that is kept as JSON and shown to many.
pub(crate) trait Plain:
    Clone + Debug + PartialEq + Serialize + DeserializeOwned + Send + Sync + 'static
{
}

impl<T: Clone + Debug + PartialEq + Serialize + DeserializeOwned + Send + Sync + 'static> Plain
    for T
{
}

/// A state machine that asks for batches of simulated episodes until there is a report, or a reason
/// why there will be none. Between two batches its whole
/// state can be written down and taken up again: what comes of it is the same, bit for bit, whoever drives the episodes.
pub(crate) trait Work: Clone + Debug + PartialEq + Send + Sync + 'static {
    /// Its kind.
    const KIND: JobKind;
    /// Version of its state: a state of another one is not taken up.
    const STATE_VERSION: u32;
    /// How its record is kept: what leads to today's form, and what missing settings mean.
    const FORM: &'static Form;
    /// What it is told.
    type Settings: Clone + Debug + PartialEq + Send + Sync + 'static;
    /// The same as it is kept: specs of the wire, and what names stood for when they were given.
    type Spec: Plain;
    /// How far it has got, as it is kept; its version stands in its field `version`.
    type State: Plain;
    /// What is its own beside that: names that the server gives a meaning.
    type Own: Plain;
    /// How far it has got.
    type Stage: Plain + Copy;
    /// What is shown of the batches so far beyond the stage.
    type Latest: Plain + Copy;
    /// What is kept for good of a batch, beside the report.
    type Part: Plain;
    /// What comes of it.
    type Report: Plain;
    /// One episode to drive.
    type Episode: Send + Sync;
    /// What came of one episode.
    type Evaluation: Send + Sync;
    /// The part of the server that gets what a success gives.
    type House: Send + Sync + 'static;

    /// Settings as they are kept.
    fn spec(settings: &Self::Settings) -> Self::Spec;

    /// The settings that are kept.
    ///
    /// # Errors
    /// What in them means nothing.
    fn settings(spec: &Self::Spec) -> Result<Self::Settings, String>;

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

    /// How far it has got, as it is kept.
    fn state(&self) -> &Self::State;

    /// How far it has got.
    fn stage(&self) -> Self::Stage;

    /// Episodes driven so far.
    fn episodes(&self) -> u64;

    /// Episodes that the whole of it takes.
    fn total_episodes(&self) -> u64;

    /// What came of it, once it is done.
    fn report(&self) -> Option<&Self::Report>;

    /// Why it ends without a report, where it does: for people, with a remedy.
    fn hopeless(&self) -> Option<String> {
        None
    }

    /// What is to be driven now.
    fn batch(&self) -> Vec<Self::Episode>;

    /// Drives one episode of the batch, on any thread.
    fn evaluate(&self, episode: &Self::Episode) -> Self::Evaluation;

    /// Takes in the evaluations of the batch, in its order, and goes on.
    ///
    /// # Errors
    /// Where they are not those of the batch; nothing has happened then.
    fn tell(&mut self, evaluations: &[Self::Evaluation]) -> Result<Told<Self>, String>;

    /// What a success gives beside its report, which stands in the record.
    fn gift(_house: &Self::House, _id: JobId, _record: &Record<Self>) -> Option<Gift> {
        None
    }
}

/// What came of a batch.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Told<W: Work> {
    /// What is kept of it, with its index.
    pub(crate) parts: Vec<(usize, W::Part)>,
    /// What is shown from now on; none where that stays.
    pub(crate) latest: Option<W::Latest>,
}

/// What a success gives to the rest of the server.
pub(crate) struct Gift {
    /// Kept in the same commit as the success.
    pub(crate) change: Change,
    /// Called once it is kept, before the success shows.
    pub(crate) show: Box<dyn Fn() + Send + Sync>,
}
