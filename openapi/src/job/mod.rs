//! What evolutions and comparisons have in common: both are done in the background of the server, one at a time.

use crate::check::Check;
use crate::page::{MAX_PAGE_SIZE, limits};
use crate::problem::Problems;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

// The schema has the name that it had when evolutions alone were done in the background: names are the contract's.
/// Where an evolution stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = evolution::State)]
pub enum State {
    /// It waits for its turn.
    Queued,
    /// It goes on.
    Running,
    /// There is what was asked for.
    Succeeded,
    /// It could not go on; `error` says why.
    Failed,
    /// Somebody cancelled it.
    Cancelled,
}

impl State {
    /// Every state.
    pub const ALL: [Self; 5] =
        [Self::Queued, Self::Running, Self::Succeeded, Self::Failed, Self::Cancelled];

    /// The name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// Whether it will never change again.
    pub fn has_ended(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }
}

/// Which of them to list: the query of `GET /v1/evolutions` and `GET /v1/comparisons`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PageQuery {
    /// Most of them to list; [`crate::page::DEFAULT_PAGE_SIZE`] where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page_size: Option<u64>,
    /// The `next_page_token` of the page before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page_token: Option<String>,
    /// Only those in this state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<State>,
}

impl PageQuery {
    /// The query, if every part of it is in range.
    ///
    /// # Errors
    /// Every parameter that is not.
    pub fn checked(self) -> Result<Self, Problems> {
        let mut check = Check::default();
        limits(&mut check, self.page_size, self.page_token.as_deref(), MAX_PAGE_SIZE);
        check.finish()?;
        Ok(self)
    }
}
