//! Everything that goes wrong with a resource, whoever asked for it: one type from the store up to the answer.

use umwelt_api::endpoint::{LIST_ROBOTS, PUT_ROBOT, PUT_TASK};
use umwelt_api::problem::{Detail, Problem, Problems, Status, reason};
use umwelt_api::{InvalidId, RobotId};

/// The contract's code where a resource is not as the one who writes it wants it to be.
pub(crate) const PRECONDITION_FAILED: u16 = 412;

/// What went wrong, as the contract says it: the problem, and its code, which is that of the problem's status but where
/// the contract has a better one.
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

    /// Whether the resource has another version than the one that it was to have.
    pub(crate) fn is_of_version(&self) -> bool {
        self.problem.details.iter().any(|it| it.reason == reason::ETAG_MISMATCH)
    }

    /// The same under another code.
    pub(crate) fn under(mut self, code: u16) -> Self {
        self.code = code;
        self
    }

    /// The problem, and the code that the contract has for it.
    pub(crate) fn into_parts(self) -> (Problem, u16) {
        (self.problem, self.code)
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

/// Nothing goes by this `name` among what `what` says in the singular: `prior`.
pub(crate) fn no_such(what: &str, name: &str) -> Failure {
    let remedy = format!("list those there are: GET /v1/{what}s");
    let detail = Detail::new(reason::NO_SUCH_RESOURCE, what, name, remedy);
    Failure::new(Status::NotFound, format!("there is no {what} {name}")).with(detail)
}

pub(crate) fn no_such_robot(robot: &RobotId) -> Failure {
    let (put, list) = (PUT_ROBOT.operation(), LIST_ROBOTS.operation());
    let remedy = format!("describe it: {put}, or list those there are: {list}");
    Failure::new(Status::NotFound, format!("there is no robot {robot}")).with(Detail::new(
        reason::NO_SUCH_RESOURCE,
        "robot",
        robot.as_str(),
        remedy,
    ))
}

pub(crate) fn no_task(robot: &RobotId) -> Failure {
    let remedy = format!("set one: {}", PUT_TASK.operation());
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
    tracing::error!(%error, "change broke off");
    internal("the change broke off; the log says why")
}

pub(crate) fn internal(message: impl Into<String>) -> Failure {
    Failure::new(Status::Internal, message)
}
