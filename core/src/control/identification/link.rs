//! What is believed of the link: loop delay (the recent ones, normal on their logarithm) and late packets (beta-Bernoulli).
//!
//! A link changes with the route and the place: what counts are the deliveries of the last second or so. Their median is
//! the loop delay; half of them must be of another route before it moves there, so no burst of late packets moves it.

use super::estimate::{LEVEL, LinkEstimate};
use super::status::{Status, progress};
use crate::conjugate::{BetaBernoulli, NormalInverseChiSquared};
use crate::exchange::{Delivery, Observation};
use crate::geometry::elementary::{exp, ln};
use crate::horizon::SLOT;
use crate::time::RobotTime;
use arrayvec::ArrayVec;
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

/// Recent deliveries: after half of them a change of the route has been followed.
const RECENT: usize = 31;

/// Requests remembered to know when their pose was taken.
const REQUESTS: usize = 32;

/// What is believed of one robot's link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinkBelief {
    /// ln of the loop delay in s before any recent delivery: the prior, or what an earlier version had learned.
    ln_delay: NormalInverseChiSquared,
    /// The recent deliveries that were not held back, oldest first.
    #[serde(default, skip_serializing_if = "VecDeque::is_empty")]
    recent: VecDeque<Recent>,
    late: BetaBernoulli,
    deliveries: u64,
    late_deliveries: u64,
    /// (sequence, when its newest pose was taken).
    requests: VecDeque<(u64, RobotTime)>,
    /// When the last late delivery arrived.
    late_arrival: Option<RobotTime>,
}

/// A delivery that was not held back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Recent {
    /// Its loop delay in s.
    delay: f64,
    /// Whether it counts as late.
    is_late: bool,
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
            recent: VecDeque::with_capacity(RECENT),
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
    /// have come later still. They count as not late, and say nothing of the ordinary delay. Packets that turn out to be
    /// the first of another route were not late either.
    pub fn update(&mut self, delivery: &Delivery) {
        let delay = delivery.loop_delay.max(SHORTEST);
        self.deliveries += 1;
        let asked = self.requests.iter().rev().find(|(sequence, _)| *sequence == delivery.sequence);
        let arrival = asked.map(|(_, taken)| *taken + delivery.loop_delay);
        let held_back = arrival
            .zip(self.late_arrival)
            .is_some_and(|(arrival, late)| (arrival - late).abs() < SAME_INSTANT);
        if held_back {
            self.late = self.late.update(false);
            return;
        }
        while self.recent.len() >= RECENT {
            self.recent.pop_front();
        }
        self.recent.push_back(Recent { delay, is_late: false });
        let latest = self.recent_median().unwrap_or(delay) + LATE_SLOTS * SLOT;
        for recent in self.recent.iter_mut().filter(|it| it.is_late && it.delay <= latest) {
            recent.is_late = false;
            self.late = self.late.retract(true).map_or(self.late, |late| late.update(false));
            self.late_deliveries = self.late_deliveries.saturating_sub(1);
        }
        let is_late = delay > latest;
        self.late = self.late.update(is_late);
        if is_late {
            self.late_deliveries += 1;
            self.late_arrival = arrival;
            if let Some(newest) = self.recent.back_mut() {
                newest.is_late = true;
            }
        }
    }

    /// What is believed of the logarithm of the loop delay: as the recent deliveries have it that are not late.
    fn ln_delay(&self) -> NormalInverseChiSquared {
        if self.recent.is_empty() {
            return self.ln_delay;
        }
        let ordinary = self.recent.iter().filter(|it| !it.is_late);
        ordinary.fold(prior_ln_delay(), |belief, it| belief.update(ln(it.delay)))
    }

    /// Median of the recent loop delays in s; none before the first delivery.
    pub fn median(&self) -> Option<f64> {
        let known = self.recent_median();
        known.or_else(|| (self.deliveries > 0).then(|| exp(self.ln_delay.mu())))
    }

    /// The lower one of the middle two: the first of all packets may have waited for its connection.
    fn recent_median(&self) -> Option<f64> {
        let newest = self.recent.iter().rev().take(RECENT);
        let mut delays: ArrayVec<f64, RECENT> = newest.map(|it| it.delay).collect();
        let middle = delays.len().checked_sub(1)? / 2;
        Some(*delays.select_nth_unstable_by(middle, f64::total_cmp).1)
    }

    /// Forgets times of the robot's clock, keeps what they taught.
    pub fn restart_clock(&mut self) {
        self.requests.clear();
        self.late_arrival = None;
    }

    /// How far the estimate of the loop delay has got: as with a channel, the less of mean and variance of its logarithm.
    fn delay_status(&self) -> Status {
        let (prior, posterior) = (prior_ln_delay(), self.ln_delay());
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
            median: self.median(),
            p99: seen.then(|| self.ln_delay().predictive_interval(0.98).1.exp()),
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

    /// Guards against a link that is slower than expected and never learned, all of whose packets are late.
    #[test]
    fn a_slow_link_is_known_at_once_and_nothing_of_it_is_late() {
        let estimate = learn(106, |_| 0.35);
        assert!((estimate.median.expect("seen") - 0.35).abs() < 1e-9);
        assert_eq!(estimate.late, 0);
        assert!(estimate.p99.expect("seen") < 0.5, "{estimate:?}");
        // Whatever was seen so far, no loop takes longer than one could wait for.
        for count in 1..10 {
            let p99 = learn(count, |_| 0.35).p99.expect("seen");
            assert!(p99 < 3.0, "{count}: {p99}");
        }
    }

    /// Guards against commands timed for a route that is no more.
    #[test]
    fn another_route_is_followed_within_twenty_deliveries_either_way() {
        // In order, the last packets of the slow route hold back the first of the fast one.
        for (before, after, held_back) in [(0.05, 0.4, 0), (0.4, 0.05, 12)] {
            let estimate = learn(220 + held_back, |i| if i < 200 { before } else { after });
            assert!((estimate.median.expect("seen") - after).abs() < 1e-9, "{before} -> {after}");
            assert_eq!(estimate.late, 0, "the first packets of a route are not late");
        }
    }

    /// Guards against a burst of late packets that is taken for another route, and the robot plans for it.
    #[test]
    fn a_burst_of_late_packets_does_not_move_the_median() {
        let estimate = learn(310, |i| if i >= 300 { 0.17 + 0.1 * (i - 299) as f64 } else { 0.17 });
        assert!((estimate.median.expect("seen") - 0.17).abs() < 1e-9);
        assert_eq!(estimate.late, 10);
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
