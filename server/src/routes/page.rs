//! Which robots to list: the query, every part of it checked at once.

use crate::failure::Failure;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use umwelt_api::RobotId;
use umwelt_api::problem::{Detail, Problems, Status, reason};
use umwelt_api::robot::{DEFAULT_PAGE_SIZE, PageQuery, State};

/// Which robots to list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Query {
    /// Most robots.
    pub(crate) size: usize,
    /// Only robots with ids above this one: the last of the page before.
    pub(crate) after: Option<RobotId>,
    /// Only robots in this state.
    pub(crate) state: Option<State>,
}

impl<S: Sync> FromRequestParts<S> for Query {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Failure> {
        // Pairs of text: what they mean is checked here, all of it, and nothing is refused before.
        let pairs = axum::extract::Query::<Vec<(String, String)>>::try_from_uri(&parts.uri);
        let axum::extract::Query(pairs) =
            pairs.map_err(|error| Failure::new(Status::InvalidArgument, error.to_string()))?;
        read(&pairs)
    }
}

fn read(pairs: &[(String, String)]) -> Result<Query, Failure> {
    let (mut query, mut after, mut wrong) = (PageQuery::default(), None, Vec::new());
    for (name, value) in pairs {
        let mut refuse = |reason: &str, remedy: &str| {
            wrong.push(Detail::new(reason, name, value.as_str(), remedy));
        };
        match name.as_str() {
            "page_size" => match value.parse() {
                Ok(size) => query.page_size = Some(size),
                Err(_) => refuse(reason::MALFORMED, "use an integer"),
            },
            "page_token" => {
                after = value.parse().ok();
                query.page_token = Some(value.clone());
                if after.is_none() {
                    refuse(reason::MALFORMED, "use next_page_token of the page before");
                }
            }
            "state" => match serde_json::from_value(value.as_str().into()) {
                Ok(state) => query.state = Some(state),
                Err(_) => refuse(reason::MALFORMED, "use never, connected or lost"),
            },
            _ => refuse(reason::UNKNOWN_FIELD, "use page_size, page_token, state"),
        }
    }
    let (size, state) = (query.page_size.unwrap_or(DEFAULT_PAGE_SIZE), query.state);
    let checked = query.checked();
    wrong.extend(checked.as_ref().err().into_iter().flat_map(Problems::details).cloned());
    if wrong.is_empty() {
        // Checked, so it fits.
        return Ok(Query { size: usize::try_from(size).unwrap_or(usize::MAX), after, state });
    }
    let message = format!("{} parts of the query are wrong", wrong.len());
    let failure = Failure::new(Status::InvalidArgument, message);
    Err(wrong.into_iter().fold(failure, Failure::with))
}
