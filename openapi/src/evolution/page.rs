//! Lists of evolutions and of generations.

use super::{Evolution, Generation};
use crate::page::Unreadable;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Most generations of one page: all that there can be, with many environments some megabytes.
pub const MAX_GENERATIONS_SIZE: u64 = 1000;

/// Generations of a page where nothing is said.
pub const DEFAULT_GENERATIONS_SIZE: u64 = 1000;

/// Some of the evolutions, the newest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = EvolutionPage)]
pub struct Page {
    /// The evolutions.
    pub evolutions: Vec<Evolution>,
    /// Those that cannot be read, in the same part of the list; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unreadable: Vec<Unreadable>,
    /// Where the next page begins; null on the last one.
    pub next_page_token: Option<String>,
}

/// Some of the generations of an evolution, in their order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GenerationsPage)]
pub struct GenerationsPage {
    /// The generations.
    pub generations: Vec<Generation>,
    /// Where the next page begins; null where there is none yet.
    pub next_page_token: Option<String>,
}
