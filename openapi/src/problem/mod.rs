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

mod problems;
mod status;

pub use problems::Problems;
pub use status::Status;

use crate::visible;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

/// Most details of one error: a body of 1000 bad waypoints must not answer with half a megabyte.
/// The message tells how many there were.
pub const MAX_DETAILS: usize = 100;

/// Longest text in bytes that an error repeats of what was sent.
pub const MAX_ECHO: usize = 200;

/// Longest remedy in bytes: it may name every field of a drive, and may hold words of a parser that repeat a text.
pub const MAX_REMEDY: usize = 500;

/// The reasons that this version gives; clients must expect others.
pub mod reason {
    /// A number is NaN or infinite.
    pub const NOT_FINITE: &str = "NOT_FINITE";
    /// A number lies outside its range.
    pub const OUT_OF_RANGE: &str = "OUT_OF_RANGE";
    /// A list or text is too long or too short.
    pub const WRONG_LENGTH: &str = "WRONG_LENGTH";
    /// A field contradicts another.
    pub const INCONSISTENT: &str = "INCONSISTENT";
    /// A field that nobody knows.
    pub const UNKNOWN_FIELD: &str = "UNKNOWN_FIELD";
    /// Not JSON, a missing field, or a value of another type.
    pub const MALFORMED: &str = "MALFORMED";
    /// An id that is none.
    pub const INVALID_ID: &str = "INVALID_ID";
    /// Nothing goes by this name.
    pub const NO_SUCH_RESOURCE: &str = "NO_SUCH_RESOURCE";
    /// An epoch that another one has taken over from.
    pub const EPOCH_SUPERSEDED: &str = "EPOCH_SUPERSEDED";
    /// The resource is not what `If-Match` says.
    pub const ETAG_MISMATCH: &str = "ETAG_MISMATCH";
    /// There is something already where `If-None-Match: *` wants nothing.
    pub const ALREADY_THERE: &str = "ALREADY_THERE";
    /// The body is compressed or encoded in another way.
    pub const UNSUPPORTED_ENCODING: &str = "UNSUPPORTED_ENCODING";
    /// A character that moves the cursor, hides text or turns its direction.
    pub const HIDDEN_CHARACTER: &str = "HIDDEN_CHARACTER";
    /// The body is larger than allowed.
    pub const BODY_TOO_LARGE: &str = "BODY_TOO_LARGE";
    /// The robot is stopping with the server.
    pub const DRAINING: &str = "DRAINING";
    /// The robot's clock ran backwards within an epoch.
    pub const CLOCK_WENT_BACK: &str = "CLOCK_WENT_BACK";
    /// More is waiting than can be done in time: requests of a robot, evolutions or comparisons of the server.
    pub const QUEUE_FULL: &str = "QUEUE_FULL";
    /// A limit of the server is reached.
    pub const LIMIT_REACHED: &str = "LIMIT_REACHED";
    /// The path exists, the method does not.
    pub const METHOD_NOT_ALLOWED: &str = "METHOD_NOT_ALLOWED";
    /// The body is in another format.
    pub const UNSUPPORTED_MEDIA_TYPE: &str = "UNSUPPORTED_MEDIA_TYPE";
    /// The body did not arrive in time.
    pub const BODY_TIMEOUT: &str = "BODY_TIMEOUT";
    /// The store did not keep it.
    pub const STORE_FAILED: &str = "STORE_FAILED";
    /// It is kept and cannot be read: a newer version of the server wrote it.
    pub const UNREADABLE: &str = "UNREADABLE";
    /// The part of the server that drove the robot failed.
    pub const TASK_DIED: &str = "TASK_DIED";
    /// The computation of the robot does not end.
    pub const ROBOT_FAILED: &str = "ROBOT_FAILED";
    /// A stop came after this resume.
    pub const OVERTAKEN: &str = "OVERTAKEN";
    /// A robot that could not be told.
    pub const NOT_TOLD: &str = "NOT_TOLD";
    /// Robots use this prior: `value` is the id of one of them.
    pub const PRIOR_IN_USE: &str = "PRIOR_IN_USE";
    /// It comes with the server and can be neither replaced nor removed.
    pub const BUILT_IN: &str = "BUILT_IN";
    /// No prior goes by this name.
    pub const UNKNOWN_PRIOR: &str = "UNKNOWN_PRIOR";
    /// No simulated environment goes by this name.
    pub const UNKNOWN_ENVIRONMENT: &str = "UNKNOWN_ENVIRONMENT";
    /// No method, or none with so many slots, goes by this name.
    pub const UNKNOWN_METHOD: &str = "UNKNOWN_METHOD";
    /// No preset of a floor or a link goes by this name.
    pub const UNKNOWN_PRESET: &str = "UNKNOWN_PRESET";
    /// Something stands twice in a list.
    pub const REPEATED: &str = "REPEATED";
    /// This key came with another body before.
    pub const IDEMPOTENCY_KEY_REUSED: &str = "IDEMPOTENCY_KEY_REUSED";
    /// Something goes by this name already, or will.
    pub const NAME_TAKEN: &str = "NAME_TAKEN";
    /// It is still waiting or going on; cancel it first.
    pub const NOT_ENDED: &str = "NOT_ENDED";
    /// It has ended already.
    pub const ENDED: &str = "ENDED";
    /// There is nothing to show yet.
    pub const NOTHING_YET: &str = "NOTHING_YET";
    /// A web page of another origin asks.
    pub const FOREIGN_ORIGIN: &str = "FOREIGN_ORIGIN";
    /// The request names a host that this server is not known by.
    pub const FOREIGN_HOST: &str = "FOREIGN_HOST";
    /// A form of any web page could have sent it.
    pub const FORM_REQUEST: &str = "FORM_REQUEST";
    /// The request carries no token.
    pub const TOKEN_MISSING: &str = "TOKEN_MISSING";
    /// The token is not that of this server.
    pub const TOKEN_WRONG: &str = "TOKEN_WRONG";
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = problem::Detail)]
pub struct Detail {
    /// Why, for programs: `OUT_OF_RANGE`, `UNKNOWN_FIELD`, ...; expect others.
    pub reason: String,
    /// Path of the field, as `waypoints[3].x_m`; empty where the whole is meant.
    #[serde(default)]
    pub field: String,
    /// What the field held, shortened; null where it held nothing, a list or an object.
    #[serde(default)]
    pub value: Value,
    /// What to do about it, for people.
    #[serde(default)]
    pub remedy: String,
}

