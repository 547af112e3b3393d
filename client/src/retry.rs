//! Which calls are sent again by themselves, and when: those that the server refused as UNAVAILABLE, nothing else.

use crate::call::Call;
use crate::error::Error;
use bytes::Bytes;
use std::time::Duration;
use tower::retry::Policy;
use tower::util::rng::{HasherRng, Rng};

/// How often a call is sent again: with the waits below about 3 s in all, then a person should look.
pub(crate) const MAX_RETRIES: u32 = 4;

/// Mean wait before the first retry: about the round trip of a bad link.
const FIRST_WAIT: Duration = Duration::from_millis(200);

/// Longest mean wait: a server that is back is noticed within as much.
const LONGEST_WAIT: Duration = Duration::from_secs(5);

/// The policy of the client's stack.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unavailable {
    tries: u32,
    random: HasherRng,
}

impl Policy<Call, Bytes, Error> for Unavailable {
    type Future = tokio::time::Sleep;

    fn retry(
        &mut self,
        call: &mut Call,
        result: &mut Result<Bytes, Error>,
    ) -> Option<Self::Future> {
        let Err(Error::Problem { problem, retry_after, .. }) = result else { return None };
        if !problem.status.is_retried() || call.retries_left == 0 {
            return None;
        }
        let wait = backoff(self.tries, self.random.next_f64()).max(retry_after.unwrap_or_default());
        // A wait beyond the deadline would turn what the server said into a mere time-out.
        if wait >= call.left() {
            return None;
        }
        self.tries += 1;
        call.retries_left -= 1;
        Some(tokio::time::sleep(wait))
    }

    fn clone_request(&mut self, call: &Call) -> Option<Call> {
        Some(call.clone())
    }
}

/// The wait after `tries` failed ones: doubling, between half and one and a half of the mean, so that many
/// clients of a server that comes back do not come at once. `random` is in [0, 1).
pub(crate) fn backoff(tries: u32, random: f64) -> Duration {
    let mean = FIRST_WAIT.saturating_mul(1 << tries.min(16)).min(LONGEST_WAIT);
    mean.mul_f64(0.5 + random)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use reqwest::Method;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};
    use tokio::time::Instant;
    use tower::ServiceExt;
    use umwelt_api::problem::{Problem, Status};

    fn problem(status: Status, retry_after: Option<u64>) -> Error {
        let retry_after = retry_after.map(Duration::from_secs);
        Error::Problem {
            what: "GET http://h/".into(),
            problem: Problem::new(status, ""),
            retry_after,
        }
    }

    /// Calls a service that fails with `error` the first `failures` times; what came back and how often it was asked.
    async fn asked(error: Error, failures: u32, allowed: Duration) -> (Result<Bytes, Error>, u32) {
        let asked = Arc::new(AtomicU32::new(0));
        let inner = {
            let asked = Arc::clone(&asked);
            tower::service_fn(move |_: Call| {
                let before = asked.fetch_add(1, Ordering::Relaxed);
                let answer = if before < failures { Err(error.clone()) } else { Ok(Bytes::new()) };
                std::future::ready(answer)
            })
        };
        let url = "http://h/".parse().unwrap();
        let call = Call::new(Method::GET, url, allowed, MAX_RETRIES);
        let answer = crate::client::stack(inner).oneshot(call).await;
        (answer, asked.load(Ordering::Relaxed))
    }

    const MINUTE: Duration = Duration::from_secs(60);

    #[tokio::test(start_paused = true)]
    async fn unavailable_is_asked_again_until_it_is_available() {
        let (answer, asked) = asked(problem(Status::Unavailable, None), 2, MINUTE).await;
        assert_eq!((answer.is_ok(), asked), (true, 3));
    }

    #[tokio::test(start_paused = true)]
    async fn unavailable_is_asked_again_a_limited_number_of_times() {
        let (answer, asked) = asked(problem(Status::Unavailable, None), u32::MAX, MINUTE).await;
        assert_eq!(answer.unwrap_err().status(), Some(Status::Unavailable));
        assert_eq!(asked, 1 + MAX_RETRIES);
    }

    #[tokio::test(start_paused = true)]
    async fn nothing_else_is_asked_again() {
        let statuses = Status::ALL.into_iter().filter(|status| *status != Status::Unavailable);
        let what = "GET http://h/";
        let others = [
            crate::error::late(what, MINUTE),
            Error::Protocol { what: what.into(), why: String::new() },
            Error::BadCall { what: what.into(), why: String::new() },
        ];
        for error in statuses.map(|status| problem(status, Some(1))).chain(others) {
            let (answer, asked) = asked(error.clone(), u32::MAX, MINUTE).await;
            assert_eq!((answer, asked), (Err(error), 1));
        }
    }

    #[tokio::test(start_paused = true)]
    async fn retry_after_is_honoured() {
        let before = Instant::now();
        let (answer, asked) = asked(problem(Status::Unavailable, Some(7)), 1, MINUTE).await;
        assert_eq!((answer.is_ok(), asked), (true, 2));
        assert!(before.elapsed() >= Duration::from_secs(7));
    }

    #[tokio::test(start_paused = true)]
    async fn no_call_waits_beyond_the_deadline() {
        let before = Instant::now();
        let (answer, asked) = asked(problem(Status::Unavailable, Some(90)), 1, MINUTE).await;
        assert_eq!(answer.unwrap_err().status(), Some(Status::Unavailable));
        assert_eq!((asked, before.elapsed()), (1, Duration::ZERO));
    }

    proptest! {
        #[test]
        fn backoff_is_bounded(tries in 0u32.., random in 0.0..1.0) {
            let wait = backoff(tries, random);
            prop_assert!(wait >= FIRST_WAIT / 2);
            prop_assert!(wait <= LONGEST_WAIT.mul_f64(1.5));
            prop_assert!(backoff(tries.saturating_add(1), random) >= wait);
        }
    }
}
