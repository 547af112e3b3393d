//! What tells one kind of job from another.

use super::State;
use crate::body::{Body, Wired};
use crate::id::InvalidId;
use crate::page::MAX_PAGE_SIZE;
use std::fmt::{Debug, Display};
use std::str::FromStr;

/// A part of a job on the wire.
pub trait Wire: Wired + Clone + Debug + PartialEq + Send + Sync + 'static {}

impl<T: Wired + Clone + Debug + PartialEq + Send + Sync + 'static> Wire for T {}

/// A kind of job as the wire has it.
pub trait JobKind: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Its name: the field that holds an id, and the begin of each id.
    const NAME: &'static str;
    /// The field that holds a list, and the path of all jobs of the kind below `/v1`.
    const LIST: &'static str;
    /// How the contract describes it.
    const DESCRIPTION: JobDescription;
    /// Jobs of a page that a client asks for, where it wants all of them.
    const PAGE_SIZE: u64 = MAX_PAGE_SIZE;
    /// What names a job.
    type Id: Wire + Eq + Display + AsRef<str> + FromStr<Err = InvalidId>;
    /// What one sends to submit a job.
    type Request: Wire + Body;
    /// What was asked for, all filled in.
    type Spec: Wire;
    /// How far a job has got.
    type Progress: Wire + Copy;
    /// What a job ends with: an object whose fields stand beside those of all jobs.
    type Outcome: Wire;
    /// What happens to a job.
    type News: JobNews<Self::Progress>;

    /// The id of the job of this number.
    fn id(number: u64) -> Self::Id;

    /// The id of the event of a job that has got so far: never decreasing, the same after a restart.
    fn event_id(progress: &Self::Progress) -> u64;

    /// Simulated episodes driven, and in all.
    fn episodes(progress: &Self::Progress) -> (u64, u64);
}

/// What happens to a job; one of it is its state.
pub trait JobNews<P>: Wire {
    /// Where a job stands, and how far it has got.
    fn of_state(state: State, progress: P, error: Option<String>) -> Self;

    /// The same, where it is that.
    fn state(&self) -> Option<(State, &P)>;

    /// The value of `type`, and of `event:` in the stream; `other` for something of a later version.
    fn name(&self) -> &'static str;
}

/// How the contract describes a kind: names of schemas, and words.
#[derive(Clone, Copy, Debug)]
pub struct JobDescription {
    /// The name of the schema of a job.
    pub job: &'static str,
    /// That of a page.
    pub page: &'static str,
    /// That of an event.
    pub event: &'static str,
    /// One job, as `an evolution`.
    pub one: &'static str,
    /// What a list shows of them, as `The evolutions.`
    pub listed: &'static str,
    /// What the id of an event is.
    pub event_id: &'static str,
}
