//! A kind of job as HTTP has it.

use crate::http::app::App;
use crate::jobs::{Job, Jobs, OnWire, Shown};
use crate::resource::failure::Failure;
use tokio::sync::OwnedRwLockWriteGuard;
use umwelt_api::Checked;
use umwelt_api::Problems;
use umwelt_api::job::{JobEvent, JobKind};

/// What one sends to submit a job.
pub(crate) type Asked<W> = <<W as OnWire>::Kind as JobKind>::Request;

/// A kind of job as HTTP has it: how one is submitted, and what its event stream has.
pub(crate) trait Resource: OnWire {
    /// Whether a state has an id in the event stream. One that has would be resumed behind it.
    const STATES_HAVE_IDS: bool = true;

    /// Held while a job is submitted, so that the names that it takes stay free.
    fn names(_app: &App) -> impl Future<Output = Option<OwnedRwLockWriteGuard<()>>> + Send {
        std::future::ready(None)
    }

    /// Reads the body of a request where it is known what names stand for: the request, and what is to be run.
    ///
    /// # Errors
    /// Every problem of it.
    fn read(app: &App, body: &[u8]) -> Result<(Checked<Asked<Self>>, Self::Settings), Problems>;

    /// A number from `next` on for a new job, and what is its own.
    ///
    /// # Errors
    /// Where a name that it is to have is taken.
    fn own(
        app: &App,
        jobs: &Jobs<Self>,
        request: &Asked<Self>,
        next: u64,
    ) -> Result<(u64, Self::Own), Failure>;

    /// Events that a stream has before the state, behind the one of the id `last`; none where they cannot be had.
    fn events_after(
        _app: &App,
        _job: &Job<Self>,
        _shown: &Shown<Self>,
        _last: u64,
    ) -> impl Future<Output = Option<Vec<JobEvent<Self::Kind>>>> + Send {
        std::future::ready(Some(Vec::new()))
    }
}
