//! What is answered where something is wrong: one response per code, with an example for every reason.

use crate::endpoint::Schemas;
use crate::problem::{Detail, ErrorBody, Problem, Status, reason};
use serde_json::Value;
use utoipa::ToSchema;
use utoipa::openapi::example::ExampleBuilder;
use utoipa::openapi::schema::{ObjectBuilder, SchemaType, Type};
use utoipa::openapi::{
    ContentBuilder, HeaderBuilder, Ref, RefOr, Response, ResponseBuilder, Schema,
};

/// The name of the response to everything else.
pub(super) const ANY: &str = "Problem";

/// A code, the name of its response, and what it says.
const CODES: [(u16, &str, &str); 9] = [
    (400, "BadRequest", "INVALID_ARGUMENT or OUT_OF_RANGE: every bad field at once"),
    (404, "NotFound", "NOT_FOUND"),
    (408, "BodyTimeout", "DEADLINE_EXCEEDED: the body did not arrive in time"),
    (
        409,
        "Conflict",
        "FAILED_PRECONDITION, ALREADY_EXISTS or ABORTED: the request is good, the state is another one",
    ),
    (
        412,
        "PreconditionFailed",
        "ABORTED or ALREADY_EXISTS: not as `If-Match` or `If-None-Match` want it",
    ),
    (413, "BodyTooLarge", "INVALID_ARGUMENT: the body is too large"),
    (
        415,
        "UnsupportedMediaType",
        "INVALID_ARGUMENT: the body is not declared as JSON, or is compressed",
    ),
    (429, "TooManyRequests", "RESOURCE_EXHAUSTED: too much at once"),
    (503, "Unavailable", "UNAVAILABLE: not now, ask again"),
];

