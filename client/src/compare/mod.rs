//! What comparisons alone have: one method per route.

use crate::client::Client;
use crate::error::Error;
use umwelt_api::ComparisonId;
use umwelt_api::comparison::{self, Figure};
use umwelt_api::endpoint;

impl Client {
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
        self.svg(self.url(endpoint::COMPARISON_FIGURE, &[comparison.as_str(), figure.name()])).await
    }

    /// Every trial of a comparison, as CSV; [`comparison::TRIALS_COLUMNS`] says of what, a later server may add columns
    /// at the end. There may be 20 MB of it: a slow link needs more than the usual deadline ([`Client::within`]).
    ///
    /// # Errors
    /// FAILED_PRECONDITION before it has succeeded, NOT_FOUND where it is not known, [`Error::Protocol`] where the
    /// answer has not these columns, and whatever [`Error`] tells.
    pub async fn comparison_trials(&self, comparison: &ComparisonId) -> Result<String, Error> {
        let url = self.url(endpoint::COMPARISON_TRIALS, &[comparison.as_str()]);
        let header = comparison::TRIALS_COLUMNS.join(",");
        let is_right = |text: &str| text.starts_with(&header);
        self.text(url, comparison::TRIALS_MEDIA_TYPE, "list of trials", is_right).await
    }

    /// The report of a comparison for people, as Markdown.
    ///
    /// # Errors
    /// FAILED_PRECONDITION before it has succeeded, NOT_FOUND where it is not known, [`Error::Protocol`] where the
    /// answer is no text, and whatever [`Error`] tells.
    pub async fn comparison_report(&self, comparison: &ComparisonId) -> Result<String, Error> {
        let url = self.url(endpoint::COMPARISON_REPORT, &[comparison.as_str()]);
        self.text(url, comparison::REPORT_MEDIA_TYPE, "text", |_| true).await
    }
}

#[cfg(test)]
pub(crate) mod tests;
