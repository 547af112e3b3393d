//! Until a condition holds, within a deadline.

use std::time::{Duration, Instant};

/// Time between two looks: short against everything that is waited for, long against a request on loopback.
const PAUSE: Duration = Duration::from_millis(10);

/// Looks until `look` finds something.
///
/// # Panics
/// Where it finds nothing `within` the time; `what` says what was waited for.
pub async fn until<T>(what: &str, within: Duration, mut look: impl AsyncFnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + within;
    loop {
        if let Some(found) = look().await {
            return found;
        }
        assert!(Instant::now() < deadline, "not within {within:?}: {what}");
        tokio::time::sleep(PAUSE).await;
    }
}

/// The output of `future`.
///
/// # Panics
/// Where it does not come `within` the time; `what` says what was waited for.
pub async fn within<T>(what: &str, within: Duration, future: impl Future<Output = T>) -> T {
    match tokio::time::timeout(within, future).await {
        Ok(output) => output,
        Err(_) => panic!("not within {within:?}: {what}"),
    }
}
