//! What happens on the server, as a stream that reconnects by itself.

use crate::call;
use crate::client::Client;
use crate::error::{self, Error};
use crate::retry::backoff;
use crate::sse::{Message, Parser};
use futures_util::stream::{self, BoxStream, StreamExt};
use reqwest::header::{ACCEPT, CONTENT_TYPE, HeaderName};
use reqwest::{Response, Url};
use serde::de::DeserializeOwned;
use std::collections::VecDeque;
use std::time::Duration;
use tower::util::rng::{HasherRng, Rng};
use umwelt_api::event::Event;
use umwelt_api::{EvolutionId, RobotId, evolution};

/// Without a byte for so long the connection is taken for dead. The server says something every 15 s.
pub const SILENCE: Duration = Duration::from_secs(40);

const LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");

/// The stream of [`Client::events`].
pub type Events = BoxStream<'static, Result<Event, Error>>;

/// The stream of [`Client::evolution_events`].
pub type EvolutionEvents = BoxStream<'static, Result<evolution::Event, Error>>;

/// An event of some stream.
trait Numbered: DeserializeOwned + Send + 'static {
    /// Behind which to resume.
    fn id(&self) -> u64;

    /// Whether nothing comes after it.
    fn is_last(&self) -> bool;
}

impl Numbered for Event {
    fn id(&self) -> u64 {
        self.id
    }

    fn is_last(&self) -> bool {
        false
    }
}

impl Numbered for evolution::Event {
    fn id(&self) -> u64 {
        self.id
    }

    fn is_last(&self) -> bool {
        matches!(&self.kind, evolution::Kind::State { state, .. } if state.has_ended())
    }
}

impl Client {
    /// What happens from now on, or behind the event `after`: to one robot, or to all.
    ///
    /// The first connection is made before this returns. When it breaks later, the stream says so with an `Err`
    /// whose [`Error::is_transient`] is true and, asked again, reconnects behind the last event, waiting longer each
    /// time it fails. Any other `Err` but an unreadable event ([`Error::Protocol`]) is its last item.
    ///
    /// ```no_run
    /// # async fn example(client: umwelt_client::Client) -> Result<(), umwelt_client::Error> {
    /// use futures_util::StreamExt;
    /// let mut events = client.events(None, None).await?;
    /// while let Some(event) = events.next().await {
    ///     match event {
    ///         Ok(event) => println!("{event:?}"),
    ///         Err(error) => eprintln!("{error}"),
    ///     }
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// NOT_FOUND where the robot is not known, and whatever [`Error`] tells.
    pub async fn events(
        &self,
        robot: Option<&RobotId>,
        after: Option<u64>,
    ) -> Result<Events, Error> {
        let url = match robot {
            Some(robot) => self.at(&["v1", "robots", robot.as_str(), "events"]),
            None => self.at(&["v1", "events"]),
        };
        follow(self, url, after).await
    }

    /// What happens to an evolution: the generations behind `after` (so many have ended; all of them without), the
    /// state as it is now, then each generation and each change of state. It ends after the state in which the
    /// evolution ended.
    ///
    /// It reconnects as [`Client::events`] does, also to a server that was started anew, and misses no generation.
    ///
    /// # Errors
    /// NOT_FOUND where the evolution is not known, and whatever [`Error`] tells.
    pub async fn evolution_events(
        &self,
        evolution: &EvolutionId,
        after: Option<u64>,
    ) -> Result<EvolutionEvents, Error> {
        let url = self.at(&["v1", "evolutions", evolution.as_str(), "events"]);
        follow(self, url, after).await
    }
}

async fn follow<E: Numbered>(
    client: &Client,
    url: Url,
    after: Option<u64>,
) -> Result<BoxStream<'static, Result<E, Error>>, Error> {
    let mut following = Following {
        what: format!("GET {url}"),
        url,
        client: client.clone(),
        last: after,
        failed: 0,
        random: HasherRng::default(),
        ready: VecDeque::new(),
        link: Link::Broken,
    };
    following.connect().await?;
    Ok(stream::unfold(following, |mut following| async {
        let item = following.next().await?;
        Some((item, following))
    })
    .boxed())
}

