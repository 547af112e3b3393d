//! The error body: one shape for everything that goes wrong, the JSON form of gRPC's status.
//!
//! The server builds a [`Problem`] and sends `problem.http_status()` with [`ErrorBody::from`]; the client turns
//! whatever came back into a [`Problem`] again with [`Problem::parse`].
//!
//! ```
//! use umwelt_api::problem::{Detail, ErrorBody, Problem, Status, reason};
//! let problem = Problem::new(Status::NotFound, "there is no robot rover-9")
//!     .with(Detail::new(reason::NO_SUCH_RESOURCE, "robot", "rover-9", "list them: GET /v1/robots"));
//! let json = serde_json::to_vec(&ErrorBody::from(problem.clone())).unwrap();
//! assert_eq!(Problem::parse(404, &json), problem);
//! ```

mod detail;
mod problems;
pub mod reason;
mod status;

pub use detail::{Detail, MAX_DETAILS, MAX_ECHO, MAX_REMEDY};
pub use problems::Problems;
pub use status::Status;

use crate::schema::ToSchema;
use crate::visible;
use detail::shortened;
use serde::{Deserialize, Serialize};

/// What went wrong, as the server says it and the client hears it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {message}", status.name())]
pub struct Problem {
    /// What kind it is; decides the HTTP status.
    pub status: Status,
    /// One sentence for people.
    pub message: String,
    /// Each thing that is wrong.
    pub details: Vec<Detail>,
}

impl Problem {
    /// A problem without details.
    pub fn new(status: Status, message: impl Into<String>) -> Self {
        Self { status, message: message.into(), details: Vec::new() }
    }

    /// The same with one more detail.
    pub fn with(mut self, detail: Detail) -> Self {
        self.details.push(detail);
        self
    }

    /// The HTTP status code to send.
    pub fn http_status(&self) -> u16 {
        self.status.http_code()
    }

    /// What a response with HTTP status `code` and `body` says. A body in another shape, as from a proxy,
    /// becomes the message. Whoever shows it need not fear what it does to a terminal: hidden characters are escaped.
    pub fn parse(code: u16, body: &[u8]) -> Self {
        match serde_json::from_slice::<ErrorBody>(body) {
            Ok(ErrorBody { error }) => {
                let details = error.details.into_iter().map(Detail::visible).collect();
                let message = visible::line(&error.message).into_owned();
                Self { status: error.status, message, details }
            }
            Err(_) => {
                let text = shortened(String::from_utf8_lossy(body).trim().to_owned(), MAX_ECHO);
                let text = visible::line(&text);
                Self::new(Status::from_http(code), format!("HTTP {code}: {text}"))
            }
        }
    }
}

impl From<Problems> for Problem {
    fn from(problems: Problems) -> Self {
        let message = problems.to_string();
        Self { status: Status::InvalidArgument, message, details: problems.into_details() }
    }
}

/// The body of every response that is no success.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ErrorBody)]
pub struct ErrorBody {
    /// What went wrong.
    pub error: ErrorStatus,
}

/// What went wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ErrorStatus)]
pub struct ErrorStatus {
    /// The HTTP status code.
    pub code: u16,
    /// The gRPC name of the kind of problem.
    pub status: Status,
    /// One sentence for people.
    pub message: String,
    /// Each thing that is wrong: every bad field at once.
    #[serde(default)]
    pub details: Vec<Detail>,
}

impl From<Problem> for ErrorBody {
    fn from(problem: Problem) -> Self {
        let Problem { status, message, details } = problem;
        Self { error: ErrorStatus { code: status.http_code(), status, message, details } }
    }
}

impl From<Problems> for ErrorBody {
    fn from(problems: Problems) -> Self {
        Problem::from(problems).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foreign_error_page_is_still_a_problem() {
        let problem = Problem::parse(502, b"<html>bad gateway</html>");
        assert_eq!(problem.status, Status::Unavailable);
        assert!(problem.message.contains("bad gateway"), "{problem}");
        assert_eq!(Problem::parse(404, b"").status, Status::NotFound);
    }

    /// Guards against: a server, or who pretends to be one, writes on the terminal of whoever reads its errors.
    #[test]
    fn what_a_server_says_shows_as_what_it_is() {
        let evil = "\u{1b}[2J\r\nfake\u{202e}\u{9b}";
        let detail = Detail {
            reason: evil.into(),
            field: evil.into(),
            value: evil.into(),
            remedy: evil.into(),
        };
        let problem = Problem::new(Status::Internal, evil).with(detail);
        let json = serde_json::to_vec(&ErrorBody::from(problem)).unwrap();
        for said in [Problem::parse(500, &json), Problem::parse(500, evil.as_bytes())] {
            let shown = format!("{said} {:?}", said.details);
            assert_eq!(crate::visible::first_hidden(&shown), None, "{shown}");
            assert!(shown.contains("u{1b}"), "{shown}");
        }
    }

    #[test]
    fn a_newer_server_is_understood() {
        let body = br#"{"error":{"code":418,"status":"TEAPOT","message":"m","details":[{"reason":"R","new":1}],"new":2}}"#;
        let problem = Problem::parse(418, body);
        assert_eq!((problem.status, problem.details.len()), (Status::Unknown, 1));
    }

    #[test]
    fn what_is_repeated_is_short_and_whole_characters() {
        let detail = Detail::new("R", "f", "ä".repeat(5000), "");
        assert!(detail.value.as_str().is_some_and(|text| text.len() <= MAX_ECHO + 3));
    }
}
