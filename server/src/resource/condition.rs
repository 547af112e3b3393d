//! Under which condition a resource may be written.

use super::failure::{Failure, PRECONDITION_FAILED};
use umwelt_api::problem::{Detail, Status, reason};

/// What must hold of the resource before it is written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Condition {
    /// It has one of these versions; `*` is any.
    pub(crate) versions: Option<Vec<String>>,
    /// There is none yet.
    pub(crate) absent: bool,
}

impl Condition {
    /// It has this version.
    pub(crate) fn of(version: &str) -> Self {
        Self { versions: Some(vec![version.to_owned()]), absent: false }
    }

    /// Whether it holds of a resource whose version is `current`, none where there is no such resource.
    pub(crate) fn check(&self, current: Option<&str>) -> Result<(), Failure> {
        if self.absent && current.is_some() {
            let remedy = "leave If-None-Match out to write over it";
            return Err(Failure::new(Status::AlreadyExists, "it exists already")
                .with(Detail::new(reason::ALREADY_THERE, "If-None-Match", "*", remedy))
                .under(PRECONDITION_FAILED));
        }
        let Some(versions) = &self.versions else { return Ok(()) };
        let is_met = current.is_some_and(|current| {
            versions.iter().any(|version| version == "*" || version == current)
        });
        if is_met {
            return Ok(());
        }
        let message = match current {
            Some(current) => format!("its version is {current} now"),
            None => "it does not exist".to_owned(),
        };
        let remedy = "get it, decide anew, and send its etag in If-Match";
        let given = versions.join(", ");
        let detail = Detail::new(reason::ETAG_MISMATCH, "If-Match", given, remedy);
        let failure = Failure::new(Status::Aborted, message).with(detail);
        Err(failure.under(PRECONDITION_FAILED))
    }
}