impl Detail {
    /// What is wrong with `field`; long texts are cut to [`MAX_ECHO`].
    pub fn new(
        reason: impl Into<String>,
        field: impl Into<String>,
        value: impl Into<Value>,
        remedy: impl Into<String>,
    ) -> Self {
        let value = match value.into() {
            Value::String(text) => Value::String(shortened(text, MAX_ECHO)),
            Value::Array(_) | Value::Object(_) => Value::Null,
            scalar => scalar,
        };
        let field = shortened(field.into(), MAX_ECHO);
        let remedy = shortened(remedy.into(), MAX_REMEDY);
        Self { reason: reason.into(), field, value, remedy }
    }
}

impl std::fmt::Display for Detail {
    /// The field, what it held where that is repeated, and what to do.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { field, value, remedy, .. } = self;
        match (field.is_empty(), value.is_null()) {
            (true, _) => write!(f, "{remedy}"),
            (false, true) => write!(f, "{field}: {remedy}"),
            (false, false) => write!(f, "{field} is {value}: {remedy}"),
        }
    }
}

impl Detail {
    /// The same with every hidden character of its texts escaped.
    fn visible(self) -> Self {
        let shown = |text: String| visible::line(&text).into_owned();
        let value = match self.value {
            Value::String(text) => Value::String(shown(text)),
            // Whoever sends lists and objects for a value does not keep the contract.
            Value::Array(_) | Value::Object(_) => Value::Null,
            scalar => scalar,
        };
        let (reason, field, remedy) = (shown(self.reason), shown(self.field), shown(self.remedy));
        Self { reason, field, value, remedy }
    }
}

fn shortened(mut text: String, longest: usize) -> String {
    if text.len() > longest {
        text.truncate(text.floor_char_boundary(longest));
        text.push_str("...");
    }
    text
}

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
#[schema(as = problem::ErrorBody)]
pub struct ErrorBody {
    /// What went wrong.
    pub error: ErrorStatus,
}

/// What went wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = problem::ErrorStatus)]
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

    /// The bug to fear: a server, or who pretends to be one, writes on the terminal of whoever reads its errors.
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
