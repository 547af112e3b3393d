//! How poses arrive: one by one as they are taken, or many at once, or long after.
//!
//! Either is obeyed as well as it can be; but a robot is steered blind in between, so it is said, with the remedy.

use crate::throttle::Throttle;
use umwelt_core::horizon::SLOT;

/// Poses that follow each other within this many s were not taken so: they were held up and written at once. No
/// tracker is faster.
const TOGETHER: f64 = 0.001;

/// Fewest poses of a burst.
const MANY: u32 = 3;

/// A time in s without a pose, beyond which poses that come together are a burst and not a fast camera.
const GAP: f64 = 3.0 * SLOT;

/// Age in s of a pose beyond that of any camera's exposure and processing (0.2 s), that is of little use.
const STALE: f64 = 0.5;

/// Time in s over which not even the freshest pose is fresher than [`STALE`].
const WATCHED: f64 = 1.0;

/// Time in s between two lines about the same thing: it lasts until someone changes the tracker.
const QUIET: f64 = 10.0;

/// What is wrong with how poses arrive.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(super) enum Complaint {
    #[error(
        "{count} poses came at once after {gap:.2} s without one: the robot is steered blind in between. Write each \
         pose when it is taken and flush it (Python: print(..., flush=True); C: fflush(stdout); others: stdbuf -oL)"
    )]
    Burst { count: u32, gap: f64 },
    #[error(
        "poses are {age:.2} s old when they come: the robot is steered by where it was. Stamp them with this host's \
         monotonic clock (Python: time.monotonic()) when they are taken, and write each at once"
    )]
    Stale { age: f64 },
}

/// Follows the arrivals of one tracker.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrivals {
    last: Option<f64>,
    /// The poses that came together last, and the time in s without one before them.
    together: u32,
    gap: f64,
    /// The least age in s since `watched`.
    freshest: f64,
    watched: f64,
    bursts: Throttle,
    stale: Throttle,
}

impl Arrivals {
    pub(super) fn new() -> Self {
        Self {
            last: None,
            together: 0,
            gap: 0.0,
            freshest: f64::INFINITY,
            watched: f64::NEG_INFINITY,
            bursts: Throttle::every(QUIET),
            stale: Throttle::every(QUIET),
        }
    }

    /// A pose taken at `taken` arrives at `now`: what to say about it, and how often it stayed unsaid before.
    pub(super) fn take(&mut self, now: f64, taken: f64) -> Option<(Complaint, u64)> {
        let burst = self.burst(now).and_then(|it| self.bursts.ask(now).map(|unsaid| (it, unsaid)));
        burst.or_else(|| {
            let stale = self.stale(now, now - taken)?;
            self.stale.ask(now).map(|unsaid| (stale, unsaid))
        })
    }

    /// The burst that is over with the pose at `now`.
    fn burst(&mut self, now: f64) -> Option<Complaint> {
        let since = self.last.map_or(f64::INFINITY, |last| now - last);
        self.last = Some(now);
        if since < TOGETHER {
            self.together += 1;
            return None;
        }
        let (count, gap) = (self.together, self.gap);
        (self.together, self.gap) = (1, if since.is_finite() { since } else { 0.0 });
        (count >= MANY && gap >= GAP).then_some(Complaint::Burst { count, gap })
    }

    fn stale(&mut self, now: f64, age: f64) -> Option<Complaint> {
        self.freshest = self.freshest.min(age);
        if now < self.watched + WATCHED {
            return None;
        }
        let is_first = self.watched.is_infinite();
        let age = std::mem::replace(&mut self.freshest, f64::INFINITY);
        self.watched = now;
        (age > STALE && !is_first).then_some(Complaint::Stale { age })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said about poses taken `rate` times a second, written every `held` s, `late` s after they were taken.
    fn said(rate: f64, held: f64, late: f64) -> Vec<Complaint> {
        let (mut arrivals, mut said) = (Arrivals::new(), Vec::new());
        let mut latest = 0.0_f64;
        for frame in 0..(30.0 * rate) as u32 {
            let taken = f64::from(frame) / rate;
            let written = if held > 0.0 { (taken / held + 1e-9).ceil() * held } else { taken };
            // Each takes the loop some microseconds.
            latest = (latest + 2e-5).max(written + late);
            said.extend(arrivals.take(latest, taken).map(|(complaint, _)| complaint));
        }
        said
    }

    #[test]
    fn bursts_are_said_with_their_size_at_any_rate() {
        for (rate, held) in [(33.0, 0.5), (100.0, 0.25), (240.0, 0.2), (1000.0, 0.1), (100.0, 1.0)]
        {
            let said = said(rate, held, 0.0);
            assert!((2..=3).contains(&said.len()), "{} times in 30 s at {rate} per s", said.len());
            for complaint in said {
                let Complaint::Burst { count, gap } = complaint else { panic!("{complaint}") };
                assert!(
                    (f64::from(count) - rate * held).abs() <= 1.5,
                    "{count} of {rate} x {held}"
                );
                assert!((gap - held).abs() < 0.1 * held, "{gap} of {held}");
            }
        }
    }

    #[test]
    fn poses_that_come_one_by_one_are_said_nothing_about() {
        for rate in [1.0, 5.0, 10.0, 33.0, 60.0, 120.0, 240.0] {
            assert_eq!(said(rate, 0.0, 0.2), [], "{rate} per s");
        }
    }

    #[test]
    fn poses_that_are_always_old_are_said_so() {
        let said = said(33.0, 0.0, 0.8);
        assert!((2..=3).contains(&said.len()));
        assert!(
            said.iter()
                .all(|it| matches!(it, Complaint::Stale { age } if (age - 0.8).abs() < 1e-3))
        );
    }
}
