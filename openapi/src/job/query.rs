//! Which jobs to list.

use super::State;
use crate::check::Check;
use crate::page::{MAX_PAGE_SIZE, limits};
use crate::problem::Problems;
use serde::{Deserialize, Serialize};

/// Which jobs of a kind to list: the query of `GET /v1/evolutions` and `GET /v1/comparisons`.
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
