//! Comparisons: one method per route.

use crate::client::Client;
use crate::error::Error;
use crate::pages::{self, add_query};
use futures_util::stream::BoxStream;
use reqwest::Url;
use umwelt_api::comparison::{self, Comparison, Figure};
use umwelt_api::page::MAX_PAGE_SIZE;
use umwelt_api::{ComparisonId, IdempotencyKey};

impl Client {
    /// Submits a comparison. Sent twice under one `key` it is one comparison; without one a [`crate::fresh_key`] is
    /// taken, so that the retries of this call are safe. To try again after an error, keep the key.
    ///
    /// # Errors
    /// RESOURCE_EXHAUSTED where too many wait, FAILED_PRECONDITION where the key came with another request, and
    /// whatever [`Error`] tells.
    pub async fn submit_comparison(
        &self,
        request: &comparison::Request,
        key: Option<&IdempotencyKey>,
    ) -> Result<Comparison, Error> {
        self.create(self.at(&["v1", "comparisons"]), request, key).await
    }

    /// How far a comparison has got, and what came of it.
    ///
    /// # Errors
    /// NOT_FOUND where it is not known, and whatever [`Error`] tells.
    pub async fn get_comparison(&self, comparison: &ComparisonId) -> Result<Comparison, Error> {
        self.get(self.comparison(comparison, &[])).await
    }

    /// Removes a comparison with its trials.
    ///
    /// # Errors
    /// FAILED_PRECONDITION where it has not ended, NOT_FOUND where it is not known, and whatever [`Error`] tells.
    pub async fn delete_comparison(&self, comparison: &ComparisonId) -> Result<(), Error> {
        self.delete(self.comparison(comparison, &[])).await
    }

    /// Cancels a comparison.
    ///
    /// # Errors
    /// FAILED_PRECONDITION where it has ended otherwise, NOT_FOUND where it is not known, and whatever [`Error`]
    /// tells.
    pub async fn cancel_comparison(&self, comparison: &ComparisonId) -> Result<Comparison, Error> {
        self.post(self.comparison(comparison, &["cancel"])).await
    }

    /// One page of the comparisons, the newest first, without their reports. [`Client::comparisons`] walks over all
    /// pages.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn list_comparisons(
        &self,
        query: &comparison::PageQuery,
    ) -> Result<comparison::Page, Error> {
        let mut url = self.at(&["v1", "comparisons"]);
        let state = query.state.map(comparison::State::name);
        add_query(&mut url, query.page_size, query.page_token.as_deref(), state);
        self.get(url).await
    }

    /// All comparisons, or those in one state, the newest first, without their reports. An error ends the stream.
    pub fn comparisons(
        &self,
        state: Option<comparison::State>,
    ) -> BoxStream<'static, Result<Comparison, Error>> {
        let client = self.clone();
        pages::all(format!("GET {}", self.at(&["v1", "comparisons"])), move |page_token| {
            let client = client.clone();
            async move {
                let page_size = Some(MAX_PAGE_SIZE);
                let query = comparison::PageQuery { page_size, page_token, state };
                let page = client.list_comparisons(&query).await?;
                Ok((page.comparisons, page.next_page_token))
            }
        })
    }

    /// A figure of a comparison, as SVG.
    ///
    /// # Errors
    /// FAILED_PRECONDITION before it has succeeded, NOT_FOUND where it is not known, [`Error::Protocol`] where the
    /// answer is no SVG, and whatever [`Error`] tells.
    pub async fn comparison_figure(
        &self,
        comparison: &ComparisonId,
        figure: Figure,
    ) -> Result<String, Error> {
        self.svg(self.comparison(comparison, &["figures", figure.name()])).await
    }

    /// Every trial of a comparison, as CSV; [`comparison::TRIALS_COLUMNS`] says of what, a later server may add columns
    /// at the end. There may be 20 MB of it: a slow link needs more than the usual deadline ([`Client::within`]).
    ///
    /// # Errors
    /// FAILED_PRECONDITION before it has succeeded, NOT_FOUND where it is not known, [`Error::Protocol`] where the
    /// answer has not these columns, and whatever [`Error`] tells.
    pub async fn comparison_trials(&self, comparison: &ComparisonId) -> Result<String, Error> {
        let url = self.comparison(comparison, &["trials.csv"]);
        let header = comparison::TRIALS_COLUMNS.join(",");
        let is_right = |text: &str| text.starts_with(&header);
        self.text(url, comparison::TRIALS_MEDIA_TYPE, "list of trials", is_right).await
    }

    /// What came of a comparison, for people, as Markdown.
    ///
    /// # Errors
    /// FAILED_PRECONDITION before it has succeeded, NOT_FOUND where it is not known, [`Error::Protocol`] where the
    /// answer is no text, and whatever [`Error`] tells.
    pub async fn comparison_report(&self, comparison: &ComparisonId) -> Result<String, Error> {
        let url = self.comparison(comparison, &["report.md"]);
        self.text(url, comparison::REPORT_MEDIA_TYPE, "text", |_| true).await
    }

    fn comparison(&self, comparison: &ComparisonId, below: &[&str]) -> Url {
        self.at(&[&["v1", "comparisons", comparison.as_str()], below].concat())
    }
}

#[cfg(test)]
pub(crate) mod tests;