/// Where a stream of events has got.
struct Following {
    what: String,
    url: Url,
    client: Client,
    /// The last event, behind which to resume.
    last: Option<u64>,
    /// Connections that failed since the last event.
    failed: u32,
    random: HasherRng,
    ready: VecDeque<Message>,
    link: Link,
}

enum Link {
    Open(Box<(Response, Parser)>),
    Broken,
    /// Nothing will come any more.
    Over,
}

impl Following {
    async fn next<E: Numbered>(&mut self) -> Option<Result<E, Error>> {
        loop {
            if let Some(message) = self.ready.pop_front() {
                return Some(self.event(&message));
            }
            let step = match &mut self.link {
                Link::Over => return None,
                Link::Broken => {
                    tokio::time::sleep(backoff(self.failed, self.random.next_f64())).await;
                    self.connect().await
                }
                Link::Open(_) => self.receive().await,
            };
            if let Err(error) = step {
                self.failed = self.failed.saturating_add(1);
                self.link = if error.is_transient() { Link::Broken } else { Link::Over };
                return Some(Err(error));
            }
        }
    }

    async fn connect(&mut self) -> Result<(), Error> {
        let allowed = self.client.allowed();
        // No `grpc-timeout`: the stream has no deadline, only the connecting has.
        let mut request =
            self.client.http().get(self.url.clone()).header(ACCEPT, "text/event-stream");
        if let Some(last) = self.last {
            request = request.header(LAST_EVENT_ID, last);
        }
        let response = async {
            let response =
                request.send().await.map_err(|error| error::transport(&self.what, error))?;
            call::success(&self.what, response).await
        };
        let response = tokio::time::timeout(allowed, response)
            .await
            .unwrap_or_else(|_| Err(error::late(&self.what, allowed)))?;
        let kind = response.headers().get(CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
        if !kind.is_some_and(|kind| kind.starts_with("text/event-stream")) {
            let why =
                format!("the answer is no event stream but {}", kind.unwrap_or("nothing named"));
            return Err(Error::Protocol { what: self.what.as_str().into(), why });
        }
        self.link = Link::Open(Box::new((response, Parser::default())));
        Ok(())
    }

    /// Waits for the next bytes of the open connection.
    async fn receive(&mut self) -> Result<(), Error> {
        let Link::Open(open) = &mut self.link else { return Ok(()) };
        let (response, parser) = open.as_mut();
        let closed = |cause: &str| Error::Transport {
            what: self.what.as_str().into(),
            failure: crate::Failure::Closed,
            cause: cause.to_owned(),
        };
        let chunk = tokio::time::timeout(SILENCE, response.chunk())
            .await
            .map_err(|_| error::late(&self.what, SILENCE))?
            .map_err(|error| error::transport(&self.what, error))?
            .ok_or_else(|| closed("the server ended the stream"))?;
        let mut messages = Vec::new();
        parser.push(&chunk, &mut messages).map_err(|error| Error::Protocol {
            what: self.what.as_str().into(),
            why: error.to_string(),
        })?;
        self.ready.extend(messages);
        Ok(())
    }

    fn event<E: Numbered>(&mut self, message: &Message) -> Result<E, Error> {
        let named = message.id.as_ref().and_then(|id| id.parse().ok());
        self.last = named.or(self.last);
        let event: E = call::read(&self.what, message.data.as_bytes())?;
        self.last = Some(event.id());
        self.failed = 0;
        if event.is_last() {
            self.link = Link::Over;
            self.ready.clear();
        }
        Ok(event)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_server::{Server, answer, json};
    use hyper::{HeaderMap, Method, StatusCode};
    use std::sync::{Arc, Mutex};
    use umwelt_api::event::Kind;
    use umwelt_api::problem::Status;

    const NOT_FOUND: &str =
        r#"{"error": {"code": 404, "status": "NOT_FOUND", "message": "m", "details": []}}"#;

    #[tokio::test]
    async fn a_broken_stream_resumes_behind_the_last_event_until_it_cannot() {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let server = {
            let seen = Arc::clone(&seen);
            Server::start(move |request| {
                let last = last_event_id(request.headers());
                assert_eq!(request.method(), Method::GET);
                assert_eq!(request.headers().get("grpc-timeout"), None);
                let mut seen = seen.lock().unwrap();
                seen.push(last);
                let answer = match seen.len() {
                    1 => answer(
                        StatusCode::OK,
                        "text/event-stream",
                        "id: 7\ndata: {\"id\": 7, \"robot\": \"a\", \"type\": \"stopped\"}\n\n:\n\nid: 8\ndata: nonsense\n\n",
                    ),
                    _ => json(StatusCode::NOT_FOUND, NOT_FOUND),
                };
                async { answer }
            })
            .await
        };
        let client = Client::new(&server.url).unwrap();
        let mut events = client.events(None, Some(3)).await.unwrap();
        assert_eq!(events.next().await.unwrap().unwrap().kind, Kind::Stopped);
        let unreadable = events.next().await.unwrap().unwrap_err();
        assert!(matches!(unreadable, Error::Protocol { .. }));
        let interrupted = events.next().await.unwrap().unwrap_err();
        assert!(interrupted.is_transient(), "{interrupted:?}");
        let last = events.next().await.unwrap().unwrap_err();
        assert_eq!(last.status(), Some(Status::NotFound));
        assert!(events.next().await.is_none());
        assert_eq!(*seen.lock().unwrap(), [Some(3), Some(8)]);
    }

    #[tokio::test]
    async fn what_is_no_event_stream_is_told_at_once() {
        let server = Server::start(|_| async { json(StatusCode::OK, "{}") }).await;
        let client = Client::new(&server.url).unwrap();
        let error = client.events(Some(&"a".parse().unwrap()), None).await.err().unwrap();
        assert!(error.to_string().contains("no event stream but application/json"), "{error}");
    }

    const GENERATION: &str = r#"{"id": 1, "evolution": "evolution-1", "type": "generation", "generation":
        {"index": 0, "best_fitness": 1.5, "mean_fitness": 1, "prior": {}, "environments": []}}"#;

    fn state(id: u64, state: &str) -> String {
        let progress = format!(
            r#"{{"stage": "generations", "generation": {id}, "generations": 2, "best_fitness": null, "mean_fitness": null,
                 "episodes": 5, "total_episodes": 9, "elapsed_s": 1.5, "remaining_s": null}}"#
        );
        let event = format!(
            r#"{{"id": {id}, "evolution": "evolution-1", "type": "state", "state": "{state}", "progress": {progress}, "error": null}}"#
        );
        format!("id: {id}\ndata: {}\n\n", event.replace('\n', ""))
    }

    #[tokio::test]
    async fn an_evolution_is_followed_over_a_restart_until_it_has_ended() {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let server = {
            let seen = Arc::clone(&seen);
            Server::start(move |request| {
                assert_eq!(request.uri(), "/v1/evolutions/evolution-1/events");
                let mut seen = seen.lock().unwrap();
                seen.push(last_event_id(request.headers()));
                let text = match seen.len() {
                    1 => format!(
                        "id: 1\ndata: {}\n\n{}",
                        GENERATION.replace('\n', ""),
                        state(1, "running")
                    ),
                    _ => state(1, "running") + &state(2, "succeeded") + &state(2, "running"),
                };
                let answer = answer(StatusCode::OK, "text/event-stream", &text);
                async { answer }
            })
            .await
        };
        let client = Client::new(&server.url).unwrap();
        let id = "evolution-1".parse().unwrap();
        let events = client.evolution_events(&id, None).await.unwrap();
        let told = events.map(|event| match event {
            Ok(event) => format!("{} {}", event.kind.name(), event.id),
            Err(error) => format!("transient {}", error.is_transient()),
        });
        // One more than it should have: a stream that does not end fails here rather than hangs.
        let told: Vec<_> = told.take(6).collect().await;
        let expected = ["generation 1", "state 1", "transient true", "state 1", "state 2"];
        assert_eq!(told, expected);
        assert_eq!(*seen.lock().unwrap(), [None, Some(1)]);
    }

    fn last_event_id(headers: &HeaderMap) -> Option<u64> {
        headers.get(LAST_EVENT_ID)?.to_str().ok()?.parse().ok()
    }
}
