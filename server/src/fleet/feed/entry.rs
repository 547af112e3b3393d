//! An event of a feed, written once for all who follow it.

use bytes::Bytes;
use std::fmt;
use std::sync::OnceLock;
use umwelt_api::RobotId;
use umwelt_api::event::{Event, Kind};

/// Room for most events: a horizon of twenty slots.
const ROOM: usize = 2048;

/// Something that happened, in its place in the order of things.
#[derive(Debug)]
pub(crate) struct Entry {
    id: u64,
    robot: Option<RobotId>,
    what: What,
    /// As streams have it; written when the first follower reads it.
    written: OnceLock<Bytes>,
}

/// What happened.
pub(crate) enum What {
    /// This.
    Known(Kind),
    /// What this says, if anybody wants to know.
    Asked(Box<dyn Fn() -> Kind + Send + Sync>),
}

impl From<Kind> for What {
    fn from(kind: Kind) -> Self {
        Self::Known(kind)
    }
}

impl fmt::Debug for What {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(kind) => kind.fmt(formatter),
            Self::Asked(_) => formatter.write_str("Asked"),
        }
    }
}

impl Entry {
    pub(super) fn new(id: u64, robot: Option<RobotId>, what: What) -> Self {
        Self { id, robot, what, written: OnceLock::new() }
    }

    /// Its number.
    pub(crate) fn id(&self) -> u64 {
        self.id
    }

    /// The event.
    pub(crate) fn event(&self) -> Event {
        let kind = match &self.what {
            What::Known(kind) => kind.clone(),
            What::Asked(ask) => ask(),
        };
        Event { id: self.id, robot: self.robot.clone(), kind }
    }

    /// The event as a stream has it; nothing where it holds a number that cannot be said.
    pub(crate) fn written(&self) -> &Bytes {
        self.written.get_or_init(|| {
            let event = self.event();
            written(&event).unwrap_or_else(|error| {
                tracing::error!(id = self.id, %error, "cannot write event");
                Bytes::new()
            })
        })
    }
}

/// Its three fields and the empty line that ends it. JSON has no line breaks of its own.
fn written(event: &Event) -> serde_json::Result<Bytes> {
    let mut text = Vec::with_capacity(ROOM);
    text.extend_from_slice(b"id: ");
    text.extend_from_slice(event.id.to_string().as_bytes());
    text.extend_from_slice(b"\nevent: ");
    text.extend_from_slice(event.kind.name().as_bytes());
    text.extend_from_slice(b"\ndata: ");
    serde_json::to_writer(&mut text, event)?;
    text.extend_from_slice(b"\n\n");
    Ok(text.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::response::{IntoResponse, Sse, sse};
    use futures_util::stream;
    use http_body_util::BodyExt;
    use std::convert::Infallible;
    use umwelt_api::robot::State;

    /// What axum makes of the same event.
    async fn by_axum(event: &Event) -> Bytes {
        let written = sse::Event::default().id(event.id.to_string()).event(event.kind.name());
        let written = written.json_data(event).unwrap();
        let body = Sse::new(stream::iter([Ok::<_, Infallible>(written)])).into_response();
        body.into_body().collect().await.unwrap().to_bytes()
    }

    #[tokio::test]
    async fn an_event_is_written_as_streams_have_it() {
        let robot: RobotId = "rover-7".parse().unwrap();
        for kind in [
            Kind::Stopped,
            Kind::Missed,
            Kind::Link { state: State::Lost },
            Kind::Epoch { epoch: u64::MAX },
            Kind::Arrived { elapsed_s: 1.25, max_deviation_m: 1e-9 },
        ] {
            for robot in [Some(robot.clone()), None] {
                let entry = Entry::new(7, robot, kind.clone().into());
                assert_eq!(*entry.written(), by_axum(&entry.event()).await);
            }
        }
    }

    #[test]
    fn what_cannot_be_said_is_left_out() {
        let kind = Kind::Arrived { elapsed_s: f64::NAN, max_deviation_m: 0.0 };
        assert_eq!(*Entry::new(7, None, kind.into()).written(), "");
    }
}
