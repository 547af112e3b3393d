//! The hot path: one HTTP/2 connection that carries steps and nothing else.

use crate::address::Address;
use crate::call::{self, GRPC_TIMEOUT, grpc_timeout};
use crate::error::{self, Error};
use reqwest::header::{CONTENT_TYPE, HeaderValue};
use std::time::Duration;
use umwelt_api::endpoint::STEP;
use umwelt_api::step::{Reply, Request};
use umwelt_api::{RobotId, Token};

/// A reply that is older than this drives nothing any more (the longest horizon is 2 s) and teaches no more than
/// that it was late.
pub const STEP_DEADLINE: Duration = Duration::from_secs(5);

/// Largest answer to a step in bytes; that of the longest horizon has 6 KiB.
pub const MAX_REPLY: usize = 64 << 10;

/// How much of an answer, and of all of a connection, a server may send before it is read: one answer, and one for each of
/// the four steps in flight.
const STREAM_WINDOW: u32 = MAX_REPLY as u32;
const CONNECTION_WINDOW: u32 = 4 * STREAM_WINDOW;

/// A connection on which no ping comes back for `PING_INTERVAL + PING_TIMEOUT` is closed, also one that was dropped
/// while its bytes were stuck: nothing of a dead link stays behind.
const PING_INTERVAL: Duration = Duration::from_secs(5);
const PING_TIMEOUT: Duration = Duration::from_secs(10);

/// One HTTP/2 connection for steps.
///
/// It is opened by the first step. Steps called at the same time share it. Nothing is ever sent twice: what to do
/// about a stall is the caller's decision, whose means is a fresh `StepConnection`. Dropping it, and with it the
/// futures of its steps, closes the connection.
#[derive(Debug)]
pub struct StepConnection {
    http: reqwest::Client,
    address: Address,
}

impl StepConnection {
    pub(crate) fn new(address: Address, token: Option<&Token>) -> Self {
        Self { http: http(token), address }
    }

    /// Sends what the robot saw, gets what it is to play.
    ///
    /// # Errors
    /// ABORTED where another agent has taken the robot over, NOT_FOUND where the server does not know it, and all
    /// that [`Error`] tells; [`Failure::TimedOut`](crate::Failure::TimedOut) after [`STEP_DEADLINE`].
    pub async fn step(&self, robot: &RobotId, request: &Request) -> Result<Reply, Error> {
        let url = self.address.at(&STEP.operation().segments(&[robot.as_str()]));
        let what = format!("POST {url}");
        let body = serde_json::to_vec(request).map_err(|error| Error::BadCall {
            what: what.as_str().into(),
            why: format!("the request cannot be said in JSON: {error}"),
        })?;
        let sent = self
            .http
            .post(url)
            .header(CONTENT_TYPE, HeaderValue::from_static("application/json"))
            .header(GRPC_TIMEOUT, grpc_timeout(STEP_DEADLINE))
            .timeout(STEP_DEADLINE)
            .body(body)
            .send();
        let response = sent.await.map_err(|error| error::transport(&what, error))?;
        let answer = call::body_of_success(&what, response, MAX_REPLY).await?;
        call::read(&what, &answer)
    }
}

