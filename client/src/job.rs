//! Jobs of any kind: submitted, shown, listed, cancelled, removed, followed.

use crate::call::Call;
use crate::client::Client;
use crate::error::Error;
use crate::events::{JobEvents, follow};
use futures_util::stream::BoxStream;
use reqwest::{Method, Url};
use tower::util::rng::{HasherRng, Rng};
use umwelt_api::IdempotencyKey;
use umwelt_api::job::{Job, JobKind, JobPage, State};
use umwelt_api::page::PageQuery;

/// An idempotency key that no other caller has: 128 random bits.
///
/// # Panics
/// Never: hexadecimal digits are a key.
pub fn fresh_key() -> IdempotencyKey {
    let mut random = HasherRng::new();
    let key = format!("{:016x}{:016x}", random.next_u64(), random.next_u64());
    key.parse().expect("hexadecimal digits are visible ASCII")
}

impl Client {
    /// Submits a job. Sent twice under one `key` it is one job; without one a [`fresh_key`] is taken, so that the retries
    /// of this call are safe. To try again after an error, keep the key.
    ///
    /// ```no_run
    /// # async fn example(client: umwelt_client::Client) -> Result<(), umwelt_client::Error> {
    /// use umwelt_api::evolution::{EvolutionKind, Request};
    /// let evolution = client.submit::<EvolutionKind>(&Request::default(), None).await?;
    /// println!("{} is {}", evolution.id, evolution.state.name());
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// RESOURCE_EXHAUSTED where too many wait, FAILED_PRECONDITION where the key came with another request, and
    /// whatever [`Error`] tells.
    pub async fn submit<K: JobKind>(
        &self,
        request: &K::Request,
        key: Option<&IdempotencyKey>,
    ) -> Result<Job<K>, Error> {
        let call = self.call(Method::POST, self.at(&["v1", K::LIST])).with_json(request)?;
        let idempotency_key = Some(key.cloned().unwrap_or_else(fresh_key));
        self.typed(Call { idempotency_key, ..call }).await
    }

    /// How far a job has got, and what it ended with.
    ///
    /// # Errors
    /// NOT_FOUND where it is not known, and whatever [`Error`] tells.
    pub async fn job<K: JobKind>(&self, id: &K::Id) -> Result<Job<K>, Error> {
        self.get(self.below_job::<K>(id, &[])).await
    }

