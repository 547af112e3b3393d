//! What is believed of the link: loop delay (normal on its logarithm) and late packets (beta-Bernoulli).

use super::estimate::{LEVEL, LinkEstimate};
use super::status::{Status, progress};
use crate::conjugate::{BetaBernoulli, NormalInverseChiSquared};
use crate::exchange::{Delivery, Observation};
use crate::geometry::elementary::{exp, ln};
use crate::horizon::SLOT;
use crate::time::RobotTime;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// A delivery is late when its loop delay is above the median by more than this many slots.
const LATE_SLOTS: f64 = 3.0;

/// Deliveries at the same instant as a late one, to this many s, were held back behind it.
const SAME_INSTANT: f64 = 0.010;

/// Late probability of the link that `chance_of_luck` speaks of: the thesis's bad one.
const BAD_LATE: f64 = 0.05;

/// Chance of luck from which on a record without late packets says something.
const LUCK: f64 = 0.05;

/// Loop delays are physical above this many s; a shorter one counts as this.
const SHORTEST: f64 = 1e-3;

/// Requests remembered to know when their pose was taken.
const REQUESTS: usize = 32;

/// What is believed of one robot's link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinkBelief {
    /// ln of the loop delay in s, of packets neither late nor held back.
    ln_delay: NormalInverseChiSquared,
    late: BetaBernoulli,
    deliveries: u64,
    late_deliveries: u64,
    /// (sequence, when its newest pose was taken).
    requests: VecDeque<(u64, RobotTime)>,
    /// When the last late delivery arrived.
    late_arrival: Option<RobotTime>,
}

/// A loop of 0.2 s, give or take a factor of 1.5, worth one tenth of a delivery.
fn prior_ln_delay() -> NormalInverseChiSquared {
    NormalInverseChiSquared::new(0.2_f64.ln(), 0.1, 3.0, 3.0 * 0.16)
        .expect("constants in their domain")
}

impl Default for LinkBelief {
    fn default() -> Self {
        Self {
            ln_delay: prior_ln_delay(),
            // One late packet in twenty, worth two packets.
            late: BetaBernoulli::new(0.1, 1.9).expect("constants in their domain"),
            deliveries: 0,
            late_deliveries: 0,
            requests: VecDeque::with_capacity(REQUESTS),
            late_arrival: None,
        }
    }
}

impl LinkBelief {
    /// Remembers when the newest pose of a request was taken.
    pub fn request(&mut self, sequence: u64, newest: Option<&Observation>) {
        let Some(newest) = newest else { return };
        if self.requests.len() >= REQUESTS {
            self.requests.pop_front();
        }
        self.requests.push_back((sequence, newest.taken));
    }

    /// Takes in a reported delivery.
    ///
    /// Late packets are above the median by more than three slots. Those that arrive in the same instant behind a
    /// late one were only held back: on a link that keeps the order they were not late themselves, or they would
    /// have come later still. They count as not late, and say nothing of the ordinary delay.
    pub fn update(&mut self, delivery: &Delivery) {
        let delay = delivery.loop_delay.max(SHORTEST);
        self.deliveries += 1;
        let asked = self.requests.iter().rev().find(|(sequence, _)| *sequence == delivery.sequence);
        let arrival = asked.map(|(_, taken)| *taken + delivery.loop_delay);
        let held_back = arrival
            .zip(self.late_arrival)
            .is_some_and(|(arrival, late)| (arrival - late).abs() < SAME_INSTANT);
        let ln_delay = ln(delay);
        // What is not above the median is not late either, and needs no exponential to be known as such.
        let is_late = !held_back
            && ln_delay > self.ln_delay.mu()
            && delay > self.median() + LATE_SLOTS * SLOT;
        self.late = self.late.update(is_late);
        if is_late {
            self.late_deliveries += 1;
            self.late_arrival = arrival;
        } else if !held_back {
            self.ln_delay = self.ln_delay.update(ln_delay);
        }
    }

