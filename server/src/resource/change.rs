//! A change of a resource: run to its end, and what it did.

use super::failure::{self, Failure};
use std::pin::Pin;

/// What a PUT did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Put {
    /// There was nothing before.
    Created,
    /// It took the place of another.
    Replaced,
}

/// Runs a change to its end even if the caller goes away: half a change would part the robot from the store.
pub(crate) async fn to_the_end<T: Send + 'static>(
    change: impl Future<Output = Result<T, Failure>> + Send + 'static,
) -> Result<T, Failure> {
    // A task of each kind of change would be compiled for each: see docs/building.md.
    let change: Pin<Box<dyn Future<Output = _> + Send>> = Box::pin(change);
    tokio::spawn(change).await.unwrap_or_else(|error| Err(failure::broken(&error)))
}
