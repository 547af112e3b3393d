//! Lists that come in pages.

use crate::client::Client;
use crate::error::Error;
use futures_util::stream::{self, BoxStream, StreamExt, TryStreamExt};
use reqwest::Url;
use serde::Deserialize;
use umwelt_api::page::Unreadable;

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

impl Client {
    /// What the server keeps of `kind` (`robots`, `priors`, `environments`, `evolutions`, `comparisons`) and cannot read,
    /// in its order: a newer version of it has written that.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn unreadable(&self, kind: &str) -> Result<Vec<Unreadable>, Error> {
        #[derive(Deserialize)]
        struct Rest {
            #[serde(default)]
            unreadable: Vec<Unreadable>,
            next_page_token: Option<String>,
        }
        let what = format!("GET {}", self.at(&["v1", kind]));
        let (client, kind) = (self.clone(), kind.to_owned());
        let all = all(what, move |token| {
            let mut url = client.at(&["v1", &kind]);
            add_query(&mut url, None, token.as_deref(), None);
            let client = client.clone();
            async move {
                let rest: Rest = client.get(url).await?;
                Ok((rest.unreadable, rest.next_page_token))
            }
        });
        all.try_collect().await
    }
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
