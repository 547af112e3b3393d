//! Lists that come in pages.

use crate::error::Error;
use futures_util::stream::{self, BoxStream, StreamExt, TryStreamExt};
use reqwest::Url;
use umwelt_api::page::PageQuery;

/// A page: its items, and where the next one begins.
pub(crate) type Page<T> = (Vec<T>, Option<String>);

/// All items of a list that `what` asks for. `fetch` gives the page at a token, the first without one. Pages are asked
/// for as they are needed; an error ends the stream.
pub(crate) fn all<T, F>(
    what: String,
    fetch: impl Fn(Option<String>) -> F + Send + 'static,
) -> BoxStream<'static, Result<T, Error>>
where
    T: Send + 'static,
    F: Future<Output = Result<Page<T>, Error>> + Send + 'static,
{
    let pages = stream::try_unfold(Some(None), move |token: Option<Option<String>>| {
        let what = what.clone();
        let page = token.map(|token| (token.clone(), fetch(token)));
        async move {
            let Some((token, page)) = page else { return Ok(None) };
            let (items, next) = page.await?;
            // A token that leads to itself would be followed for ever.
            if next.is_some() && next == token {
                return Err(Error::Protocol {
                    what: what.into(),
                    why: format!("page {} is followed by itself", next.unwrap_or_default()),
                });
            }
            Ok(Some((items, next.map(Some))))
        }
    });
    pages.map_ok(|items| stream::iter(items.into_iter().map(Ok))).try_flatten().boxed()
}

/// Adds what was asked for to `url`, and no more; `name` is that of a state.
pub(crate) fn add_query<S>(url: &mut Url, query: &PageQuery<S>, name: fn(&S) -> &str) {
    let PageQuery { page_size, page_token, state } = query;
    let size = page_size.map(|size| size.to_string());
    let parts = [
        ("page_size", size.as_deref()),
        ("page_token", page_token.as_deref()),
        ("state", state.as_ref().map(name)),
    ];
    let parts = parts.into_iter().filter_map(|(name, value)| Some((name, value?)));
    for (name, value) in parts {
        url.query_pairs_mut().append_pair(name, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_api::robot;

    fn add(url: &mut Url, query: &PageQuery<robot::State>) {
        add_query(url, query, |state| state.name());
    }

    #[test]
    fn a_query_says_what_was_asked_for_and_no_more() {
        let mut url: Url = "http://h/v1/robots".parse().unwrap();
        add(&mut url, &PageQuery::default());
        assert_eq!(url.as_str(), "http://h/v1/robots");
        let query = PageQuery {
            page_size: Some(2),
            page_token: Some("a&b".to_owned()),
            state: Some(robot::State::Lost),
        };
        add(&mut url, &query);
        assert_eq!(url.query(), Some("page_size=2&page_token=a%26b&state=lost"));
    }

    #[test]
    fn every_state_is_asked_for_by_its_name_on_the_wire() {
        use robot::State::{Connected, Failed, Lost, Never};
        for state in [Never, Connected, Lost, Failed] {
            let mut url: Url = "http://h".parse().unwrap();
            add(&mut url, &PageQuery { state: Some(state), ..PageQuery::default() });
            let name = serde_json::to_value(state).unwrap();
            assert_eq!(url.query(), name.as_str().map(|name| format!("state={name}")).as_deref());
        }
    }
}
