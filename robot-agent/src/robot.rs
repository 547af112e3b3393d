//! The robot, pure: time, poses and answers in, wheel speeds and requests out.
//!
//! What happens at a moment, and in which order, is what `core::episode` does on the robot's side. A simulated link
//! holds back requests and answers here, on robot time.

use crate::epoch;
use crate::limits::{Limits, Refused};
use crate::on_the_way::OnTheWay;
use crate::report::{AgentError, Ended};
use crate::restraint::Restraint;
use crate::throttle::Throttle;
use crate::told::Told;
use crate::transport::{Answer, Post};
use tracing::{info, warn};
use umwelt_client::Error;
use umwelt_client::api::RobotId;
use umwelt_client::api::problem::{Problem, Status};
use umwelt_client::api::step;
use umwelt_client::api::task::Stage;
use umwelt_core::actuation::{Acceptance, Actuation, Playing};
use umwelt_core::exchange::{Exchange, Observation, Request};
use umwelt_core::geometry::WheelSpeeds;
use umwelt_core::horizon::{Horizon, MAX_DURATION, MAX_WATCHDOG, WATCHDOG};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::Link;
use umwelt_core::local::LocalLimits;
use umwelt_core::time::RobotTime;

/// Time in s without a reply after which the robot counts as disconnected; its motors stop long before.
const DISCONNECTED: f64 = 1.0;

/// Time in s that a robot the server does not know waits to be registered, where agent and registration start together.
const REGISTRATION: f64 = 5.0;

/// Shortest time in s between two epochs begun because the server asked: no loop, whatever it says.
const EPOCH_PAUSE: f64 = 1.0;

/// The robot's side of the loop.
#[derive(Debug)]
pub(crate) struct Robot {
    id: RobotId,
    limits: Limits,
    /// Whether it moves something real, which must never be left moving for ever.
    is_hardware: bool,
    exchange: Exchange,
    actuation: Actuation,
    restraint: Restraint,
    /// The link to simulate; none where the real one is all there is.
    link: Option<Link>,
    /// Requests on their way to being posted, and answers on their way back, by arrival.
    upward: OnTheWay<Request>,
    downward: OnTheWay<Answer>,
    epoch: u64,
    /// Epochs before this one, and when this one began.
    epochs_before: u64,
    epoch_began: f64,
    ending: Option<Result<Ended, AgentError>>,
    /// When the last reply came.
    replied: Option<f64>,
    connected: bool,
    /// Since when the server says that it does not know the robot.
    unknown_since: Option<f64>,
    state: State,
    complaint: Throttle,
}

/// What is shown of the robot.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct State {
    pub observed: Option<Observation>,
    pub loop_delay: Option<f64>,
    pub stage: Option<Stage>,
    pub stopped: bool,
    pub requests: u64,
    pub replies: u64,
}

impl Robot {
    /// A robot at rest at robot time `now` that has asked nothing yet.
    pub(crate) fn new(
        id: RobotId,
        told: Told,
        is_hardware: bool,
        link: Option<Link>,
        epoch: u64,
        now: f64,
    ) -> Self {
        let limits = Limits::new(told);
        Self {
            id,
            limits,
            is_hardware,
            exchange: Exchange::new(RobotTime::new(now)),
            actuation: Actuation::new(*limits.drive(), RobotTime::new(now)),
            restraint: Restraint::default(),
            link,
            upward: OnTheWay::new(),
            downward: OnTheWay::new(),
            epoch,
            epochs_before: 0,
            epoch_began: now,
            ending: None,
            replied: None,
            connected: false,
            unknown_since: None,
            state: State::default(),
            complaint: Throttle::default(),
        }
    }

    /// The next robot time at which something happens by itself.
    pub(crate) fn next(&self, now: f64) -> f64 {
        let request = if self.is_ending() {
            f64::INFINITY
        } else {
            self.exchange.next_request(RobotTime::new(now)).seconds()
        };
        let on_the_way = self.upward.next().min(self.downward.next());
        request.min(on_the_way).min(self.actuation.next_change().seconds())
    }

    /// A pose becomes known.
    pub(crate) fn observe(&mut self, observation: Observation) {
        if self.exchange.observe(observation) {
            self.state.observed = Some(observation);
        }
    }

    /// An answer reaches this side of the real link at `now`. The simulated one may hold it back.
    pub(crate) fn answer(&mut self, now: f64, answer: Answer) {
        let crossed = matches!(answer.outcome, Ok(_) | Err(Error::Problem { .. }));
        let arrival = match &mut self.link {
            Some(link) if crossed => link.downlink(now),
            _ => Some(now),
        };
        if let Some(arrival) = arrival {
            self.downward.put(arrival, answer);
        }
    }

