//! Everything that a call can fail with.

use std::fmt::Write;
use std::time::Duration;
use umwelt_api::problem::{Detail, Problem, Status};

/// Why a call gave no answer. Each says what was tried (`GET http://...`) and what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The call cannot be made as it is: no such server address, a number that JSON cannot say.
    #[error("{what}: {why}")]
    BadCall {
        /// What was tried.
        what: Box<str>,
        /// Why it cannot be done, and what can.
        why: String,
    },
    /// The server understood and said no.
    #[error("{what}: {problem}{}", remedies(problem))]
    Problem {
        /// What was tried.
        what: Box<str>,
        /// What the server said.
        problem: Problem,
        /// When it asks to be asked again.
        retry_after: Option<Duration>,
    },
    /// The question or the answer did not get through.
    #[error("{what}: {} ({cause})", .failure.in_words())]
    Transport {
        /// What was tried.
        what: Box<str>,
        /// How far it got.
        failure: Failure,
        /// What the system said.
        cause: String,
    },
    /// Something answered, but not as an Umwelt server of this version does.
    #[error(
        "{what}: {why}; check that the address is that of an Umwelt server and that it fits this client"
    )]
    Protocol {
        /// What was tried.
        what: Box<str>,
        /// What cannot be read.
        why: String,
    },
}

/// How far a call got that did not get through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// No server listens there, or nothing gets there. It was not done.
    Unreachable,
    /// No answer before the deadline. It may have been done.
    TimedOut,
    /// The connection ended before the answer. It may have been done.
    Closed,
}

impl Failure {
    fn in_words(self) -> &'static str {
        match self {
            Self::Unreachable => {
                "no server reached; check that umwelt-server runs there and that the address is right"
            }
            Self::TimedOut => {
                "no answer in time; it may have been done all the same: look, then try again"
            }
            Self::Closed => {
                "the connection ended before the answer; it may have been done all the same: look, then try again"
            }
        }
    }
}

impl Error {
    /// The status by which the server refused, if it is the server that did.
    pub fn status(&self) -> Option<Status> {
        self.problem().map(|problem| problem.status)
    }

    /// What the server said, if it is the server that refused.
    pub fn problem(&self) -> Option<&Problem> {
        match self {
            Self::Problem { problem, .. } => Some(problem),
            Self::BadCall { .. } | Self::Transport { .. } | Self::Protocol { .. } => None,
        }
    }

    /// Whether the same call may succeed later without anybody changing it.
    pub fn is_transient(&self) -> bool {
        match self {
            Self::Problem { problem, .. } => problem.status.is_retried(),
            Self::Transport { .. } => true,
            Self::BadCall { .. } | Self::Protocol { .. } => false,
        }
    }
}

/// The remedies that the message does not name already.
fn remedies(problem: &Problem) -> String {
    let mut text = String::new();
    for Detail { field, remedy, .. } in &problem.details {
        if remedy.is_empty() || problem.message.contains(remedy.as_str()) {
            continue;
        }
        let separator = if text.is_empty() { ". " } else { "; " };
        text.push_str(separator);
        if !field.is_empty() {
            // Writing to a String cannot fail.
            let _ = write!(text, "{field}: ");
        }
        text.push_str(remedy);
    }
    text
}

/// A failure of `what`, as reqwest tells it.
pub(crate) fn transport(what: &str, error: reqwest::Error) -> Error {
    let error = error.without_url();
    if error.is_builder() {
        return Error::BadCall { what: what.into(), why: causes(&error) };
    }
    let failure = if error.is_connect() {
        Failure::Unreachable
    } else if error.is_timeout() {
        Failure::TimedOut
    } else {
        Failure::Closed
    };
    Error::Transport { what: what.into(), failure, cause: causes(&error) }
}

/// The deadline passed while waiting for `what`.
pub(crate) fn late(what: &str, deadline: Duration) -> Error {
    let cause = format!("waited {:.1} s", deadline.as_secs_f64());
    Error::Transport { what: what.into(), failure: Failure::TimedOut, cause }
}

/// What the innermost error says: the ones around it only repeat that a request failed.
fn causes(error: &dyn std::error::Error) -> String {
    let mut innermost = error;
    while let Some(source) = innermost.source() {
        innermost = source;
    }
    innermost.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_names_what_was_tried_and_every_remedy_once() {
        let problem = Problem::new(Status::NotFound, "there is no robot rover-9: list them")
            .with(Detail::new("R", "robot", "rover-9", "list them"))
            .with(Detail::new("R", "drive.lag_s", 9, "use 0 to 2 s"));
        let what = "GET http://h/v1/robots/rover-9".into();
        let error = Error::Problem { what, problem, retry_after: None };
        assert_eq!(
            error.to_string(),
            "GET http://h/v1/robots/rover-9: NOT_FOUND: there is no robot rover-9: list them. drive.lag_s: use 0 to 2 s"
        );
        assert_eq!(error.status(), Some(Status::NotFound));
    }

    #[test]
    fn only_what_may_pass_is_transient() {
        let what: Box<str> = "GET http://h/".into();
        let problem = |status| Error::Problem {
            what: what.clone(),
            problem: Problem::new(status, ""),
            retry_after: None,
        };
        let transient = Status::ALL.into_iter().filter(|status| problem(*status).is_transient());
        assert_eq!(transient.collect::<Vec<_>>(), [Status::Unavailable]);
        assert!(late(&what, Duration::from_secs(1)).is_transient());
        assert!(!Error::Protocol { what, why: String::new() }.is_transient());
    }
}
