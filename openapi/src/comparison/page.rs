//! Lists of comparisons.

use super::Comparison;
use crate::page::Unreadable;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Some of the comparisons, the newest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ComparisonPage)]
pub struct Page {
    /// The comparisons, each without its report.
    pub comparisons: Vec<Comparison>,
    /// Those that cannot be read, in the same part of the list; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unreadable: Vec<Unreadable>,
    /// Where the next page begins; null on the last one.
    pub next_page_token: Option<String>,
}
