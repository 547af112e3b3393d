//! How a run ends that does not succeed.

use super::progress;
use std::io;
use std::process::ExitCode;
use umwelt_api::problem::{Detail, Problems};
use umwelt_client::Error;

/// Why a run does not succeed.
#[derive(Debug)]
pub(super) enum Failure {
    /// The call was wrong.
    Wrong(String),
    /// The call was right and it did not work.
    Failed(String),
    /// Standard output is not read any more, as after `| head`: no reason to say anything.
    Unread,
}

impl Failure {
    /// The body in `source` (a file, the flags) is wrong.
    pub(super) fn wrong_body(source: &str, problems: &Problems) -> Self {
        let mut text = match problems.len() {
            1 => format!("{source} is wrong"),
            count => format!("{source} is wrong in {count} places"),
        };
        text.extend(problems.details().iter().map(line));
        if problems.len() > problems.details().len() {
            text.push_str("\n  ...");
        }
        Self::Wrong(text)
    }

    /// Says on standard error what is wrong; the exit status of it.
    pub(super) fn report(self) -> ExitCode {
        match self {
            Self::Wrong(text) => {
                progress::say(&format!("umwelt: {text}"));
                ExitCode::from(2)
            }
            Self::Failed(text) => {
                progress::say(&format!("umwelt: {text}"));
                ExitCode::FAILURE
            }
            Self::Unread => ExitCode::SUCCESS,
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match &error {
            Error::BadCall { .. } => Self::Wrong(error.to_string()),
            Error::Problem { what, problem, .. } => {
                let mut text = format!("{what}: {problem}");
                text.extend(problem.details.iter().map(line));
                Self::Failed(text)
            }
            Error::Transport { .. } | Error::Protocol { .. } => Self::Failed(error.to_string()),
        }
    }
}

impl From<io::Error> for Failure {
    /// A failure to write to standard output.
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::Unread,
            _ => Self::Failed(format!("cannot write to standard output: {error}")),
        }
    }
}

fn line(detail: &Detail) -> String {
    let Detail { reason, field, value, remedy } = detail;
    match (field.as_str(), value.is_null()) {
        ("", _) => format!("\n  {reason}: {remedy}"),
        (field, true) => format!("\n  {field}: {reason}: {remedy}"),
        (field, false) => format!("\n  {field} is {value}: {reason}: {remedy}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_api::problem::{Problem, Status};
    use umwelt_api::robot::Description;

    #[test]
    fn every_problem_of_a_file_has_its_line() {
        let problems =
            Description::read(br#"{"horizon_slots": 0, "drive": {"lag": 0.1, "lag_s": -1.0}}"#)
                .unwrap_err();
        let Failure::Wrong(text) = Failure::wrong_body("spec.json", &problems) else {
            panic!("it is a wrong call")
        };
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines[0], "spec.json is wrong in 3 places");
        assert!(lines[1].starts_with("  drive.lag is 0.1: UNKNOWN_FIELD: "), "{text}");
        assert!(lines[2].starts_with("  drive.lag_s is -1.0: OUT_OF_RANGE: "), "{text}");
        assert!(lines[3].starts_with("  horizon_slots is 0: OUT_OF_RANGE: "), "{text}");
    }

    #[test]
    fn what_the_server_refuses_failed_and_names_the_remedy() {
        let problem = Problem::new(Status::NotFound, "there is no robot a").with(Detail::new(
            "NO_SUCH_RESOURCE",
            "robot",
            "a",
            "list them: GET /v1/robots",
        ));
        let error =
            Error::Problem { what: "GET http://h/v1/robots/a".into(), problem, retry_after: None };
        let Failure::Failed(text) = error.into() else { panic!("the call was right") };
        assert_eq!(
            text,
            "GET http://h/v1/robots/a: NOT_FOUND: there is no robot a\n  robot is \"a\": NO_SUCH_RESOURCE: list them: GET /v1/robots"
        );
    }

    #[test]
    fn a_closed_pipe_is_no_failure() {
        assert!(matches!(io::Error::from(io::ErrorKind::BrokenPipe).into(), Failure::Unread));
        assert!(matches!(io::Error::from(io::ErrorKind::StorageFull).into(), Failure::Failed(_)));
    }
}