    /// The robot itself allows `limits` from `now` on: it acts at once, and the server hears of it with the next request.
    pub(crate) fn restrain(&mut self, now: f64, limits: LocalLimits) {
        if self.restraint.take(now, limits, self.limits.drive()) {
            let limits = self.restraint.limits();
            self.actuation.restrain(limits, self.exchange.newest_sequence());
            self.exchange.restrain(limits);
        }
    }

    /// Whether the robot itself holds.
    pub(crate) fn is_held(&self) -> bool {
        self.restraint.limits().hold
    }

    /// Lets happen what is due by `now`: the wheel speeds to apply from now on.
    pub(crate) fn advance(&mut self, now: f64) -> WheelSpeeds {
        while let Some(answer) = self.downward.due(now) {
            self.deliver(now, answer);
        }
        let speeds = self.actuation.advance(RobotTime::new(now));
        let playing = self.playing();
        if !self.is_ending()
            && let Some(request) = self.exchange.request(RobotTime::new(now), playing)
        {
            let arrival = self.link.as_mut().map_or(Some(now), |link| link.uplink(now));
            if let Some(arrival) = arrival {
                self.upward.put(arrival, request);
            }
        }
        self.follow_connection(now);
        speeds
    }

    /// A request that is to be posted at `now`; what its connection's end took along is not.
    pub(crate) fn post(&mut self, now: f64) -> Option<Post> {
        while let Some(request) = self.upward.due(now) {
            if request.connection >= self.exchange.oldest_connection() {
                self.state.requests += 1;
                let connection = (self.epochs_before, request.connection);
                let request = step::Request {
                    drive_tag: Some(self.limits.tag()),
                    ..step::Request::from_core(&request, self.epoch)
                };
                return Some(Post { connection, request });
            }
        }
        None
    }

    /// The oldest connection that still counts.
    pub(crate) fn oldest_connection(&self) -> (u64, u64) {
        (self.epochs_before, self.exchange.oldest_connection())
    }

    /// Ramps to rest and asks no more. The first reason stays.
    pub(crate) fn end(&mut self, reason: Result<Ended, AgentError>) {
        if self.is_ending() {
            return;
        }
        match &reason {
            Ok(Ended::Shutdown) => info!("agent ends as asked: ramping to rest"),
            Ok(Ended::Duration) => info!("agent ends, its time is over: ramping to rest"),
            Ok(Ended::NoMorePoses) => info!("agent ends, no more poses come: ramping to rest"),
            Err(_) => warn!("agent cannot go on: ramping to rest"),
        }
        self.actuation.stop();
        self.upward.clear();
        self.downward.clear();
        self.ending = Some(reason);
    }

    /// The drive that the server has for it, where that is news.
    pub(crate) fn described(&mut self) -> Option<Drive> {
        self.limits.news()
    }

    /// Whether it has been told to end.
    pub(crate) fn is_ending(&self) -> bool {
        self.ending.is_some()
    }

    /// Why it ended, once it is at rest.
    pub(crate) fn ended(&self) -> Option<&Result<Ended, AgentError>> {
        self.ending.as_ref().filter(|_| self.actuation.is_at_rest())
    }

    /// What is shown of it.
    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// Whether replies come.
    pub(crate) fn is_connected(&self) -> bool {
        self.connected
    }

    /// What is played, if it is of this epoch: the server knows nothing of another one's horizons.
    fn playing(&self) -> Option<Playing> {
        let playing = self.actuation.playing()?;
        (self.epochs_before == 0 || playing.since.seconds() > self.epoch_began).then_some(playing)
    }

    fn deliver(&mut self, now: f64, answer: Answer) {
        if self.is_ending() || answer.epoch != self.epoch {
            return;
        }
        match answer.outcome {
            Ok(reply) => self.take(now, answer.sequence, &reply),
            Err(Error::Problem { problem, .. }) => self.refused(now, &problem),
            Err(failure) => self.complain(now, &failure.to_string()),
        }
    }

