//! Lists that come in pages.

use crate::error::Error;
use futures_util::stream::{self, BoxStream, StreamExt, TryStreamExt};
use reqwest::Url;

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

/// Adds what was asked for to `url`, and no more.
pub(crate) fn add_query(
    url: &mut Url,
    page_size: Option<u64>,
    page_token: Option<&str>,
    state: Option<&str>,
) {
    let size = page_size.map(|size| size.to_string());
    let parts = [("page_size", size.as_deref()), ("page_token", page_token), ("state", state)];
    let parts = parts.into_iter().filter_map(|(name, value)| Some((name, value?)));
    for (name, value) in parts {
        url.query_pairs_mut().append_pair(name, value);
    }
}
