//! Everything that goes wrong, as a response: one body for all, and the headers that go with it.

use crate::http::answer;
use crate::store::StoreError;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use umwelt_api::problem::{Detail, ErrorBody, Problem, Problems, Status, reason};
use umwelt_api::{InvalidId, RobotId};

/// Seconds to wait before asking again, where waiting helps.
const RETRY_AFTER: HeaderValue = HeaderValue::from_static("1");

/// How to say who asks.
const BEARER: HeaderValue = HeaderValue::from_static("Bearer");

/// What a route returns.
pub(crate) type Result<T = Response, E = Failure> = std::result::Result<T, E>;

/// A problem on its way out. The HTTP status is the problem's own, but where HTTP has a better one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Failure {
    problem: Problem,
    code: u16,
}

impl Failure {
    pub(crate) fn new(status: Status, message: impl Into<String>) -> Self {
        Problem::new(status, message).into()
    }

    /// The same with one more thing that is wrong.
    pub(crate) fn with(mut self, detail: Detail) -> Self {
        self.problem.details.push(detail);
        self
    }

    /// What it says, for people.
    pub(crate) fn message(&self) -> &str {
        &self.problem.message
    }

    /// Whether a store said it of what it was to keep: asking again is of no use.
    pub(crate) fn is_of_content(&self) -> bool {
        let is_of_store = self.problem.details.iter().any(|it| it.reason == reason::STORE_FAILED);
        is_of_store && self.problem.status == Status::Internal
    }

    /// The same under another HTTP status.
    pub(crate) fn under(mut self, code: StatusCode) -> Self {
        self.code = code.as_u16();
        self
    }
}

impl From<Problem> for Failure {
    fn from(problem: Problem) -> Self {
        Self { code: problem.http_status(), problem }
    }
}

impl From<Problems> for Failure {
    fn from(problems: Problems) -> Self {
        let code = problems.http_status();
        Self { code, problem: Problem::from(problems) }
    }
}

impl From<InvalidId> for Failure {
    fn from(invalid: InvalidId) -> Self {
        Problems::from(invalid).into()
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        let status = match error {
            StoreError::Unavailable(_) => Status::Unavailable,
            StoreError::Damaged(_) => Status::DataLoss,
            StoreError::Rejected(_) => Status::Internal,
        };
        let remedy = "nothing was changed; robots that drive go on driving";
        Self::new(status, error.to_string()).with(Detail::new(reason::STORE_FAILED, "", (), remedy))
    }
}

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        let Self { problem, code } = self;
        let status = problem.status;
        let mut body = ErrorBody::from(problem);
        body.error.code = code;
        let code = StatusCode::from_u16(code).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = answer::json(code, &body);
        if matches!(status, Status::ResourceExhausted | Status::Unavailable) {
            response.headers_mut().insert(header::RETRY_AFTER, RETRY_AFTER);
        }
        if status == Status::Unauthenticated {
            response.headers_mut().insert(header::WWW_AUTHENTICATE, BEARER);
        }
        response
    }
}

/// Nothing goes by this `name` among what `what` says in the singular: `prior`.
pub(crate) fn no_such(what: &str, name: &str) -> Failure {
    let remedy = format!("list those there are: GET /v1/{what}s");
    let detail = Detail::new(reason::NO_SUCH_RESOURCE, what, name, remedy);
    Failure::new(Status::NotFound, format!("there is no {what} {name}")).with(detail)
}

pub(crate) fn no_such_robot(robot: &RobotId) -> Failure {
    let remedy = "describe it: PUT /v1/robots/{robot}, or list those there are: GET /v1/robots";
    Failure::new(Status::NotFound, format!("there is no robot {robot}")).with(Detail::new(
        reason::NO_SUCH_RESOURCE,
        "robot",
        robot.as_str(),
        remedy,
    ))
}

pub(crate) fn no_task(robot: &RobotId) -> Failure {
    let remedy = "set one: PUT /v1/robots/{robot}/task";
    Failure::new(Status::NotFound, format!("robot {robot} has no task")).with(Detail::new(
        reason::NO_SUCH_RESOURCE,
        "task",
        (),
        remedy,
    ))
}

pub(crate) fn draining() -> Failure {
    let remedy = "ask again when the server is back";
    Failure::new(Status::Unavailable, "the server is shutting down").with(Detail::new(
        reason::DRAINING,
        "",
        (),
        remedy,
    ))
}

pub(crate) fn limit_reached(what: &str, limit: usize) -> Failure {
    let message = format!("there are {limit} {what} already, which is the limit");
    let remedy = "remove or end some, or start the server with a higher limit";
    Failure::new(Status::ResourceExhausted, message).with(Detail::new(
        reason::LIMIT_REACHED,
        "",
        limit,
        remedy,
    ))
}

/// A call that was made elsewhere has panicked.
pub(crate) fn broken(error: &tokio::task::JoinError) -> Failure {
    tracing::error!(%error, "a change broke off");
    internal("the change broke off; the log says why")
}

pub(crate) fn internal(message: impl Into<String>) -> Failure {
    Failure::new(Status::Internal, message)
}
