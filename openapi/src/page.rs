//! Lists come in pages.

use crate::check::Check;
use crate::problem::Problems;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// Most items of one page of priors, evolutions or comparisons: some megabytes where each has a champion.
pub const MAX_PAGE_SIZE: u64 = 500;

/// Items of a page where nothing is said.
pub const DEFAULT_PAGE_SIZE: u64 = 50;

/// Longest page token: it holds an id or a number and little else.
pub const MAX_PAGE_TOKEN: usize = 128;

/// A page token that is the last id of the page before.
pub(crate) const ID_TOKEN: &str = "^[a-z0-9-]{1,63}$";

/// A page token that is the last number of the page before.
pub(crate) const NUMBER_TOKEN: &str = "^[0-9]{1,19}$";

/// Which part of a list to show: the query of `GET /v1/priors`, `/v1/environments` and
/// `/v1/evolutions/{evolution}/generations`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PageQuery {
    /// Most items to list.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page_size: Option<u64>,
    /// The `next_page_token` of the page before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page_token: Option<String>,
}

impl PageQuery {
    /// The query, if every part of it is in range; `max_page_size` is that of the list.
    ///
    /// # Errors
    /// Every parameter that is not.
    pub fn checked(self, max_page_size: u64) -> Result<Self, Problems> {
        let mut check = Check::default();
        limits(&mut check, self.page_size, self.page_token.as_deref(), max_page_size);
        check.finish()?;
        Ok(self)
    }
}

/// Something of a list that the server keeps and cannot read: a newer version of it has written it. It stays as it is until
/// it is removed or another is put in its place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Unreadable)]
pub struct Unreadable {
    /// Its name or id.
    pub name: String,
    /// Version of the server that wrote it; null where that is not known.
    pub written_by: Option<String>,
    /// Why it cannot be read.
    pub why: String,
    /// What to do about it.
    pub remedy: String,
}

/// Checks what every query of a list has.
pub(crate) fn limits(check: &mut Check, size: Option<u64>, token: Option<&str>, max: u64) {
    check.integer("page_size", size.unwrap_or(1), 1..=max);
    check.length("page_token", token.map_or(0, str::len), 0..=MAX_PAGE_TOKEN);
}
