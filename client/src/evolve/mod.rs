//! Priors, simulated environments, and what evolutions alone have: one method per route.

use crate::client::Client;
use crate::error::Error;
use crate::pages;
use futures_util::stream::BoxStream;
use serde::de::DeserializeOwned;
use umwelt_api::endpoint::{self, Endpoint};
use umwelt_api::evolution::{Figure, Generation, GenerationsPage};
use umwelt_api::page::{MAX_PAGE_SIZE, PageQuery, Stateless};
use umwelt_api::prior::{self, Prior};
use umwelt_api::training;
use umwelt_api::{EnvironmentId, EvolutionId, PriorId};

impl Client {
    /// Names a prior, for the first time or anew.
    ///
    /// # Errors
    /// FAILED_PRECONDITION where it comes with the server or robots use it, and whatever [`Error`] tells.
    pub async fn put_prior(&self, prior: &PriorId, spec: &prior::Spec) -> Result<Prior, Error> {
        self.send(endpoint::PUT_PRIOR, &[prior.as_str()], spec).await
    }

    /// A prior, where it comes from and which robots use it.
    ///
    /// # Errors
    /// NOT_FOUND where it is not known, and whatever [`Error`] tells.
    pub async fn get_prior(&self, prior: &PriorId) -> Result<Prior, Error> {
        self.ask(endpoint::GET_PRIOR, &[prior.as_str()]).await
    }

    /// Removes a prior.
    ///
    /// # Errors
    /// FAILED_PRECONDITION where it comes with the server or robots use it, NOT_FOUND where it is not known, and
    /// whatever [`Error`] tells.
    pub async fn delete_prior(&self, prior: &PriorId) -> Result<(), Error> {
        self.perform(endpoint::DELETE_PRIOR, &[prior.as_str()]).await
    }

    /// One page of the priors, in the order of their names. [`Client::priors`] walks over all pages.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn list_priors(&self, query: &PageQuery) -> Result<prior::Page, Error> {
        self.plain_page(endpoint::LIST_PRIORS, &[], query).await
    }

    /// All priors, in the order of their names. An error ends the stream.
    pub fn priors(&self) -> BoxStream<'static, Result<Prior, Error>> {
        let split = |page: prior::Page| (page.priors, page.next_page_token);
        self.all_plain(endpoint::LIST_PRIORS, &[], Some(MAX_PAGE_SIZE), split)
    }

    /// Names a simulated environment, for the first time or anew.
    ///
    /// # Errors
    /// FAILED_PRECONDITION where it comes with the server, and whatever [`Error`] tells.
    pub async fn put_training_environment(
        &self,
        environment: &EnvironmentId,
        spec: &training::Spec,
    ) -> Result<training::Environment, Error> {
        self.send(endpoint::PUT_TRAINING_ENVIRONMENT, &[environment.as_str()], spec).await
    }

    /// A simulated environment; what is identified of a robot's is [`Client::environment`].
    ///
    /// # Errors
    /// NOT_FOUND where it is not known, and whatever [`Error`] tells.
    pub async fn get_training_environment(
        &self,
        environment: &EnvironmentId,
    ) -> Result<training::Environment, Error> {
        self.ask(endpoint::GET_TRAINING_ENVIRONMENT, &[environment.as_str()]).await
    }

    /// Removes a simulated environment.
    ///
    /// # Errors
    /// FAILED_PRECONDITION where it comes with the server, NOT_FOUND where it is not known, and whatever [`Error`]
    /// tells.
    pub async fn delete_training_environment(
        &self,
        environment: &EnvironmentId,
    ) -> Result<(), Error> {
        self.perform(endpoint::DELETE_TRAINING_ENVIRONMENT, &[environment.as_str()]).await
    }

    /// One page of the simulated environments, in the order of their names.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn list_training_environments(
        &self,
        query: &PageQuery,
    ) -> Result<training::Page, Error> {
        self.plain_page(endpoint::LIST_TRAINING_ENVIRONMENTS, &[], query).await
    }

    /// All simulated environments, in the order of their names. An error ends the stream.
    pub fn training_environments(
        &self,
    ) -> BoxStream<'static, Result<training::Environment, Error>> {
        let split = |page: training::Page| (page.environments, page.next_page_token);
        let page_size = Some(training::MAX_PAGE_SIZE);
        self.all_plain(endpoint::LIST_TRAINING_ENVIRONMENTS, &[], page_size, split)
    }

    /// One page of the generations of an evolution. [`Client::generations`] walks over all pages.
    ///
    /// # Errors
    /// NOT_FOUND where the evolution is not known, and whatever [`Error`] tells.
    pub async fn list_generations(
        &self,
        evolution: &EvolutionId,
        query: &PageQuery,
    ) -> Result<GenerationsPage, Error> {
        self.plain_page(endpoint::LIST_GENERATIONS, &[evolution.as_str()], query).await
    }

    /// All generations of an evolution as far as they have ended, in their order. An error ends the stream.
    pub fn generations(
        &self,
        evolution: &EvolutionId,
    ) -> BoxStream<'static, Result<Generation, Error>> {
        let split = |page: GenerationsPage| (page.generations, page.next_page_token);
        self.all_plain(endpoint::LIST_GENERATIONS, &[evolution.as_str()], None, split)
    }

    /// A figure of an evolution, as SVG.
    ///
    /// # Errors
    /// FAILED_PRECONDITION before the first generation has ended, NOT_FOUND where the evolution is not known,
    /// [`Error::Protocol`] where the answer is no text, and whatever [`Error`] tells.
    pub async fn figure(&self, evolution: &EvolutionId, figure: Figure) -> Result<String, Error> {
        let names = [evolution.as_str(), figure.name()];
        self.svg(self.url(endpoint::EVOLUTION_FIGURE, &names)).await
    }

    /// A page of a list that cannot be narrowed down.
    async fn plain_page<P: DeserializeOwned>(
        &self,
        endpoint: Endpoint<(), P>,
        names: &[&str],
        query: &PageQuery,
    ) -> Result<P, Error> {
        self.page(self.url(endpoint, names), query, nameless).await
    }

    /// All items of a list that cannot be narrowed down.
    fn all_plain<P: DeserializeOwned + Send + 'static, T: Send + 'static>(
        &self,
        endpoint: Endpoint<(), P>,
        names: &[&str],
        page_size: Option<u64>,
        split: fn(P) -> pages::Page<T>,
    ) -> BoxStream<'static, Result<T, Error>> {
        let query = PageQuery { page_size, ..PageQuery::default() };
        self.all(self.url(endpoint, names), query, nameless, split)
    }
}

/// There is no state to name.
fn nameless(state: &Stateless) -> &str {
    match *state {}
}

#[cfg(test)]
pub(crate) mod tests;
