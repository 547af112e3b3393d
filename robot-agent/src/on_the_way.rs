//! What is on its way over a simulated link, in the order of its arrival.

use std::collections::VecDeque;

/// Things with the robot time in s at which each arrives.
#[derive(Debug)]
pub(crate) struct OnTheWay<T>(VecDeque<(f64, T)>);

impl<T> OnTheWay<T> {
    /// Nothing yet.
    pub(crate) fn new() -> Self {
        Self(VecDeque::new())
    }

    /// When the first arrives.
    pub(crate) fn next(&self) -> f64 {
        self.0.front().map_or(f64::INFINITY, |(at, _)| *at)
    }

    /// Takes out the first of what has arrived by `now`.
    pub(crate) fn due(&mut self, now: f64) -> Option<T> {
        let arrived = self.next() <= now;
        if arrived { self.0.pop_front().map(|(_, what)| what) } else { None }
    }

    /// Puts in what will arrive, behind all that arrives no later.
    pub(crate) fn put(&mut self, arrival: f64, what: T) {
        let place = self.0.iter().rposition(|(at, _)| *at <= arrival).map_or(0, |at| at + 1);
        self.0.insert(place, (arrival, what));
    }

    /// All of it is lost.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}
