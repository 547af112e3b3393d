//! Lists of generations.

use super::Generation;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Most generations of one page: all that there can be, with many environments some megabytes.
pub const MAX_GENERATIONS_SIZE: u64 = 1000;

/// Generations of a page where nothing is said.
pub const DEFAULT_GENERATIONS_SIZE: u64 = 1000;

/// Some of the generations of an evolution, in their order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GenerationsPage)]
pub struct GenerationsPage {
    /// The generations.
    pub generations: Vec<Generation>,
    /// Where the next page begins; null where there is none yet.
    pub next_page_token: Option<String>,
}
