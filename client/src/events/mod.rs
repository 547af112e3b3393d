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
use umwelt_api::RobotId;
use umwelt_api::endpoint;
use umwelt_api::event::Event;
use umwelt_api::job::{JobEvent, JobKind, JobNews};

/// Without a byte for so long the connection is taken for dead. The server says something every 15 s.
pub const SILENCE: Duration = Duration::from_secs(40);

const LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");

/// The stream of [`Client::events`].
pub type Events = BoxStream<'static, Result<Event, Error>>;

/// The stream of [`Client::job_events`].
pub type JobEvents<K> = BoxStream<'static, Result<JobEvent<K>, Error>>;

/// An event of some stream.
pub(crate) trait Numbered: DeserializeOwned + Send + 'static {
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

impl<K: JobKind> Numbered for JobEvent<K> {
    fn id(&self) -> u64 {
        self.id
    }

    fn is_last(&self) -> bool {
        self.kind.state().is_some_and(|(state, _)| state.has_ended())
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
            Some(robot) => self.url(endpoint::ROBOT_EVENTS, &[robot.as_str()]),
            None => self.url(endpoint::EVENTS, &[]),
        };
        follow(self, url, after).await
    }
}

/// The events at `url`, behind `after`.
pub(crate) async fn follow<E: Numbered>(
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
mod tests;
