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
pub(crate) const ID_TOKEN: &str = "^[A-Za-z0-9-][A-Za-z0-9._-]{0,62}$";

/// A page token that is the last number of the page before.
pub(crate) const NUMBER_TOKEN: &str = "^[0-9]{1,19}$";

/// The state of what has none: its list cannot be narrowed down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Stateless {}

/// Which part of a list to show: the query of `GET /v1/priors`, say. Of robots and jobs, those in one state.
///
/// ```
/// use umwelt_api::page::{MAX_PAGE_SIZE, PageQuery};
/// let query: PageQuery = PageQuery { page_size: Some(501), ..PageQuery::default() };
/// let problems = query.checked(MAX_PAGE_SIZE).err().unwrap();
/// assert_eq!(problems.details()[0].remedy, "use an integer from 1 to 500");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PageQuery<S = Stateless> {
    /// Most items to list; the default of the list where nothing is said.
    pub page_size: Option<u64>,
    /// The `next_page_token` of the page before.
    pub page_token: Option<String>,
    /// Only those in this state.
    pub state: Option<S>,
}

impl<S> Default for PageQuery<S> {
    /// The first page, of the default size, whatever the state.
    fn default() -> Self {
        Self { page_size: None, page_token: None, state: None }
    }
}

impl<S> PageQuery<S> {
    /// The query, if every part of it is in range; `max_page_size` is that of the list.
    ///
    /// # Errors
    /// Every parameter that is not.
    pub fn checked(self, max_page_size: u64) -> Result<Self, Problems> {
        let mut check = Check::default();
        check.integer("page_size", self.page_size.unwrap_or(1), 1..=max_page_size);
        let token = self.page_token.as_deref().map_or(0, str::len);
        check.length("page_token", token, 0..=MAX_PAGE_TOKEN);
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
