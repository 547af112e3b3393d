//! One run of a link: when a packet sent now arrives.

use super::{LinkError, LinkModel, Rtt, SLOT, Z_99};
use crate::draws::{Draws, Stream};
use crate::geometry::elementary::exp;

/// A send time this share of a slot before the next slot counts as in it: multiples of 0.03 are not exact.
const ROUNDING: f64 = 1e-6;

/// Latest send time in s, either side of zero, so that slot numbers do not run over.
const LATEST: f64 = 1e12;

/// The number of the slot that `now` in s falls into.
fn slot_of(now: f64) -> i64 {
    // The C library's floor is a call; what the conversion cuts off is one too many below zero.
    let slots = now / SLOT + ROUNDING;
    let whole = slots as i64;
    if slots < whole as f64 { whole - 1 } else { whole }
}

/// Before every time in s. Finite, because JSON has no infinity.
const BEGINNING: f64 = -1e300;

/// What a direction remembers of its past.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Direction {
    /// Latest arrival so far in s; the floor for the next one if in order.
    last_arrival: f64,
    /// End in s of the silences of all slots seen so far.
    dark_until: f64,
    /// First slot whose silence is not yet in `dark_until`.
    unseen: i64,
}

impl Direction {
    const NEW: Self = Self { last_arrival: BEGINNING, dark_until: BEGINNING, unseen: i64::MIN };
}

/// One run of a [`LinkModel`] under a seed: carries packets of both directions.
///
/// Send times must not decrease within a direction; the directions may interleave as they like. Equal seeds give
/// equal slots whatever is sent. Nothing is allocated per packet.
///
/// ```
/// use umwelt_core::link::{Link, LinkModel};
/// let mut link = Link::new(LinkModel::preset("clean").unwrap(), 7)?;
/// let at_server = link.uplink(1.0).unwrap();
/// assert!((at_server - 1.001).abs() < 1e-12);
/// assert!((link.downlink(at_server).unwrap() - 1.002).abs() < 1e-12);
/// # Ok::<(), umwelt_core::link::LinkError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    model: LinkModel,
    seed: u64,
    up: Direction,
    down: Direction,
    /// The latest downlink slot looked at and whether it is late: the answer is the same without it, but later.
    late: Option<(i64, bool)>,
    /// Derived: median in s and spread of the logarithm of one direction's delay; unused unless lognormal.
    one_way: (f64, f64),
    /// Derived: the keys of the jitter's draws, uplink and downlink.
    jitter: (u64, u64),
    /// Derived: probability of a late slot after one on time.
    after_on_time: f64,
}

/// Median and spread of the logarithm of one of two independent lognormal delays whose sum has the given quantiles.
///
/// Fenton 1960: the sum is taken as lognormal with its own mean and variance. With s^2 the variance of the sum's
/// logarithm, one delay's is ln(1 + 2 (e^(s^2) - 1)), and half the sum's mean is one delay's.
fn halved(median: f64, p99: f64) -> (f64, f64) {
    let of_sum = ((p99 / median).ln() / Z_99).powi(2);
    let of_one = (2.0 * of_sum.exp_m1()).ln_1p();
    (median / 2.0 * ((of_sum - of_one) / 2.0).exp(), of_one.sqrt())
}

impl Link {
    /// A link that has carried nothing yet.
    pub fn new(model: LinkModel, seed: u64) -> Result<Self, LinkError> {
        model.validate()?;
        let one_way = match model.rtt {
            Rtt::Lognormal { median, p99 } => halved(median, p99),
            _ => (0.0, 0.0),
        };
        let after_on_time = model.late.after_on_time();
        let (up, down) = (Direction::NEW, Direction::NEW);
        let key = |stream| Draws::key(seed, stream);
        let jitter = (key(Stream::UplinkJitter), key(Stream::DownlinkJitter));
        Ok(Self { model, seed, up, down, late: None, one_way, jitter, after_on_time })
    }

    /// Another link from now on: its draws, what is on its way and what held back what stay as they are.
    ///
    /// # Errors
    /// Where the model means nothing; nothing has happened then.
    pub fn set_model(&mut self, model: LinkModel) -> Result<(), LinkError> {
        let Self { seed, up, down, .. } = *self;
        *self = Self { up, down, ..Self::new(model, seed)? };
        Ok(())
    }

    /// What the link is like.
    pub fn model(&self) -> &LinkModel {
        &self.model
    }

    /// When a pose taken at `now` is known on the robot, in s.
    pub fn sensor(&self, now: f64) -> f64 {
        now + self.model.sensor_delay
    }