    /// One page of the jobs of a kind, the newest first. [`Client::jobs`] walks over all pages.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn list_jobs<K: JobKind>(
        &self,
        query: &PageQuery<State>,
    ) -> Result<JobPage<K>, Error> {
        self.page(self.at(&["v1", K::LIST]), query, |state| state.name()).await
    }

    /// All jobs of a kind, or those in one state, the newest first. An error ends the stream.
    pub fn jobs<K: JobKind>(
        &self,
        state: Option<State>,
    ) -> BoxStream<'static, Result<Job<K>, Error>> {
        let query = PageQuery { page_size: Some(K::PAGE_SIZE), state, ..PageQuery::default() };
        let split = |page: JobPage<K>| (page.jobs, page.next_page_token);
        self.all(self.at(&["v1", K::LIST]), query, |state| state.name(), split)
    }

    /// Cancels a job; what its batches have left stays.
    ///
    /// # Errors
    /// FAILED_PRECONDITION where it has ended otherwise, NOT_FOUND where it is not known, and whatever [`Error`]
    /// tells.
    pub async fn cancel<K: JobKind>(&self, id: &K::Id) -> Result<Job<K>, Error> {
        self.post(self.below_job::<K>(id, &["cancel"])).await
    }

    /// Removes a job with all that is kept of it; what it gave to others, as a prior, stays.
    ///
    /// # Errors
    /// FAILED_PRECONDITION where it has not ended, NOT_FOUND where it is not known, and whatever [`Error`] tells.
    pub async fn remove<K: JobKind>(&self, id: &K::Id) -> Result<(), Error> {
        self.delete(self.below_job::<K>(id, &[])).await
    }

    /// What happens to a job: what the kind has behind the event `after` (all of it without), the state as it is now, then
    /// each change. It ends after the state in which the job ended.
    ///
    /// It reconnects as [`Client::events`] does, also to a server that was started anew, and misses no generation of an
    /// evolution.
    ///
    /// # Errors
    /// NOT_FOUND where the job is not known, and whatever [`Error`] tells.
    pub async fn job_events<K: JobKind>(
        &self,
        id: &K::Id,
        after: Option<u64>,
    ) -> Result<JobEvents<K>, Error> {
        follow(self, self.below_job::<K>(id, &["events"]), after).await
    }

    /// Where something of a job is.
    pub(crate) fn below_job<K: JobKind>(&self, id: &K::Id, below: &[&str]) -> Url {
        self.at(&[&["v1", K::LIST, id.as_ref()], below].concat())
    }

    /// The text at `url`. One that `is_right` does not take for what was asked is refused as no `kind`.
    pub(crate) async fn text(
        &self,
        url: Url,
        accept: &'static str,
        kind: &str,
        is_right: impl Fn(&str) -> bool,
    ) -> Result<String, Error> {
        let call = Call { accept, ..self.call(Method::GET, url) };
        let what = call.what.clone();
        let bytes = self.bytes(call).await?;
        let text = std::str::from_utf8(&bytes).ok().filter(|text| is_right(text));
        text.map(str::to_owned).ok_or_else(|| Error::Protocol {
            what: what.as_ref().into(),
            why: format!("the answer is no {kind}"),
        })
    }

    /// The figure at `url`, as SVG.
    pub(crate) async fn svg(&self, url: Url) -> Result<String, Error> {
        self.text(url, "image/svg+xml", "SVG", |text| text.contains("<svg")).await
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::COMPARISON;
    use crate::test_server::{Server, answer, json};
    use futures_util::{StreamExt, TryStreamExt};
    use hyper::StatusCode;
    use std::collections::BTreeSet;
    use std::sync::{Arc, Mutex};
    use umwelt_api::job::{JobDescription, JobNews};
    use umwelt_api::{PriorId, comparison, evolution};

    /// A third kind, of which no other code knows; it looks like a comparison, and its ids stand in fields of its name.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct CountingKind;

    impl JobKind for CountingKind {
        const NAME: &'static str = "counting";
        const LIST: &'static str = "countings";
        const DESCRIPTION: JobDescription = comparison::ComparisonKind::DESCRIPTION;
        type Id = PriorId;
        type Request = comparison::Request;
        type Spec = comparison::Spec;
        type Progress = comparison::Progress;
        type Outcome = comparison::Outcome;
        type News = comparison::Kind;

        fn id(number: u64) -> PriorId {
            format!("counting-{number}").parse().unwrap()
        }

        fn event_id(progress: &comparison::Progress) -> u64 {
            progress.trials_done
        }

        fn episodes(progress: &comparison::Progress) -> (u64, u64) {
            (progress.episodes, progress.total_episodes)
        }
    }

    #[tokio::test]
    async fn a_third_kind_has_every_call() {
        let counting = COMPARISON.replace("comparison", "counting");
        let seen = Arc::new(Mutex::new(Vec::new()));
        let server = {
            let (seen, counting) = (Arc::clone(&seen), counting.clone());
            Server::start(move |request| {
                let (method, uri) = (request.method().to_string(), request.uri().to_string());
                let counting = counting.clone();
                seen.lock().unwrap().push(format!("{method} {uri}"));
                async move {
                    if uri.ends_with("/events") {
                        let job: serde_json::Value = serde_json::from_str(&counting).unwrap();
                        let event = serde_json::json!({"id": 0, "counting": "counting-12", "type": "state",
                            "state": "failed", "progress": job["progress"], "error": null});
                        let event = format!("id: 0\ndata: {event}\n\n");
                        return answer(StatusCode::OK, "text/event-stream", &event);
                    }
                    let page = format!(r#"{{"countings": [{counting}], "next_page_token": null}}"#);
                    json(StatusCode::OK, if uri.contains('?') { &page } else { &counting })
                }
            })
            .await
        };
        let client = Client::new(&server.url).unwrap();
        type K = CountingKind;
        let submitted = client.submit::<K>(&comparison::Request::default(), None).await.unwrap();
        let id = K::id(12);
        assert_eq!((&submitted.id, &submitted), (&id, &serde_json::from_str(&counting).unwrap()));
        assert_eq!(client.job::<K>(&id).await.unwrap(), submitted);
        let listed: Vec<_> = client.jobs::<K>(Some(State::Queued)).try_collect().await.unwrap();
        let whole: JobPage<K> = client.whole(None).await.unwrap();
        assert_eq!((&listed, &whole.jobs), (&vec![submitted.clone()], &listed));
        assert_eq!(client.cancel::<K>(&id).await.unwrap(), submitted);
        client.remove::<K>(&id).await.unwrap();
        let events: Vec<_> = client.job_events::<K>(&id, Some(0)).await.unwrap().collect().await;
        assert_eq!(events[0].as_ref().unwrap().kind.state().unwrap().0, State::Failed);
        let expected = [
            "POST /v1/countings",
            "GET /v1/countings/counting-12",
            "GET /v1/countings?page_size=500&state=queued",
            "GET /v1/countings?page_size=500",
            "POST /v1/countings/counting-12/cancel",
            "DELETE /v1/countings/counting-12",
            "GET /v1/countings/counting-12/events",
        ];
        assert_eq!(*seen.lock().unwrap(), expected);
    }

    #[test]
    fn fresh_keys_are_all_different() {
        let keys: BTreeSet<_> = (0..1000).map(|_| fresh_key()).collect();
        assert_eq!(keys.len(), 1000);
    }

    #[test]
    fn every_figure_is_svg() {
        assert_eq!(evolution::Figure::MEDIA_TYPE, "image/svg+xml");
        assert_eq!(comparison::Figure::MEDIA_TYPE, "image/svg+xml");
    }
}
