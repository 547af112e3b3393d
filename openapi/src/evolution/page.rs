//! Lists of evolutions and of generations.

use super::{Evolution, Generation, State};
use crate::check::Check;
use crate::page::{MAX_PAGE_SIZE, limits};
use crate::problem::Problems;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Most generations of one page: all that there can be, with many environments some megabytes.
pub const MAX_GENERATIONS_SIZE: u64 = 1000;

/// Generations of a page where nothing is said.
pub const DEFAULT_GENERATIONS_SIZE: u64 = 1000;

/// Some of the evolutions, the newest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = evolution::Page)]
pub struct Page {
    /// The evolutions.
    pub evolutions: Vec<Evolution>,
    /// Where the next page begins; null on the last one.
    pub next_page_token: Option<String>,
}

/// Some of the generations of an evolution, in their order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = evolution::GenerationsPage)]
pub struct GenerationsPage {
    /// The generations.
    pub generations: Vec<Generation>,
    /// Where the next page begins; null where there is none yet.
    pub next_page_token: Option<String>,
}

/// Which evolutions to list: the query of `GET /v1/evolutions`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PageQuery {
    /// Most evolutions to list; [`crate::page::DEFAULT_PAGE_SIZE`] where nothing is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page_size: Option<u64>,
    /// The `next_page_token` of the page before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page_token: Option<String>,
    /// Only evolutions in this state.
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
