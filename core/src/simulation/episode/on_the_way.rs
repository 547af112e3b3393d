//! What is on its way, in the order in which it arrives.

use crate::geometry::elementary::least;
use std::collections::VecDeque;

/// Room for packets on their way in one direction; more are on their way in long silences only.
pub const ON_THEIR_WAY: usize = 32;

/// Packets on their way. They are large: each stays in its place, and places are used again.
pub struct Packets<T> {
    /// Their places.
    pub arrivals: Queue<usize>,
    places: Vec<T>,
    free: Vec<usize>,
}

impl<T: Clone> Packets<T> {
    /// None yet; `empty` is what a place holds before it is first written.
    pub fn new(empty: T) -> Self {
        Self {
            arrivals: Queue::with_capacity(ON_THEIR_WAY),
            places: vec![empty; ON_THEIR_WAY],
            free: (0..ON_THEIR_WAY).rev().collect(),
        }
    }

    /// Where to write the packet that is sent next.
    pub fn place(&mut self) -> &mut T {
        let place = *self.free.last().expect("there always is one");
        &mut self.places[place]
    }

    /// Sends what was written, to arrive at `arrival`, behind all that arrives no later.
    pub fn send(&mut self, arrival: f64) {
        let Some(place) = self.free.pop() else { return };
        if self.free.is_empty() {
            self.free.push(self.places.len());
            self.places.push(self.places[place].clone());
        }
        self.arrivals.insert(arrival, place);
    }

    /// Takes out the first of what has arrived by `now`.
    pub fn due(&mut self, now: f64) -> Option<&T> {
        let place = self.arrivals.due(now)?;
        self.free.push(place);
        Some(&self.places[place])
    }
}

/// What comes at some time, in the order of the times.
pub struct Queue<T> {
    /// When the first comes; never where there is none.
    pub first: f64,
    items: VecDeque<(f64, T)>,
}

impl<T> Queue<T> {
    /// Nothing yet, with room for `capacity`.
    pub fn with_capacity(capacity: usize) -> Self {
        Self { first: f64::INFINITY, items: VecDeque::with_capacity(capacity) }
    }

    /// Puts `item`, which comes at `at`, behind all that come no later.
    pub fn insert(&mut self, at: f64, item: T) {
        let later = self.items.iter().rev().take_while(|(other, _)| *other > at).count();
        if later == 0 {
            self.items.push_back((at, item));
        } else {
            self.items.insert(self.items.len() - later, (at, item));
        }
        self.first = least(self.first, at);
    }

    /// Takes out the first of what has come by `now`.
    pub fn due(&mut self, now: f64) -> Option<T> {
        if self.first > now {
            return None;
        }
        let (_, item) = self.items.pop_front()?;
        self.first = self.items.front().map_or(f64::INFINITY, |(at, _)| *at);
        Some(item)
    }
}
