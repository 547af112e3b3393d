//! The robot's side of the exchange: which request to send when, over which connection, and what to report.
//!
//! One request per slot without waiting for the last reply, at most four in flight on a connection (more where the link is
//! slow), a fresh connection when one stalls. Used by the agent and by the simulation; it holds no clock and no socket.

use crate::actuation::Playing;
use crate::geometry::Pose;
use crate::horizon::SLOT;
use crate::local::LocalLimits;
use crate::robot::trip::Trip;
pub use crate::robot::trip::{IN_FLIGHT, MAX_IN_FLIGHT, STALL};
use crate::time::RobotTime;
use arrayvec::ArrayVec;

/// Most observations of one request; older ones are dropped first.
pub const MAX_OBSERVATIONS: usize = 32;

/// Most reported deliveries of one request; more than arrive in one slot after a stall.
pub const MAX_DELIVERIES: usize = 16;

/// Most connections that may carry requests at a time.
pub const MAX_CONNECTIONS: usize = 3;

/// Times that differ by less than this many s are the same.
const SAME_TIME: f64 = 1e-9;

/// Longest time in s between fresh connections while none answers.
pub const MAX_BACKOFF: f64 = 1.0;

/// A pose and when it was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// The observed pose.
    pub pose: Pose,
    /// When it was taken, not when it became known.
    pub taken: RobotTime,
}

/// Noise of an observed pose, normal and independent per axis and observation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseNoise {
    /// Standard deviation of x and of y in m.
    pub position: f64,
    /// Standard deviation of the heading in rad.
    pub heading: f64,
}

impl PoseNoise {
    /// A perfect camera.
    pub const NONE: Self = Self { position: 0.0, heading: 0.0 };
    /// A camera or motion capture: 0.5 mm and 3 mrad (field facts: 0.5-0.7 mm and 2.6-3 mrad per pose).
    pub const CAMERA: Self = Self { position: 0.0005, heading: 0.003 };

    /// The least noise that is believed: no tracker is exact, and a filter needs some.
    pub const LEAST: Self = Self { position: 5e-5, heading: 2e-4 };
}

/// The measured loop delay of one reply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delivery {
    /// Sequence of the request that was answered.
    pub sequence: u64,
    /// Time in s from the newest pose of that request being taken to its reply arriving.
    pub loop_delay: f64,
}

/// One request of the robot: what a step carries.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Number of this request, strictly increasing within an epoch.
    pub sequence: u64,
    /// Number of the connection to send it over; a number not seen before asks for a fresh one.
    pub connection: u64,
    /// When it was sent.
    pub sent: RobotTime,
    /// Poses since the last request, oldest first.
    pub observations: ArrayVec<Observation, MAX_OBSERVATIONS>,
    /// Replies that arrived since the last request.
    pub deliveries: ArrayVec<Delivery, MAX_DELIVERIES>,
    /// What the robot plays now.
    pub playing: Option<Playing>,
    /// What the robot itself allows; a hold also where it is over again since the last request.
    pub limits: LocalLimits,
}

impl Request {
    /// A request that says nothing: a place for others.
    pub const EMPTY: Self = Self {
        sequence: 0,
        connection: 0,
        sent: RobotTime::ZERO,
        observations: ArrayVec::new_const(),
        deliveries: ArrayVec::new_const(),
        playing: None,
        limits: LocalLimits::NONE,
    };
}

#[derive(Clone, Copy, Debug)]
struct InFlight {
    sequence: u64,
    connection: u64,
    sent: RobotTime,
    /// When the newest pose of the request was taken; none where it carried no new one.
    taken: Option<RobotTime>,
}

/// The robot's side of the exchange.
#[derive(Clone, Debug)]
pub struct Exchange {
    next_sequence: u64,
    connection: u64,
    connected: RobotTime,
    backoff: f64,
    /// When the next request is due, were there poses at every moment: one slot after the last one was.
    due: RobotTime,
    newest_taken: RobotTime,
    observations: ArrayVec<Observation, MAX_OBSERVATIONS>,
    deliveries: ArrayVec<Delivery, MAX_DELIVERIES>,
    limits: LocalLimits,
    /// Whether there was a hold since the last request.
    was_held: bool,
    in_flight: ArrayVec<InFlight, { MAX_IN_FLIGHT * MAX_CONNECTIONS }>,
    trip: Trip,
}

impl Exchange {
    /// An exchange that begins `now`.
    pub fn new(now: RobotTime) -> Self {
        Self {
            next_sequence: 1,
            connection: 0,
            connected: now,
            backoff: STALL,
            due: RobotTime::BEFORE_ALL,
            newest_taken: RobotTime::BEFORE_ALL,
            observations: ArrayVec::new(),
            deliveries: ArrayVec::new(),
            limits: LocalLimits::NONE,
            was_held: false,
            in_flight: ArrayVec::new(),
            trip: Trip::new(),
        }
    }