    /// When a packet that the robot sends at `now` s arrives at the server; `None` if it is lost.
    ///
    /// A send time that is not a number or beyond 10^12 s is lost too.
    pub fn uplink(&mut self, now: f64) -> Option<f64> {
        let slot = sendable(now)?;
        let ordinary = self.ordinary_delay(self.jitter.0, now, slot);
        let mut up = self.up;
        let arrival = self.deliver(&mut up, now, slot, ordinary);
        self.up = up;
        arrival
    }

    /// When a packet that the server sends at `now` s arrives at the robot; `None` if it is lost.
    ///
    /// A send time that is not a number or beyond 10^12 s is lost too.
    pub fn downlink(&mut self, now: f64) -> Option<f64> {
        let slot = sendable(now)?;
        let mut delay = self.ordinary_delay(self.jitter.1, now, slot);
        if self.model.late.probability > 0.0 && self.is_late(slot) {
            delay += self.model.late.extra;
        }
        let mut down = self.down;
        let arrival = self.deliver(&mut down, now, slot, delay);
        self.down = down;
        arrival
    }

    /// One direction's share of the RTT of `slot`, in s.
    fn ordinary_delay(&self, key: u64, now: f64, slot: i64) -> f64 {
        match &self.model.rtt {
            Rtt::Constant(rtt) => rtt / 2.0,
            Rtt::Lognormal { .. } => {
                let (median, sigma) = self.one_way;
                median * exp(sigma * Draws::at(key, slot).normal())
            }
            Rtt::Trace(trace) => trace.at(now) / 2.0,
        }
    }

    /// Whether the downlink `slot` is late.
    ///
    /// The chain takes one uniform u per slot: after a late slot it is late if u < a, after one on time if u < b.
    /// So u below both or above both decides the slot without the one before; in between, the slot repeats the one
    /// before (b < a) or is its opposite. Going back to the last slot that decides itself gives the chain in its
    /// long-run distribution at any slot, in 1/(1 - |a - b|) looks on average and without a beginning.
    fn is_late(&mut self, slot: i64) -> bool {
        let (a, b) = (self.model.late.after_late, self.after_on_time);
        let mut at = slot;
        let mut opposite = false;
        let decided = loop {
            match self.late {
                Some((known, late)) if known == at => break late,
                _ => {}
            }
            let u = Draws::new(self.seed, Stream::Late, at).uniform();
            if u < a.min(b) {
                break true;
            }
            if u >= a.max(b) {
                break false;
            }
            opposite ^= a < b;
            at -= 1;
        };
        let late = decided ^ opposite;
        self.late = Some((slot, late));
        late
    }

    /// When a packet sent at `now` with `delay` arrives.
    fn deliver(&self, direction: &mut Direction, now: f64, slot: i64, delay: f64) -> Option<f64> {
        let sent = self.end_of_outage(direction, now, slot);
        if !self.model.in_order {
            return (sent == now).then_some(now + delay);
        }
        let arrival = (sent + delay).max(direction.last_arrival);
        direction.last_arrival = arrival;
        Some(arrival)
    }

    /// The end of the outage that `now` falls into, whatever outages and silences it is made of; `now` if none.
    fn end_of_outage(&self, direction: &mut Direction, now: f64, slot: i64) -> f64 {
        let silences = self.model.silences.rate > 0.0;
        if !silences && self.model.outages.is_empty() {
            return now;
        }
        let mut end = now;
        loop {
            let before = end;
            if silences {
                // slots are looked up at the packet's own slot first, then at where the outage would end
                let at = if end == now { slot } else { slot_of(end) };
                self.see_silences(direction, at);
                end = end.max(direction.dark_until);
            }
            let started = self.model.outages.partition_point(|outage| outage.start <= end);
            if let Some(outage) = self.model.outages[..started].last() {
                end = end.max(outage.start + outage.duration);
            }
            if end == before {
                return end;
            }
        }
    }

    /// Brings the silences of all slots up to `slot` into `dark_until`, and those that begin before it ends.
    fn see_silences(&self, direction: &mut Direction, slot: i64) {
        let silences = &self.model.silences;
        // a silence that began earlier than this is over: long gaps cost no more than this many looks
        let reach = (silences.longest / SLOT).ceil() as i64 + 1;
        let mut at = direction.unseen.max(slot - reach);
        while at <= slot || at as f64 * SLOT < direction.dark_until {
            let mut draws = Draws::new(self.seed, Stream::Silence, at);
            if draws.uniform() < silences.rate * SLOT {
                let end = at as f64 * SLOT + silences.duration(draws.uniform());
                direction.dark_until = direction.dark_until.max(end);
            }
            at += 1;
        }
        direction.unseen = at;
    }
}

/// The slot of a packet sent at `now`, if there is one.
fn sendable(now: f64) -> Option<i64> {
    (now.abs() <= LATEST).then(|| slot_of(now))
}