/// A problem as the server answers it: reason, code, status, message; then of its detail field, value as JSON, remedy.
type Sample = (&'static str, u16, Status, &'static str, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const REASONS: [Sample; 44] = [
    (reason::NOT_FINITE, 400, Status::InvalidArgument, "the request has 1 problem", "noise.position_m", "null", "use a number from 0 to 1 m"),
    (reason::OUT_OF_RANGE, 400, Status::InvalidArgument, "the request has 1 problem", "horizon_slots", "68", "use an integer from 1 to 67"),
    (reason::WRONG_LENGTH, 400, Status::InvalidArgument, "the request has 1 problem", "waypoints", "0", "use 1 to 1000 of them, not 0"),
    (reason::UNKNOWN_FIELD, 400, Status::InvalidArgument, "the request has 1 problem", "drive.lag", "0.1", "leave it out; known here: wheel_radius_m, track_width_m, lag_s"),
    (reason::MALFORMED, 400, Status::InvalidArgument, "the request has 1 problem", "method", "\"best\"", "use fixed-normal, fixed-bad, statistic, bayesian"),
    (reason::INVALID_ID, 400, Status::InvalidArgument, "the request has 1 problem", "prior", "\"Wet Hall\"", "use 1 to 63 of A-Z, a-z, 0-9, -, _ and ., the first a letter or a digit"),
    (reason::HIDDEN_CHARACTER, 400, Status::InvalidArgument, "the request has 1 problem", "note", "\"\\\\u{202e}\"", "leave out U+202E, which stands behind 0 characters"),
    (reason::UNKNOWN_METHOD, 400, Status::InvalidArgument, "the request has 1 problem", "methods[0]", "\"best\"", "known: thesis, statistic, bayesian"),
    (reason::UNKNOWN_PRESET, 400, Status::InvalidArgument, "the request has 1 problem", "slip", "\"lava\"", "known: none, hard, loaded, dusty, slippery, oily, towing, ramp"),
    (reason::REPEATED, 400, Status::InvalidArgument, "the request has 1 problem", "environments[1]", "\"normal\"", "name it once"),
    (reason::NO_SUCH_RESOURCE, 404, Status::NotFound, "there is no robot rover-9", "robot", "\"rover-9\"", "describe it: PUT /v1/robots/{robot}, or list those there are: GET /v1/robots"),
    (reason::BODY_TIMEOUT, 408, Status::DeadlineExceeded, "the body did not arrive within 10 s", "", "null", "send the whole body at once"),
    (reason::INCONSISTENT, 409, Status::InvalidArgument, "the request has 1 problem", "steering.turn_beyond_rad", "0.05", "use more than turn_tolerance_rad"),
    (reason::UNKNOWN_PRIOR, 409, Status::InvalidArgument, "the request has 1 problem", "prior", "\"wet-hall\"", "known: default, flat, thesis, thesis-20, empirical"),
    (reason::UNKNOWN_ENVIRONMENT, 409, Status::InvalidArgument, "the request has 1 problem", "environments[0]", "\"hall\"", "known: normal, bad"),
    (reason::BUILT_IN, 409, Status::FailedPrecondition, "default comes with the server and stays as it is", "prior", "\"default\"", "use another name"),
    (reason::NAME_TAKEN, 409, Status::AlreadyExists, "wet-hall is the name of a champion to come", "prior", "\"wet-hall\"", "choose another name"),
    (reason::PRIOR_IN_USE, 409, Status::FailedPrecondition, "robots use wet-hall", "robots", "\"rover-7\"", "give this robot another prior first"),
    (reason::EPOCH_SUPERSEDED, 409, Status::Aborted, "another agent has taken the robot over", "epoch", "3", "another agent drives this robot now: stop one of them; a restart takes over"),
    (reason::CLOCK_WENT_BACK, 409, Status::FailedPrecondition, "the robot's clock went back from 12.5 s to 3 s", "sent_s", "3.0", "begin a new epoch when the clock restarts"),
    (reason::OVERTAKEN, 409, Status::Aborted, "robot rover-7 rests: a stop has come after this resume", "robot", "\"rover-7\"", "find out who stopped it and why, then resume again"),
    (reason::UNREADABLE, 409, Status::FailedPrecondition, "robot rover-7 was written by version 0.3.0 and cannot be read", "robot", "\"rover-7\"", "start a server of the version that wrote it, or give it up: DELETE /v1/robots/rover-7"),
    (reason::IDEMPOTENCY_KEY_REUSED, 409, Status::FailedPrecondition, "this key came with another body before", "Idempotency-Key", "null", "use a new key for a new body"),
    (reason::NOT_ENDED, 409, Status::FailedPrecondition, "evolution-1 has not ended", "evolution", "\"evolution-1\"", "cancel it first: POST /v1/evolutions/{evolution}/cancel"),
    (reason::ENDED, 409, Status::FailedPrecondition, "evolution-1 has ended already", "evolution", "\"evolution-1\"", "remove it"),
    (reason::NOTHING_YET, 409, Status::FailedPrecondition, "no generation of evolution-1 has ended yet", "figure", "\"deviation\"", "ask again later"),
    (reason::ETAG_MISMATCH, 412, Status::Aborted, "it has changed", "If-Match", "\"5a\"", "get it again and see what changed"),
    (reason::ALREADY_THERE, 412, Status::AlreadyExists, "it exists already", "If-None-Match", "\"*\"", "leave the header out to replace it"),
    (reason::BODY_TOO_LARGE, 413, Status::InvalidArgument, "the body is too large", "", "null", "send at most 65536 bytes"),
    (reason::UNSUPPORTED_MEDIA_TYPE, 415, Status::InvalidArgument, "the body is not declared as JSON", "Content-Type", "\"text/plain\"", "send Content-Type: application/json"),
    (reason::UNSUPPORTED_ENCODING, 415, Status::InvalidArgument, "the body is compressed or encoded", "Content-Encoding", "\"gzip\"", "send the body as it is, without Content-Encoding"),
    (reason::QUEUE_FULL, 429, Status::ResourceExhausted, "robot rover-7 has 8 requests waiting", "", "8", "send one request per slot"),
    (reason::LIMIT_REACHED, 429, Status::ResourceExhausted, "the server has 100 event streams, which is the limit", "", "100", "end some of them"),
    (reason::DRAINING, 503, Status::Unavailable, "the server is shutting down", "", "null", "ask again once it has been started"),
    (reason::STORE_FAILED, 503, Status::Unavailable, "the journal of stops cannot be written", "", "null", "look at the disk of the server, then ask again"),
    (reason::TASK_DIED, 503, Status::Unavailable, "the task of robot rover-7 ended", "robot", "\"rover-7\"", "ask again; please report what the log says"),
    (reason::ROBOT_FAILED, 503, Status::Unavailable, "the computation of robot rover-7 does not end", "robot", "\"rover-7\"", "describe it anew: PUT /v1/robots/{robot}; please report what the log says"),
    (reason::NOT_TOLD, 503, Status::Unavailable, "1 of 3 robots could not be told", "robot", "\"rover-7\"", "ask again for this one"),
    (reason::TOKEN_MISSING, 401, Status::Unauthenticated, "this server wants a token", "Authorization", "null", "send Authorization: Bearer TOKEN"),
    (reason::TOKEN_WRONG, 401, Status::Unauthenticated, "this is not the token of this server", "Authorization", "null", "send Authorization: Bearer TOKEN"),
    (reason::FOREIGN_ORIGIN, 403, Status::PermissionDenied, "a web page of another origin may not ask here", "Origin", "\"http://evil.example\"", "start the server with --cors-origin"),
    (reason::FOREIGN_HOST, 403, Status::PermissionDenied, "this server is not known by that host", "Host", "\"evil.example\"", "start the server with --allowed-host"),
    (reason::FORM_REQUEST, 403, Status::PermissionDenied, "a form of any web page could have sent this", "X-Umwelt-Request", "null", "send X-Umwelt-Request: 1"),
    (reason::METHOD_NOT_ALLOWED, 405, Status::Unimplemented, "there is no PATCH at this path", "", "\"PATCH\"", "use one that Allow names"),
];

/// The name of the response with this code.
///
/// # Panics
/// Where no words are known for it: a mistake in the table of endpoints.
pub(super) fn name(code: u16) -> &'static str {
    let found = CODES.iter().find(|(known, ..)| *known == code);
    found.map(|(_, name, _)| *name).unwrap_or_else(|| panic!("no words for {code}"))
}

