//! The kinds of problems and the HTTP status of each.

use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// The kind of a problem, by its gRPC name. Success has none here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE", from = "String")]
#[schema(as = ProblemStatus)]
pub enum Status {
    /// What was sent is wrong, whatever the state of the system.
    InvalidArgument,
    /// The state of the system does not allow it.
    FailedPrecondition,
    /// Past the end of what exists.
    OutOfRange,
    /// No one knows who asks.
    Unauthenticated,
    /// Who asks may not.
    PermissionDenied,
    /// There is no such thing.
    NotFound,
    /// There is such a thing already.
    AlreadyExists,
    /// Someone else was first: another epoch, another version.
    Aborted,
    /// Too much at once; `Retry-After` says when to come again.
    ResourceExhausted,
    /// The caller gave up.
    Cancelled,
    /// An invariant is broken.
    Internal,
    /// Data is lost or damaged.
    DataLoss,
    /// Of no known kind.
    Unknown,
    /// Not done here.
    Unimplemented,
    /// Not now; the only kind that is retried by itself.
    Unavailable,
    /// Not in time.
    DeadlineExceeded,
}

impl Status {
    /// Every status.
    pub const ALL: [Self; 16] = [
        Self::InvalidArgument,
        Self::FailedPrecondition,
        Self::OutOfRange,
        Self::Unauthenticated,
        Self::PermissionDenied,
        Self::NotFound,
        Self::AlreadyExists,
        Self::Aborted,
        Self::ResourceExhausted,
        Self::Cancelled,
        Self::Internal,
        Self::DataLoss,
        Self::Unknown,
        Self::Unimplemented,
        Self::Unavailable,
        Self::DeadlineExceeded,
    ];

    /// The gRPC name.
    pub fn name(self) -> &'static str {
        match self {
            Self::InvalidArgument => "INVALID_ARGUMENT",
            Self::FailedPrecondition => "FAILED_PRECONDITION",
            Self::OutOfRange => "OUT_OF_RANGE",
            Self::Unauthenticated => "UNAUTHENTICATED",
            Self::PermissionDenied => "PERMISSION_DENIED",
            Self::NotFound => "NOT_FOUND",
            Self::AlreadyExists => "ALREADY_EXISTS",
            Self::Aborted => "ABORTED",
            Self::ResourceExhausted => "RESOURCE_EXHAUSTED",
            Self::Cancelled => "CANCELLED",
            Self::Internal => "INTERNAL",
            Self::DataLoss => "DATA_LOSS",
            Self::Unknown => "UNKNOWN",
            Self::Unimplemented => "UNIMPLEMENTED",
            Self::Unavailable => "UNAVAILABLE",
            Self::DeadlineExceeded => "DEADLINE_EXCEEDED",
        }
    }

    /// The HTTP status code that goes with it.
    pub fn http_code(self) -> u16 {
        match self {
            Self::InvalidArgument | Self::OutOfRange => 400,
            Self::Unauthenticated => 401,
            Self::PermissionDenied => 403,
            Self::NotFound => 404,
            Self::FailedPrecondition | Self::AlreadyExists | Self::Aborted => 409,
            Self::ResourceExhausted => 429,
            Self::Cancelled => 499,
            Self::Internal | Self::DataLoss | Self::Unknown => 500,
            Self::Unimplemented => 501,
            Self::Unavailable => 503,
            Self::DeadlineExceeded => 504,
        }
    }

    /// The status that says most of what HTTP status `code` says, for responses of others.
    pub fn from_http(code: u16) -> Self {
        match code {
            401 => Self::Unauthenticated,
            403 => Self::PermissionDenied,
            404 | 410 => Self::NotFound,
            405 | 501 => Self::Unimplemented,
            408 | 504 => Self::DeadlineExceeded,
            409 | 412 => Self::Aborted,
            429 => Self::ResourceExhausted,
            499 => Self::Cancelled,
            400..=498 => Self::InvalidArgument,
            500 => Self::Internal,
            502 | 503 => Self::Unavailable,
            _ => Self::Unknown,
        }
    }

    /// Whether the same request may be sent again without asking anybody.
    pub fn is_retried(self) -> bool {
        self == Self::Unavailable
    }
}

impl From<String> for Status {
    /// The status of that name; unknown names of later versions are [`Status::Unknown`].
    fn from(name: String) -> Self {
        Self::ALL.into_iter().find(|status| status.name() == name).unwrap_or(Self::Unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_what_serde_writes_and_reads() {
        for status in Status::ALL {
            let json = serde_json::to_value(status).unwrap();
            assert_eq!(json, status.name());
            assert_eq!(serde_json::from_value::<Status>(json).unwrap(), status);
        }
    }

    /// Guards against: whoever sends a good request is told that it is a bad one, and looks for the mistake in it.
    #[test]
    fn what_depends_on_state_is_a_conflict_and_no_bad_request() {
        let of = |code| Status::ALL.into_iter().filter(move |status| status.http_code() == code);
        assert_eq!(of(400).collect::<Vec<_>>(), [Status::InvalidArgument, Status::OutOfRange]);
        let conflicts = [Status::FailedPrecondition, Status::AlreadyExists, Status::Aborted];
        assert_eq!(of(409).collect::<Vec<_>>(), conflicts);
    }

    #[test]
    fn an_error_never_looks_like_success() {
        assert!(Status::ALL.iter().all(|status| (400..600).contains(&status.http_code())));
        assert!((0..1000).all(|code| Status::from_http(code).http_code() >= 400));
    }
}
