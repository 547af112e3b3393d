//! Which part of a list to show: the query, every part of it checked at once.

use crate::resource::failure::Failure;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use serde::de::DeserializeOwned;
use std::marker::PhantomData;
use std::str::FromStr;
use umwelt_api::page::{DEFAULT_PAGE_SIZE, MAX_PAGE_SIZE, PageQuery, Stateless};
use umwelt_api::problem::{Detail, Problems, Status, reason};
use umwelt_api::{EnvironmentId, PriorId, RobotId, evolution, robot, training};

/// Something that is listed in pages.
pub(crate) trait Listed {
    /// What a page token holds: the last of the page before.
    type Token: FromStr + Send;
    /// What the list can be narrowed down to.
    type State: DeserializeOwned + Send;
    /// The states; none where the list cannot be narrowed down.
    const STATES: Option<&'static str> = None;
    /// Most items of a page.
    const MAX_SIZE: u64 = MAX_PAGE_SIZE;
    /// Items of a page where nothing is said.
    const DEFAULT_SIZE: u64 = DEFAULT_PAGE_SIZE;
}

/// Robots, in the order of their ids.
pub(crate) struct Robots;

impl Listed for Robots {
    type Token = RobotId;
    type State = robot::State;
    const STATES: Option<&'static str> = Some("never, connected or lost");
    const MAX_SIZE: u64 = robot::MAX_PAGE_SIZE;
    const DEFAULT_SIZE: u64 = robot::DEFAULT_PAGE_SIZE;
}

/// Priors, in the order of their names.
pub(crate) struct Priors;

impl Listed for Priors {
    type Token = PriorId;
    type State = Stateless;
}

/// Simulated environments, in the order of their names.
pub(crate) struct Environments;

impl Listed for Environments {
    type Token = EnvironmentId;
    type State = Stateless;
    const MAX_SIZE: u64 = training::MAX_PAGE_SIZE;
}

/// Jobs of a kind by their numbers, the newest first.
pub(crate) struct Jobs<W>(PhantomData<W>);

impl<W> Listed for Jobs<W> {
    type Token = u64;
    type State = evolution::State;
    const STATES: Option<&'static str> = Some("queued, running, succeeded, failed or cancelled");
}

/// Generations by their numbers.
pub(crate) struct Generations;

impl Listed for Generations {
    type Token = usize;
    type State = Stateless;
    const MAX_SIZE: u64 = evolution::MAX_GENERATIONS_SIZE;
    const DEFAULT_SIZE: u64 = evolution::DEFAULT_GENERATIONS_SIZE;
}

/// Which part of a list to show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Query<L: Listed> {
    /// Most items.
    pub(crate) size: usize,
    /// Only items behind this one: the last of the page before.
    pub(crate) after: Option<L::Token>,
    /// Only items in this state.
    pub(crate) state: Option<L::State>,
}

impl<L: Listed, S: Sync> FromRequestParts<S> for Query<L> {
    type Rejection = Failure;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Failure> {
        // Pairs of text: what they mean is checked here, all of it, and nothing is refused before.
        let pairs = axum::extract::Query::<Vec<(String, String)>>::try_from_uri(&parts.uri);
        let axum::extract::Query(pairs) =
            pairs.map_err(|error| Failure::new(Status::InvalidArgument, error.to_string()))?;
        read(&pairs)
    }
}

fn read<L: Listed>(pairs: &[(String, String)]) -> Result<Query<L>, Failure> {
    let (mut query, mut after) = (PageQuery::default(), None);
    let mut wrong = Vec::new();
    for (name, value) in pairs {
        let mut refuse = |reason: &str, remedy: &str| {
            wrong.push(Detail::new(reason, name, value.as_str(), remedy));
        };
        match (name.as_str(), L::STATES) {
            ("page_size", _) => match value.parse() {
                Ok(size) => query.page_size = Some(size),
                Err(_) => refuse(reason::MALFORMED, "use an integer"),
            },
            ("page_token", _) => {
                after = value.parse().ok();
                query.page_token = Some(value.clone());
                if after.is_none() {
                    refuse(reason::MALFORMED, "use next_page_token of the page before");
                }
            }
            ("state", Some(states)) => match serde_json::from_value(value.as_str().into()) {
                Ok(given) => query.state = Some(given),
                Err(_) => refuse(reason::MALFORMED, &format!("use {states}")),
            },
            (_, Some(_)) => refuse(reason::UNKNOWN_FIELD, "use page_size, page_token, state"),
            (_, None) => refuse(reason::UNKNOWN_FIELD, "use page_size, page_token"),
        }
    }
    match query.checked(L::MAX_SIZE) {
        Ok(PageQuery { page_size, state, .. }) if wrong.is_empty() => {
            // Checked, so it fits.
            let size = usize::try_from(page_size.unwrap_or(L::DEFAULT_SIZE)).unwrap_or(usize::MAX);
            return Ok(Query { size, after, state });
        }
        checked => wrong.extend(checked.err().iter().flat_map(Problems::details).cloned()),
    }
    let message = format!("{} parts of the query are wrong", wrong.len());
    let failure = Failure::new(Status::InvalidArgument, message);
    Err(wrong.into_iter().fold(failure, Failure::with))
}

/// Whether a name is in the part of a list behind `after` and up to `last`, the end where that is none.
pub(crate) fn holds<'a>(
    after: Option<&'a str>,
    last: Option<&'a str>,
) -> impl Fn(&str) -> bool + 'a {
    move |name| after.is_none_or(|after| name > after) && last.is_none_or(|last| name <= last)
}

/// The first `size` of `items` and the token of the last of them, where there are more behind it.
pub(crate) fn cut<T>(
    mut items: Vec<T>,
    size: usize,
    token: impl Fn(&T) -> String,
) -> (Vec<T>, Option<String>) {
    let is_last = items.len() <= size;
    items.truncate(size);
    let next = items.last().filter(|_| !is_last).map(token);
    (items, next)
}
