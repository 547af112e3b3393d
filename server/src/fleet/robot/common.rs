//! What the robots of a server have in common.

use super::workers::Workers;
use crate::fleet::feed::Feed;
use crate::library::priors::Priors;
use std::time::Duration;

/// What the robots of a server have in common; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Common {
    /// Silence after which one counts as lost.
    pub(crate) lost_after: Duration,
    /// Where they say what happens.
    pub(crate) feed: Feed,
    /// What the names of their priors mean.
    pub(crate) priors: Priors,
    /// Where they compute.
    pub(crate) workers: Workers,
}
