//! The last word wins: which of the stops and resumes of a robot holds.
//!
//! Pure: no clock, no channel, no lock. Every request takes its place in the order when it arrives, before it waits for
//! anything; what it then has to wait for does not change that place. A stop acts where it arrives. A resume acts once it
//! is kept, and not any more where a stop has arrived after it.

use std::sync::atomic::{AtomicU64, Ordering};

/// The place of a request in the order in which stops and resumes arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Arrival(pub(crate) u64);

impl Arrival {
    /// Before any request: a robot that has never been stopped.
    const NONE: Self = Self(0);
    /// The stop that a robot brings from an earlier run of the server.
    const EARLIER: Self = Self(1);
}

/// Gives each request its place. One for all robots: a stop of all has one place, whichever robot it comes to first.
#[derive(Debug)]
pub(crate) struct Arrivals(AtomicU64);

impl Arrivals {
    /// Counts on above `last`, the highest place that an earlier run of the server has written down.
    pub(crate) fn after(last: u64) -> Self {
        Self(AtomicU64::new(last.max(Arrival::EARLIER.0)))
    }

    /// The place of a request that arrives now.
    pub(crate) fn next(&self) -> Arrival {
        Arrival(self.0.fetch_add(1, Ordering::SeqCst) + 1)
    }

    /// The place given last.
    pub(crate) fn newest(&self) -> Arrival {
        Arrival(self.0.load(Ordering::SeqCst))
    }
}

/// A stop arrived after the resume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Overtaken;

/// What a robot was told of stopping and going on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StopOrder {
    /// The last stop that arrived.
    stop: Arrival,
    /// The last resume that took effect.
    resume: Arrival,
}

impl StopOrder {
    /// A robot that was `stopped` by an earlier run of the server, or not.
    pub(crate) fn new(stopped: bool) -> Self {
        let stop = if stopped { Arrival::EARLIER } else { Arrival::NONE };
        Self { stop, resume: Arrival::NONE }
    }

    /// A stop has arrived: it holds at once, unless a resume that arrived after it has taken effect already.
    pub(crate) fn stop(&mut self, arrival: Arrival) {
        self.stop = self.stop.max(arrival);
    }

    /// A resume takes effect, once it is kept.
    ///
    /// # Errors
    /// Where a stop has arrived after it; nothing changes then.
    pub(crate) fn resume(&mut self, arrival: Arrival) -> Result<(), Overtaken> {
        if self.is_overtaken(arrival) {
            return Err(Overtaken);
        }
        self.resume = self.resume.max(arrival);
        Ok(())
    }

    /// Whether a stop has arrived after a resume.
    pub(crate) fn is_overtaken(&self, resume: Arrival) -> bool {
        self.stop > resume
    }

    /// Whether the robot is to rest.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop > self.resume
    }

    /// The last resume that took effect.
    pub(crate) fn resumed(&self) -> Arrival {
        self.resume
    }

    /// The last word that this is made of.
    pub(crate) fn newest(&self) -> Arrival {
        self.stop.max(self.resume)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against a model that remembers every request: whatever order they take effect in, a robot rests exactly
        /// where, of the stops that have arrived and the resumes that took effect, the last to arrive is a stop; and a
        /// resume takes effect exactly where no stop that was there already had arrived after it.
        #[test]
        fn the_last_word_wins(
            was_stopped in any::<bool>(),
            // Requests in the order in which they arrive, and when each one's waiting is over.
            requests in prop::collection::vec((any::<bool>(), 0u32..40), 1..24),
        ) {
            let arrivals = Arrivals::after(0);
            let mut order = StopOrder::new(was_stopped);
            let mut said = vec![(Arrival(1), was_stopped)];
            // A stop acts where it arrives; a resume later.
            let mut moments: Vec<(u32, Arrival, bool)> = Vec::new();
            for (at, &(stop, wait)) in requests.iter().enumerate() {
                let at = at as u32;
                moments.push((at + if stop { 0 } else { wait }, arrivals.next(), stop));
            }
            moments.sort();
            for (_, arrival, stop) in moments {
                if stop {
                    order.stop(arrival);
                    said.push((arrival, true));
                } else {
                    let overtaken = said.iter().any(|&(other, stop)| stop && other > arrival);
                    prop_assert_eq!(order.is_overtaken(arrival), overtaken);
                    prop_assert_eq!(order.resume(arrival).is_err(), overtaken);
                    if !overtaken {
                        said.push((arrival, false));
                    }
                }
                let last = said.iter().max().copied().unwrap_or((Arrival(0), false));
                prop_assert_eq!(order.is_stopped(), last.1, "{:?}", said);
            }
        }
    }
}