    /// Takes in a pose. One that is not newer than the last is ignored: stamps strictly increase.
    pub fn observe(&mut self, observation: Observation) -> bool {
        if observation.taken <= self.newest_taken {
            return false;
        }
        self.newest_taken = observation.taken;
        if self.observations.is_full() {
            self.observations.remove(0);
        }
        self.observations.push(observation);
        true
    }

    /// The robot itself allows this from now on.
    pub fn restrain(&mut self, limits: LocalLimits) {
        self.limits = limits;
        self.was_held |= limits.hold;
    }

    /// When the next request is due, given what is in flight and observed:
    /// with a new pose as soon as a slot has nearly passed since the last request, without one a little later.
    pub fn next_request(&self, now: RobotTime) -> RobotTime {
        let due = now.later(self.soonest());
        if self.has_room() {
            return due;
        }
        due.later(self.oldest(self.connection) + self.trip.stall())
            .later(self.connected + self.backoff)
    }

    /// When the next request is due, were nothing in flight.
    fn soonest(&self) -> RobotTime {
        // A camera in step with the slots jitters: a pose that comes a little early need not wait a whole slot. What
        // came early is waited for by the next one, so that a faster camera does not speed up the slots.
        self.due + if self.observations.is_empty() { 0.5 * SLOT } else { -0.4 * SLOT }
    }

    /// Whether the connection may carry one more request.
    fn has_room(&self) -> bool {
        let on_it = |request: &&InFlight| request.connection == self.connection;
        let most = self.trip.most_in_flight();
        self.in_flight.len() < most || self.in_flight.iter().filter(on_it).count() < most
    }

    fn oldest(&self, connection: u64) -> RobotTime {
        let on_it = self.in_flight.iter().filter(|request| request.connection == connection);
        on_it.map(|request| request.sent).fold(RobotTime::NEVER, RobotTime::earlier)
    }

    /// The request to send now, if one is due.
    pub fn request(&mut self, now: RobotTime, playing: Option<Playing>) -> Option<Request> {
        let mut request = Request::EMPTY;
        self.write_request(now, playing, &mut request).then_some(request)
    }

    /// [`Exchange::request`] into a place that is there already; whether one is due.
    #[inline]
    pub fn write_request(
        &mut self,
        now: RobotTime,
        playing: Option<Playing>,
        request: &mut Request,
    ) -> bool {
        // Asked much more often than one is due.
        let is_due = self.soonest() <= now + SAME_TIME && self.next_request(now) <= now + SAME_TIME;
        if is_due {
            self.write(now, playing, request);
        }
        is_due
    }

    fn write(&mut self, now: RobotTime, playing: Option<Playing>, request: &mut Request) {
        let stalled = now - self.oldest(self.connection) >= self.trip.stall()
            && now - self.connected >= self.backoff;
        if stalled || !self.has_room() {
            self.connection += 1;
            self.connected = now;
            self.backoff = (2.0 * self.backoff).min(MAX_BACKOFF);
            let oldest_kept = (self.connection + 1).saturating_sub(MAX_CONNECTIONS as u64);
            self.in_flight.retain(|request| request.connection >= oldest_kept);
        }
        let sequence = self.next_sequence;
        self.next_sequence += 1;
        self.due = self.due.later(now) + SLOT;
        let taken = self.observations.last().map(|observation| observation.taken);
        self.in_flight.push(InFlight { sequence, connection: self.connection, sent: now, taken });
        (request.sequence, request.connection) = (sequence, self.connection);
        (request.sent, request.playing) = (now, playing);
        request.limits = LocalLimits { hold: self.was_held, ..self.limits };
        self.was_held = self.limits.hold;
        request.observations.clone_from(&self.observations);
        request.deliveries.clone_from(&self.deliveries);
        self.observations.clear();
        self.deliveries.clear();
    }

    /// The reply to request `sequence` arrives. Returns its loop delay in s where the request carried a new
    /// pose and is still waited for.
    pub fn reply(&mut self, now: RobotTime, sequence: u64) -> Option<f64> {
        let at = self.in_flight.iter().position(|request| request.sequence == sequence)?;
        let request = self.in_flight.remove(at);
        self.trip.follow(now, request.sent);
        if request.connection == self.connection {
            self.backoff = STALL;
        }
        let loop_delay = now - request.taken?;
        if self.deliveries.is_full() {
            self.deliveries.remove(0);
        }
        self.deliveries.push(Delivery { sequence, loop_delay });
        Some(loop_delay)
    }

    /// Request `sequence` failed or was refused: it is no longer waited for.
    pub fn fail(&mut self, sequence: u64) {
        self.in_flight.retain(|request| request.sequence != sequence);
    }

    /// The number of the oldest connection that still counts; older ones may be closed.
    pub fn oldest_connection(&self) -> u64 {
        (self.connection + 1).saturating_sub(MAX_CONNECTIONS as u64)
    }