fn http(token: Option<&Token>) -> reqwest::Client {
    crate::connection::http(
        reqwest::Client::builder()
            .http2_prior_knowledge()
            .http2_keep_alive_interval(PING_INTERVAL)
            .http2_keep_alive_timeout(PING_TIMEOUT)
            .http2_keep_alive_while_idle(true)
            .http2_initial_stream_window_size(STREAM_WINDOW)
            .http2_initial_connection_window_size(CONNECTION_WINDOW)
            .pool_idle_timeout(None)
            .pool_max_idle_per_host(1),
        token,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Failure;
    use crate::{Client, test_server};
    use hyper::StatusCode;
    use std::sync::Arc;
    use test_server::{Server, json};
    use tokio::sync::Barrier;
    use umwelt_api::problem::{ErrorBody, Problem, Status};

    const REPLY: &str = r#"{"horizon": {"sequence": 1, "answers": 7, "start_s": 0.1, "slot_s": 0.03, "watchdog_s": 0.3,
        "valid_until_s": 0.43, "wheel_speeds": [{"left_rad_per_s": 1.0, "right_rad_per_s": 1.0}]},
        "stopped": false, "stage": "driving", "of_tomorrow": 1}"#;

    fn rover() -> RobotId {
        "rover-7".parse().unwrap()
    }

    fn request() -> Request {
        Request {
            sequence: 7,
            epoch: 1,
            sent_s: 0.0,
            observations: Vec::new(),
            deliveries: Vec::new(),
            playing: None,
            hold: false,
            max_speed_m_per_s: None,
            drive_tag: None,
        }
    }

    #[tokio::test]
    async fn steps_at_the_same_time_share_one_connection_which_ends_with_it() {
        // No step is answered before all four have come.
        let all_here = Arc::new(Barrier::new(4));
        let mut server = Server::start(move |request| {
            let all_here = Arc::clone(&all_here);
            async move {
                assert_eq!(request.uri().path(), "/v1/robots/rover-7/step");
                assert_eq!(request.headers()["grpc-timeout"], "5000m");
                all_here.wait().await;
                json(StatusCode::OK, REPLY)
            }
        })
        .await;
        let connection = Client::new(&server.url).unwrap().step_connection();
        let (rover, request) = (rover(), request());
        let step = || connection.step(&rover, &request);
        let (a, b, c, d) = tokio::join!(step(), step(), step(), step());
        assert!([a, b, c, d].into_iter().all(|reply| reply.unwrap().horizon.answers == 7));
        drop(connection);
        server.connection_ended().await;
        assert_eq!(server.connections(), 1);
    }

    #[tokio::test]
    async fn a_step_is_never_sent_twice() {
        let server = Server::start(|_| async {
            let problem = Problem::new(Status::Unavailable, "not now");
            let body = serde_json::to_string(&ErrorBody::from(problem)).unwrap();
            json(StatusCode::SERVICE_UNAVAILABLE, &body)
        })
        .await;
        let connection = Client::new(&server.url).unwrap().step_connection();
        let error = connection.step(&rover(), &request()).await.unwrap_err();
        assert_eq!(error.status(), Some(Status::Unavailable));
        assert_eq!(server.requests(), 1);
    }

    /// Whatever comes, as a success or as a refusal: no more than a reply is ever read.
    #[tokio::test]
    async fn an_answer_longer_than_any_reply_is_given_up() {
        for status in [StatusCode::OK, StatusCode::BAD_REQUEST] {
            let long = format!("{{\"stage\": \"{}\"}}", "x".repeat(MAX_REPLY));
            let server = Server::start(move |_| {
                let long = long.clone();
                async move { json(status, &long) }
            })
            .await;
            let connection = Client::new(&server.url).unwrap().step_connection();
            let error = connection.step(&rover(), &request()).await.unwrap_err();
            let Error::Protocol { why, .. } = &error else { panic!("{error:?}") };
            assert!(why.contains("longer than 64 KiB"), "{error}");
        }
    }

    #[tokio::test]
    async fn a_port_without_a_server_is_unreachable() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        drop(listener);
        let connection = Client::new(&format!("http://{address}")).unwrap().step_connection();
        let error = connection.step(&rover(), &request()).await.unwrap_err();
        assert!(
            matches!(error, Error::Transport { failure: Failure::Unreachable, .. }),
            "{error:?}"
        );
    }

    #[tokio::test]
    async fn what_json_cannot_say_is_refused_here() {
        let connection = Client::new("http://127.0.0.1:1").unwrap().step_connection();
        let nan = Request { sent_s: f64::NAN, ..request() };
        let error = connection.step(&rover(), &nan).await.unwrap_err();
        assert!(matches!(error, Error::BadCall { .. }), "{error:?}");
    }
}
