//! The robot's own clock: monotonic, in s, compared with no other machine's.

use rustix::time::{ClockId, clock_gettime};
use std::time::Duration;
use tokio::time::Instant;

/// What a wait adds so that rounding never wakes it before its time; a waiting loop would spin.
const MARGIN: Duration = Duration::from_nanos(1_000);

/// Longest wait in s that is asked for at once.
const LONGEST_WAIT: f64 = 3600.0;

/// Robot time in s. It follows tokio's clock, so a paused one drives the robot in simulated time.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    origin: Instant,
    at_origin: f64,
}

impl Clock {
    /// A clock that shows 0 now.
    pub fn start() -> Self {
        Self { origin: Instant::now(), at_origin: 0.0 }
    }

    /// The host's monotonic clock (`CLOCK_MONOTONIC`), what Python's `time.monotonic()` shows: for programs on the
    /// same host that stamp poses with it.
    pub fn host() -> Self {
        let origin = Instant::now();
        let now = clock_gettime(ClockId::Monotonic);
        Self { origin, at_origin: now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9 }
    }

    /// Robot time in s.
    pub fn now(&self) -> f64 {
        self.at_origin + self.origin.elapsed().as_secs_f64()
    }

    /// When to wake for robot time `time`: then [`Clock::now`] is at least `time`, unless that is over an hour away.
    pub(crate) fn instant(&self, time: f64) -> Instant {
        let wait = (time - self.now()).min(LONGEST_WAIT);
        if wait <= 0.0 {
            return Instant::now();
        }
        self.origin + Duration::from_secs_f64(self.now() - self.at_origin + wait) + MARGIN
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn a_wait_is_never_too_short() {
        let mut clock = Clock::start();
        for at_origin in [0.0, 1e6 + 0.123_456_789] {
            clock.at_origin = at_origin;
            for slot in 1..200 {
                let time = at_origin + f64::from(slot) * 0.03;
                tokio::time::sleep_until(clock.instant(time)).await;
                assert!(clock.now() >= time);
                assert!(at_origin > 0.0 || clock.now() < time + 0.002);
            }
        }
    }

    #[test]
    fn the_hosts_clock_is_the_hosts() {
        let before = clock_gettime(ClockId::Monotonic);
        let shown = Clock::host().now();
        let after = clock_gettime(ClockId::Monotonic);
        assert!(shown >= before.tv_sec as f64 - 1e-3 && shown <= after.tv_sec as f64 + 1.001);
    }
}