    /// Forgets times of the robot's clock, keeps what they taught.
    pub fn restart_clock(&mut self) {
        self.requests.clear();
        self.late_arrival = None;
    }

    fn median(&self) -> f64 {
        exp(self.ln_delay.mu())
    }

    /// How far the estimate of the loop delay has got: as with a channel, the less of mean and variance of its logarithm.
    fn delay_status(&self) -> Status {
        let (prior, posterior) = (prior_ln_delay(), self.ln_delay);
        let of_mean = progress(posterior.k() - prior.k(), prior.k());
        let of_variance = progress(posterior.r() - prior.r(), prior.r());
        Status::of(of_mean.min(of_variance))
    }

    /// How far the estimate of the probability of late packets has got. The prior is worth two deliveries, but none late of
    /// a few says little: it takes n with 0.95^n = 0.05, which is 58, until a link with 5 % late packets would have shown one.
    fn late_status(&self) -> Status {
        let enough = LUCK.ln() / (1.0 - BAD_LATE).ln();
        Status::of(progress(self.deliveries as f64, enough))
    }

    /// As it is shown.
    pub fn estimate(&self) -> LinkEstimate {
        let seen = self.deliveries > 0;
        LinkEstimate {
            samples: self.deliveries,
            median: seen.then(|| self.median()),
            p99: seen.then(|| self.ln_delay.predictive_interval(0.98).1.exp()),
            late: self.late_deliveries,
            late_probability: self.late.predictive(),
            late_interval: self.late.interval(LEVEL),
            chance_of_luck: (self.deliveries as f64 * (1.0 - BAD_LATE).ln()).exp(),
            delay_status: self.delay_status(),
            late_status: self.late_status(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    /// One pose per slot, answered after `delay(i)`; in order, so nothing overtakes.
    fn learn(count: u64, delay: impl Fn(u64) -> f64) -> LinkEstimate {
        let mut belief = LinkBelief::default();
        let mut last_arrival = RobotTime::BEFORE_ALL;
        for i in 0..count {
            let taken = RobotTime::new(i as f64 * SLOT);
            belief.request(i, Some(&Observation { pose: Pose::default(), taken }));
            let arrival = (taken + delay(i)).later(last_arrival);
            last_arrival = arrival;
            belief.update(&Delivery { sequence: i, loop_delay: arrival - taken });
        }
        belief.estimate()
    }

    #[test]
    fn a_steady_link_shows_its_median_and_nothing_late() {
        let estimate = learn(200, |_| 0.17);
        assert!((estimate.median.expect("seen") - 0.17).abs() < 1e-3);
        assert_eq!(estimate.late, 0);
        assert!((estimate.chance_of_luck - 0.95_f64.powi(200)).abs() < 1e-12);
    }

    #[test]
    fn a_delay_is_known_sooner_than_that_packets_are_not_late() {
        let statuses = |count| {
            let estimate = learn(count, |_| 0.17);
            (estimate.delay_status, estimate.late_status)
        };
        let none = Status::Estimating { fraction: 0.0 };
        assert_eq!(statuses(0), (none, none));
        assert_eq!(statuses(2).0, Status::Estimating { fraction: 0.5 });
        // 0.95^58 = 0.051, 0.95^59 = 0.049.
        assert!(matches!(statuses(58), (Status::Estimated, Status::Estimating { .. })));
        assert_eq!(statuses(59), (Status::Estimated, Status::Estimated));
    }

    /// Guards against one late packet counted as many: one of 400 ms holds back a dozen, and 5 % would read as 50 %.
    #[test]
    fn packets_held_back_behind_a_late_one_are_not_counted_again() {
        let estimate = learn(2000, |i| if i % 20 == 10 { 0.57 } else { 0.17 });
        assert_eq!(estimate.late, 100);
        assert!((estimate.median.expect("seen") - 0.17).abs() < 0.01);
        assert!((estimate.late_probability - 0.05).abs() < 0.001);
    }
}
