//! The round trip of requests, as the robot sees it: how many may be on their way, and when a connection has stalled.

use crate::geometry::elementary::{least, most};
use crate::horizon::SLOT;
use crate::time::RobotTime;

/// Requests in flight on one connection of an ordinary link: they cover the nominal loop of 100 ms at one per slot.
pub const IN_FLIGHT: usize = 4;

/// Most requests in flight on one connection: at a round trip of 0.56 s and more.
pub const MAX_IN_FLIGHT: usize = 16;

/// On an ordinary link a connection has stalled whose oldest request waits longer than this many s.
pub const STALL: f64 = 0.25;

/// Round trip in s up to which a link is an ordinary one.
const ORDINARY: f64 = 0.2;

/// Time in s by which a request may wait longer per s that the round trip is longer.
const PATIENCE: f64 = 2.0;

/// Longest round trip in s that counts: beyond it no link is controlled by.
const LONGEST: f64 = 2.0;

/// Factor by which each reply moves what is known of the round trip toward its own: so it follows their median, after a
/// dozen replies on another route.
const STEP: f64 = 1.15;

/// Replies within this many s come together: one held them all back.
const TOGETHER: f64 = 0.005;

/// What is known of the round trip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trip {
    /// About the median in s.
    median: f64,
    /// When the last reply came.
    replied: RobotTime,
}

impl Trip {
    /// Nothing yet.
    pub(super) fn new() -> Self {
        Self { median: SLOT, replied: RobotTime::BEFORE_ALL }
    }

    /// Time in s that the oldest request on a connection may wait before that has stalled.
    pub(super) fn stall(&self) -> f64 {
        STALL + PATIENCE * self.beyond()
    }

    /// Time in s by which the round trip is longer than that of an ordinary link.
    fn beyond(&self) -> f64 {
        most(0.0, self.median - ORDINARY)
    }

    /// Requests that may be in flight on one connection: one more per slot that the round trip is longer.
    pub(super) fn most_in_flight(&self) -> usize {
        (IN_FLIGHT + (self.beyond() / SLOT) as usize).min(MAX_IN_FLIGHT)
    }

    /// A reply came at `now` to a request sent at `sent`.
    pub(super) fn follow(&mut self, now: RobotTime, sent: RobotTime) {
        let together = now - self.replied < TOGETHER;
        self.replied = now;
        if together {
            return;
        }
        let (trip, median) = (now - sent, self.median);
        let followed = least(most(trip, median / STEP), median * STEP);
        self.median = least(most(followed, SLOT), LONGEST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is known after replies at one per slot, each after `trip(i)` s, those behind a late one held back by it.
    fn after(count: u32, trip: impl Fn(u32) -> f64) -> Trip {
        let (mut known, mut last) = (Trip::new(), RobotTime::BEFORE_ALL);
        for i in 0..count {
            let sent = RobotTime::new(f64::from(i) * SLOT);
            last = (sent + trip(i)).later(last);
            known.follow(last, sent);
        }
        known
    }

    #[test]
    fn an_ordinary_link_has_four_in_flight_and_a_quarter_of_a_second() {
        for trip in [0.0, 0.01, 0.1, 0.19] {
            let known = after(100, |_| trip);
            assert_eq!((known.most_in_flight(), known.stall()), (IN_FLIGHT, STALL), "{trip}");
        }
    }

    /// Guards against: over a slow link every request counts as stalled, and each gets a connection of its own.
    #[test]
    fn a_slow_link_has_more_in_flight_and_more_patience() {
        let known = after(30, |_| 0.7);
        assert_eq!(known.most_in_flight(), MAX_IN_FLIGHT);
        assert!((known.stall() - 1.25).abs() < 1e-9);
        let back = after(130, |i| if i < 60 { 0.7 } else { 0.05 });
        assert_eq!((back.most_in_flight(), back.stall()), (IN_FLIGHT, STALL));
    }

    #[test]
    fn late_packets_and_those_behind_them_change_nothing() {
        let known = after(400, |i| if i % 20 == 10 { 0.44 } else { 0.04 });
        assert_eq!((known.most_in_flight(), known.stall()), (IN_FLIGHT, STALL));
    }
}
