//! Lists of comparisons.

use super::Comparison;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Some of the comparisons, the newest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = comparison::Page)]
pub struct Page {
    /// The comparisons, each without its report.
    pub comparisons: Vec<Comparison>,
    /// Where the next page begins; null on the last one.
    pub next_page_token: Option<String>,
}