    /// A reply arrives: its horizon is played if it is the newest.
    fn take(&mut self, now: f64, sequence: u64, reply: &step::Reply) {
        if let Some(tagged) = reply.drive.as_deref() {
            self.describe(now, tagged);
            if self.is_ending() {
                return;
            }
        }
        let mut horizon = match reply.horizon.to_core() {
            Ok(horizon) => horizon,
            Err(problems) => return self.complain(now, &format!("unbelievable: {problems}")),
        };
        if horizon.sequence > self.exchange.newest_sequence() {
            let asked = self.exchange.newest_sequence();
            let why = format!("horizon.sequence is {}, but {asked} is all", horizon.sequence);
            return self.complain(now, &format!("unbelievable: {why} that was asked for so far"));
        }
        self.make_safe(now, &mut horizon);
        if self.actuation.accept(&horizon) == Acceptance::Unbelievable {
            let ahead = horizon.start.seconds() - now;
            let why = format!("its horizon begins in {ahead:.1} s, no plan reaches that far");
            return self.complain(now, &format!("unbelievable: {why}"));
        }
        if let Some(loop_delay) = self.exchange.reply(RobotTime::new(now), sequence) {
            self.state.loop_delay = Some(loop_delay);
        }
        if self.state.stopped != reply.stopped {
            let what = if reply.stopped { "stopped" } else { "resumed" };
            info!("robot {what} by the server");
        }
        if self.state.stage != Some(reply.stage) {
            info!(stage = ?reply.stage, "robot goes on to another stage");
        }
        self.state.stopped = reply.stopped;
        self.state.stage = Some(reply.stage);
        self.state.replies += 1;
        self.replied = Some(now);
        self.unknown_since = None;
    }

    /// The server says by which drive the robot is to move. What the agent was told otherwise ends the run: one of both is
    /// wrong, and the floor would be blamed for it.
    fn describe(&mut self, now: f64, tagged: &step::TaggedDrive) {
        match self.limits.describe(tagged) {
            Ok(false) => {}
            Ok(true) => {
                let drive = self.limits.drive();
                let (wheel_radius_m, track_width_m) = (drive.wheel_radius, drive.track_width);
                info!(wheel_radius_m, track_width_m, "robot has its drive from the server");
                self.actuation.describe(*drive);
                self.restraint.describe(drive);
                let limits = self.restraint.limits();
                self.actuation.restrain(limits, self.exchange.newest_sequence());
                self.exchange.restrain(limits);
            }
            Err(Refused::Unbelievable(problems)) => {
                self.complain(now, &format!("unbelievable: {problems}"));
            }
            Err(Refused::Differs(differences)) => {
                let robot = self.id.clone();
                self.end(Err(AgentError::OtherDrive { robot, differences }));
            }
        }
    }

    /// The robot's own limits hold whatever the server says.
    fn make_safe(&mut self, now: f64, horizon: &mut Horizon) {
        if self.is_hardware && horizon.watchdog == 0.0 {
            horizon.watchdog = WATCHDOG;
            self.complain(
                now,
                &format!("a watchdog of 0 s is none: playing on {WATCHDOG} s instead"),
            );
        }
        if horizon.cut() {
            self.complain(
                now,
                &format!(
                    "a horizon of more than {MAX_DURATION:.0} s, or a watchdog of more than {MAX_WATCHDOG} s: cut"
                ),
            );
        }
        if self.limits.hold(horizon) {
            self.complain(now, "faster than this robot's limits: limited");
        }
    }

    /// The server refuses. A request that got no horizon stays in flight: its connection counts as stalled, and
    /// what is tried next is tried with backoff.
    fn refused(&mut self, now: f64, problem: &Problem) {
        match problem.status {
            Status::Aborted => {
                let robot = self.id.clone();
                self.end(Err(AgentError::Superseded { robot }));
            }
            Status::FailedPrecondition if now >= self.epoch_began + EPOCH_PAUSE => {
                info!("{problem}: beginning a new epoch");
                self.begin_epoch(now);
            }
            Status::NotFound => {
                self.complain(now, &problem.to_string());
                let since = *self.unknown_since.get_or_insert(now);
                if self.replied.is_some() {
                    self.actuation.stop();
                } else if now >= since + REGISTRATION {
                    let robot = self.id.clone();
                    self.end(Err(AgentError::Unregistered { robot }));
                }
            }
            _ => self.complain(now, &problem.to_string()),
        }
    }

    /// Counts anew; what is playing goes on until it is replaced or expires.
    fn begin_epoch(&mut self, now: f64) {
        self.epoch = epoch::after(self.epoch);
        self.epochs_before += 1;
        self.epoch_began = now;
        self.exchange = Exchange::new(RobotTime::new(now));
        self.exchange.restrain(self.restraint.limits());
        self.actuation.restart_sequences();
        self.upward.clear();
        self.downward.clear();
    }

    fn follow_connection(&mut self, now: f64) {
        let connected = self.replied.is_some_and(|replied| now < replied + DISCONNECTED);
        if connected == self.connected {
            return;
        }
        self.connected = connected;
        if connected {
            info!("robot connected");
        } else {
            warn!("robot disconnected: no reply for {DISCONNECTED} s, it comes to rest by itself");
        }
    }

    fn complain(&mut self, now: f64, what: &str) {
        match self.complaint.ask(now) {
            Some(0) => warn!("{what}"),
            Some(unsaid) => warn!(unsaid, "{what}"),
            None => {}
        }
    }
}