/// The responses by their names; the schemas that they use go into `schemas`.
pub(super) fn responses(schemas: &mut Schemas) -> Vec<(String, RefOr<Response>)> {
    let mut found =
        vec![(ErrorBody::name().into_owned(), <ErrorBody as utoipa::PartialSchema>::schema())];
    ErrorBody::schemas(&mut found);
    schemas.extend(found);
    let coded = CODES.iter().map(|&(code, name, words)| {
        let mut built = response(words, |of_reason| of_reason == code);
        if code == 429 {
            let seconds = ObjectBuilder::new()
                .schema_type(SchemaType::Type(Type::Integer))
                .minimum(Some(0.0));
            let header = HeaderBuilder::new()
                .schema(Some(seconds))
                .description(Some("Seconds to wait before asking again"));
            built = built.header("Retry-After", header.build());
        }
        (name.to_owned(), built.build().into())
    });
    let other = |code| CODES.iter().all(|(known, ..)| *known != code);
    let any = (ANY.to_owned(), response("Any other problem", other).build().into());
    coded.chain([any]).collect()
}

fn response(words: &str, is_meant: impl Fn(u16) -> bool) -> ResponseBuilder {
    let examples = REASONS.iter().filter(|sample| is_meant(sample.1)).map(|sample| {
        let example = ExampleBuilder::new().summary(about(sample.0)).value(Some(body(sample)));
        (sample.0, example.build())
    });
    let schema: RefOr<Schema> = Ref::from_schema_name(ErrorBody::name()).into();
    let content = ContentBuilder::new().schema(Some(schema)).examples_from_iter(examples);
    ResponseBuilder::new().description(words).content("application/json", content.build())
}

/// What a reason says, in words.
fn about(reason: &str) -> String {
    let known = reason::ALL.iter().find(|(name, _)| *name == reason);
    let words = known.map(|(_, words)| *words).unwrap_or_default();
    words.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
}

fn body(&(reason, code, status, message, field, value, remedy): &Sample) -> Value {
    let value: Value = serde_json::from_str(value).unwrap_or_default();
    let problem = Problem::new(status, message).with(Detail::new(reason, field, value, remedy));
    let mut body = ErrorBody::from(problem);
    body.error.code = code;
    serde_json::to_value(body).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Guards against a reason that the document does not list.
    #[test]
    fn every_reason_has_an_example() {
        let sample: BTreeSet<_> = REASONS.iter().map(|sample| sample.0).collect();
        let all: BTreeSet<_> = reason::ALL.iter().map(|(name, _)| *name).collect();
        assert_eq!((sample.len(), &sample), (REASONS.len(), &all));
        for sample in &REASONS {
            assert!(serde_json::from_str::<Value>(sample.5).is_ok(), "{}", sample.0);
            assert!(about(sample.0).ends_with('.'), "{}: {}", sample.0, about(sample.0));
        }
    }
}