    /// Sequence of the newest request sent; 0 before the first.
    pub fn newest_sequence(&self) -> u64 {
        self.next_sequence - 1
    }

    /// Requests that are waited for.
    pub fn in_flight(&self) -> usize {
        self.in_flight.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observed(taken: f64) -> Observation {
        Observation { pose: Pose::default(), taken: RobotTime::new(taken) }
    }

    /// Offers a pose every slot over `seconds` s and answers as `reply` says; the send times and connections.
    fn run(seconds: f64, reply: impl Fn(f64) -> Option<f64>) -> Vec<(f64, u64)> {
        let mut exchange = Exchange::new(RobotTime::ZERO);
        let (mut sends, mut replies) = (Vec::new(), Vec::<(f64, u64)>::new());
        for slot in 0..(seconds / SLOT) as usize {
            let now = slot as f64 * SLOT;
            for &(_, sequence) in replies.iter().filter(|(at, _)| *at <= now) {
                exchange.reply(RobotTime::new(now), sequence);
            }
            replies.retain(|(at, _)| *at > now);
            exchange.observe(observed(now - 0.13));
            if let Some(request) = exchange.request(RobotTime::new(now), None) {
                sends.push((now, request.connection));
                if let Some(delay) = reply(now) {
                    replies.push((now + delay, request.sequence));
                }
            }
        }
        sends
    }

    #[test]
    fn on_a_good_link_one_request_goes_out_per_slot() {
        let sends = run(3.0, |_| Some(0.05));
        assert_eq!(sends.len(), 100);
        assert!(sends.iter().all(|&(_, connection)| connection == 0));
    }

    /// Whatever the camera's rate: one request per slot, and none sooner than most of a slot after the last.
    #[test]
    fn a_fast_camera_does_not_speed_up_the_requests() {
        for rate in [50.0, 60.0, 90.0, 120.0, 240.0, 1000.0] {
            let mut exchange = Exchange::new(RobotTime::ZERO);
            let mut sends = Vec::new();
            for frame in 0..(3.0 * rate) as u32 {
                let now = f64::from(frame) / rate;
                exchange.observe(observed(now));
                if let Some(request) = exchange.request(RobotTime::new(now), None) {
                    sends.push(now);
                    exchange.reply(RobotTime::new(now), request.sequence);
                }
            }
            assert!(
                (90..=101).contains(&sends.len()),
                "{} in 100 slots at {rate} per s",
                sends.len()
            );
            assert!(sends.windows(2).all(|pair| pair[1] - pair[0] > 0.6 * SLOT - 1e-9));
        }
    }

    #[test]
    fn a_stall_opens_a_fresh_connection_and_never_floods() {
        let sends = run(13.0, |now| if (1.0..11.0).contains(&now) { None } else { Some(0.05) });
        let stalled: Vec<_> = sends.iter().filter(|(now, _)| (1.0..11.0).contains(now)).collect();
        assert!(stalled.len() >= 8, "it keeps trying: {}", stalled.len());
        assert!(stalled.len() <= 60, "with backoff: {}", stalled.len());
        assert!(sends.last().is_some_and(|&(now, connection)| now > 12.9 && connection > 1));
    }

    #[test]
    fn no_pose_is_sent_twice_and_none_is_lost_in_a_short_stall() {
        let mut exchange = Exchange::new(RobotTime::ZERO);
        let mut taken = Vec::new();
        for slot in 0..40 {
            let now = f64::from(slot) * SLOT;
            exchange.observe(observed(now));
            if let Some(request) = exchange.request(RobotTime::new(now), None) {
                taken.extend(request.observations.iter().map(|o| o.taken));
            }
        }
        assert!(taken.windows(2).all(|pair| pair[1] > pair[0]));
        assert!(taken.len() >= 20);
    }

    #[test]
    fn stamps_strictly_increase() {
        let mut exchange = Exchange::new(RobotTime::ZERO);
        assert!(exchange.observe(observed(1.0)));
        assert!(!exchange.observe(observed(1.0)));
        assert!(!exchange.observe(observed(0.5)));
    }

    #[test]
    fn the_loop_delay_counts_from_the_pose_and_a_repeat_counts_once() {
        let mut exchange = Exchange::new(RobotTime::ZERO);
        exchange.observe(observed(1.0));
        let request = exchange.request(RobotTime::new(1.13), None).expect("due");
        let delay = exchange.reply(RobotTime::new(1.2), request.sequence).expect("waited for");
        assert!((delay - 0.2).abs() < 1e-12);
        assert_eq!(exchange.reply(RobotTime::new(1.3), request.sequence), None);
        exchange.observe(observed(1.1));
        let next = exchange.request(RobotTime::new(1.3), None).expect("due");
        assert_eq!(next.deliveries.as_slice(), [Delivery { sequence: 1, loop_delay: delay }]);
    }
}
