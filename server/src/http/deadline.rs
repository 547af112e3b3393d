//! How long an answer may take: `grpc-timeout`, clamped, or the server's own.

use crate::resource::failure::Failure;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::time::Duration;
use umwelt_api::problem::{Detail, Problems, Status, reason};

const HEADER: &str = "grpc-timeout";

/// How long answers may take.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deadlines {
    /// Where the request does not say.
    pub(crate) usual: Duration,
    /// Whatever it says.
    pub(crate) longest: Duration,
}

/// Answers DEADLINE_EXCEEDED where the route does not answer in time. A stream need only begin in time.
pub(crate) async fn keep(
    State(Deadlines { usual, longest }): State<Deadlines>,
    request: Request,
    next: Next,
) -> Response {
    let deadline = match read(request.headers()) {
        Ok(asked) => asked.unwrap_or(usual).min(longest),
        Err(problems) => return Failure::from(problems).into_response(),
    };
    match tokio::time::timeout(deadline, next.run(request)).await {
        Ok(response) => response,
        Err(_) => {
            let message = format!("no answer within {} s", deadline.as_secs_f64());
            Failure::new(Status::DeadlineExceeded, message).into_response()
        }
    }
}

fn read(headers: &HeaderMap) -> Result<Option<Duration>, Problems> {
    let Some(value) = headers.get(HEADER) else { return Ok(None) };
    let text = value.to_str().unwrap_or_default();
    if let Some(timeout) = parse(text) {
        return Ok(Some(timeout));
    }
    let remedy = "use 1 to 8 digits and one of H, M, S, m, u, n, as in 500m for half a second";
    Err(Detail::new(reason::MALFORMED, HEADER, text, remedy).into())
}

/// 1 to 8 digits and a unit: hour, minute, second, milli-, micro-, nanosecond.
fn parse(text: &str) -> Option<Duration> {
    let (end, unit) = text.char_indices().next_back()?;
    let digits = &text[..end];
    if digits.is_empty() || digits.len() > 8 || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let count: u64 = digits.parse().ok()?;
    match unit {
        'H' => Some(Duration::from_secs(count * 3600)),
        'M' => Some(Duration::from_secs(count * 60)),
        'S' => Some(Duration::from_secs(count)),
        'm' => Some(Duration::from_millis(count)),
        'u' => Some(Duration::from_micros(count)),
        'n' => Some(Duration::from_nanos(count)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_of_grpc_is_read() {
        assert_eq!(parse("2H"), Some(Duration::from_secs(7200)));
        assert_eq!(parse("3M"), Some(Duration::from_secs(180)));
        assert_eq!(parse("4S"), Some(Duration::from_secs(4)));
        assert_eq!(parse("500m"), Some(Duration::from_millis(500)));
        assert_eq!(parse("7u"), Some(Duration::from_micros(7)));
        assert_eq!(parse("99999999n"), Some(Duration::from_nanos(99_999_999)));
        assert_eq!(parse("99999999H"), Some(Duration::from_secs(99_999_999 * 3600)));
    }

    #[test]
    fn nothing_else_is() {
        for text in ["", "5", "S", "-1S", "+1S", "1.5S", "123456789S", "1s", "1 S", "1ä", "ä"] {
            assert_eq!(parse(text), None, "{text:?}");
        }
    }
}
