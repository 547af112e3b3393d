//! What the server keeps and cannot read.

use crate::client::Client;
use crate::error::Error;
use crate::pages::{add_query, all};
use futures_util::stream::TryStreamExt;
use serde::Deserialize;
use umwelt_api::page::Unreadable;

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
