//! An episode: one robot, one link, one task, closed in simulated time.
//!
//! It runs the controller and the actuation that the server and the agent run: a simulated minute and a real minute
//! over HTTP must agree.

mod on_the_way;

use crate::actuation::Actuation;
use crate::controller::compensation::{DelayModel, PathFollower, PoseEstimator};
use crate::controller::{Controller, Events};
use crate::exchange::{Exchange, Observation, Request};
use crate::geometry::elementary::{least, most};
use crate::geometry::{Point, Pose, WheelSpeeds};
use crate::horizon::{Horizon, SLOT};
use crate::identification::SampleObserver;
use crate::link::{Link, LinkError, LinkModel};
use crate::plant::{Plant, PlantError, PlantModel, Slip};
use crate::settings::Settings;
use crate::task::{Stage, Task};
use crate::time::RobotTime;
use on_the_way::{ON_THEIR_WAY, Packets, Queue};

/// Default time in s between poses: one per slot.
pub const FRAME: f64 = SLOT;

/// Default longest simulated time of an episode in s.
pub const TIME_LIMIT: f64 = 300.0;

/// Everything that an episode is made of, but its seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// The controller's settings.
    pub settings: Settings,
    /// What the robot really is.
    pub plant: PlantModel,
    /// The link between them.
    pub link: LinkModel,
    /// What it is to do.
    pub task: Task,
    /// Where it stands.
    pub start: Pose,
    /// A part of the room where floor or link are different.
    pub region: Option<Region>,
    /// Time in s between the poses that its camera takes.
    pub frame: f64,
    /// Simulated time in s after which the episode ends whatever the robot does.
    pub time_limit: f64,
}

/// A part of the room where floor or link are different, from wall to wall: a patch of film, a corner without reception.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// It begins at this world x in m.
    pub from: f64,
    /// It ends at this world x in m.
    pub to: f64,
    /// The floor there.
    pub slip: Slip,
    /// The link there.
    pub link: LinkModel,
}

impl Region {
    /// Whether a robot at `pose` is in it.
    pub fn holds(&self, pose: Pose) -> bool {
        (self.from..self.to).contains(&pose.x)
    }
}

/// Why an episode cannot run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EpisodeError {
    /// The link's model means nothing.
    #[error("link: {0}")]
    Link(#[from] LinkError),
    /// The robot's model means nothing.
    #[error("plant: {0}")]
    Plant(#[from] PlantError),
}

/// How an episode ended. What was identified is the controller's to say: see [`Scenario::run_with`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Whether the robot was seen at rest at its last waypoint.
    pub arrived: bool,
    /// Time in s since the calibration ended, until the arrival or the end of the episode.
    pub time: f64,
    /// Largest distance in m of the robot's true position from the current leg.
    pub max_deviation: f64,
}

/// One moment of an episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceRow {
    /// Simulated time in s.
    pub time: f64,
    /// Where the robot really is.
    pub pose: Pose,
    /// The wheel speeds that are applied from now on.
    pub applied: WheelSpeeds,
    /// What the controller is doing.
    pub stage: Stage,
    /// Waypoint that the robot is heading for.
    pub leg: usize,
    /// Distance in m from its leg of the newest true position that the controller has seen; 0 before the first.
    pub deviation: f64,
}

impl Scenario {
    /// Runs the episode. The same scenario and seed give the same outcome, bit for bit.
    ///
    /// # Errors
    /// Where link or plant mean nothing.
    pub fn run(&self, seed: u64) -> Result<Outcome, EpisodeError> {
        self.run_with(seed, |_| {}).map(|(outcome, _)| outcome)
    }

    /// Runs the episode and keeps its trace: a row for every change of wheel speeds and every pose.
    ///
    /// # Errors
    /// Where link or plant mean nothing.
    pub fn trace(&self, seed: u64) -> Result<(Outcome, Vec<TraceRow>), EpisodeError> {
        let mut rows = Vec::new();
        let (outcome, _) = self.run_with(seed, |row| rows.push(*row))?;
        Ok((outcome, rows))
    }

    /// Runs the episode, shows each row of its trace as it comes, and returns the controller as it ended. There is a row
    /// for every change of wheel speeds and every pose.
    ///
    /// # Errors
    /// Where link or plant mean nothing.
    pub fn run_with(
        &self,
        seed: u64,
        mut show: impl FnMut(&TraceRow),
    ) -> Result<(Outcome, Controller), EpisodeError> {
        self.drive(Controller::new(self.settings), seed, |row, _| show(row))
    }

    /// [`Scenario::run_with`] for any controller, which has its own settings: it is shown with each row.
    ///
    /// # Errors
    /// Where link or plant mean nothing.
    pub fn drive<E: PoseEstimator, D: DelayModel, F: PathFollower>(
        &self,
        controller: Controller<E, D, F>,
        seed: u64,
        show: impl FnMut(&TraceRow, &Controller<E, D, F>),
    ) -> Result<(Outcome, Controller<E, D, F>), EpisodeError> {
        self.drive_observed(controller, seed, show, &mut ())
    }

    /// [`Scenario::drive`], and `observer` sees what is learned.
    ///
    /// # Errors
    /// Where link or plant mean nothing.
    pub fn drive_observed<E: PoseEstimator, D: DelayModel, F: PathFollower>(
        &self,
        controller: Controller<E, D, F>,
        seed: u64,
        mut show: impl FnMut(&TraceRow, &Controller<E, D, F>),
        observer: &mut impl SampleObserver,
    ) -> Result<(Outcome, Controller<E, D, F>), EpisodeError> {
        let mut world = World::new(self, controller, seed)?;
        while world.now < self.time_limit && !world.server.controller.has_arrived() {
            world.next(observer);
            if world.moved == world.now {
                show(&world.row(), &world.server.controller);
            }
        }
        let Server { controller, max_deviation, .. } = world.server;
        let progress = controller.progress();
        let outcome = Outcome {
            arrived: progress.stage == Stage::Arrived,
            time: progress.elapsed,
            max_deviation,
        };
        Ok((outcome, controller))
    }
}

/// Robot, link and server of one episode, at one moment. Simulated time is in s; the robot's clock reads the same.
struct World<'a, E, D, F> {
    scenario: &'a Scenario,
    /// Whether the robot is in the region.
    is_inside: bool,
    now: f64,
    frames: u64,
    /// As it was at `moved`: it is moved on where a pose is taken or its command changes.
    plant: Plant,
    moved: f64,
    link: Link,
    exchange: Exchange,
    actuation: Actuation,
    server: Server<E, D, F>,
    applied: WheelSpeeds,
    /// Poses on their way from the camera.
    seen: Queue<Observation>,
    /// Requests and replies on their way.
    upward: Packets<Request>,
    downward: Packets<Horizon>,
}

/// The server, and what it cannot know: how far from its path the robot really is.
struct Server<E, D, F> {
    controller: Controller<E, D, F>,
    newest_request: u64,
    /// True positions that the controller has not seen yet: which leg they belong to is not known before.
    travelled: Queue<Point>,
    deviation: f64,
    max_deviation: f64,
}

impl<'a, E: PoseEstimator, D: DelayModel, F: PathFollower> World<'a, E, D, F> {
    fn new(
        scenario: &'a Scenario,
        mut controller: Controller<E, D, F>,
        seed: u64,
    ) -> Result<Self, EpisodeError> {
        controller.set_task(scenario.task.clone());
        if let Some(region) = &scenario.region {
            region.link.validate()?;
        }
        let mut world = Self {
            scenario,
            is_inside: false,
            now: 0.0,
            frames: 0,
            moved: 0.0,
            plant: Plant::new(scenario.plant, scenario.start, seed)?,
            link: Link::new(scenario.link.clone(), seed)?,
            exchange: Exchange::new(RobotTime::ZERO),
            actuation: Actuation::new(controller.settings().drive, RobotTime::ZERO),
            server: Server {
                controller,
                newest_request: 0,
                travelled: Queue::with_capacity(4 * ON_THEIR_WAY),
                deviation: 0.0,
                max_deviation: 0.0,
            },
            applied: WheelSpeeds::ZERO,
            seen: Queue::with_capacity(ON_THEIR_WAY),
            upward: Packets::new(Request::EMPTY),
            downward: Packets::new(Horizon::EMPTY),
        };
        world.enter_region();
        Ok(world)
    }

    /// Changes floor and link where the robot has come into the region or out of it.
    fn enter_region(&mut self) {
        let Scenario { region: Some(region), plant, link, .. } = self.scenario else { return };
        let is_inside = region.holds(self.plant.pose());
        if is_inside != self.is_inside {
            self.is_inside = is_inside;
            let (slip, link) =
                if is_inside { (region.slip, &region.link) } else { (plant.slip, link) };
            self.plant.set_slip(slip);
            // Both were checked before the first packet.
            let _ = self.link.set_model(link.clone());
        }
    }

    /// Goes on to the next moment at which something happens, and lets it happen.
    fn next(&mut self, observer: &mut impl SampleObserver) {
        let frame = self.frames as f64 * self.scenario.frame;
        let packet = least(self.upward.arrivals.first, self.downward.arrivals.first);
        let request = self.exchange.next_request(RobotTime::new(self.now));
        let robot = self.actuation.next_change().earlier(request).seconds();
        let next = most(self.now, least(least(frame, self.seen.first), least(packet, robot)));
        self.now = next;
        let now = RobotTime::new(next);
        if frame <= next {
            self.frames += 1;
            self.drive();
            let observation =
                Observation { pose: self.plant.observe(), taken: RobotTime::new(frame) };
            self.seen.insert(self.link.sensor(frame), observation);
        }
        while let Some(observation) = self.seen.due(next) {
            self.exchange.observe(observation);
        }
        while let Some(request) = self.upward.due(next) {
            if let Some(newest) = self.server.serve(request, observer)
                && let Some(arrival) = self.link.downlink(next)
            {
                let horizon = self.downward.place();
                horizon.clone_from(newest);
                horizon.answers = request.sequence;
                self.downward.send(arrival);
            }
        }
        while let Some(horizon) = self.downward.due(next) {
            self.exchange.reply(now, horizon.answers);
            self.actuation.accept(horizon);
        }
        let applied = self.actuation.advance(now);
        if applied != self.applied {
            self.drive();
            self.applied = applied;
        }
        let playing = self.actuation.playing();
        if self.exchange.write_request(now, playing, self.upward.place())
            && let Some(arrival) = self.link.uplink(next)
        {
            self.upward.send(arrival);
        }
    }

    /// Moves the robot on to this moment. From one call to the next it holds its speeds: its distance from a straight
    /// leg is greatest at one end.
    fn drive(&mut self) {
        if self.moved < self.now {
            self.plant.advance(self.applied, self.now - self.moved);
            self.moved = self.now;
            self.server.travelled.insert(self.now, self.plant.pose().point());
            self.enter_region();
        }
    }

    fn row(&self) -> TraceRow {
        let progress = self.server.controller.progress();
        TraceRow {
            time: self.now,
            pose: self.plant.pose(),
            applied: self.applied,
            stage: progress.stage,
            leg: progress.leg,
            deviation: self.server.deviation,
        }
    }
}

impl<E: PoseEstimator, D: DelayModel, F: PathFollower> Server<E, D, F> {
    /// A step, or a late one that only teaches; either way the newest horizon is the answer.
    fn serve(&mut self, request: &Request, observer: &mut impl SampleObserver) -> Option<&Horizon> {
        if request.sequence > self.newest_request {
            self.newest_request = request.sequence;
            let leg = self.controller.leg();
            self.controller.answer_observed(request, &mut Events::new(), observer);
            self.measure(leg);
        } else {
            self.controller.late(request);
        }
        self.controller.newest()
    }

    /// Measures the deviation of the positions that the controller has now seen, from the leg that they belong to.
    /// In a step that reaches a waypoint, positions on either side of it belong to the nearer of the two legs.
    fn measure(&mut self, before: Option<(Point, Point)>) {
        let after = self.controller.leg();
        let seen = self.controller.pose().map_or(f64::NEG_INFINITY, |pose| pose.taken.seconds());
        while let Some(point) = self.travelled.due(seen) {
            let legs = before.into_iter().chain(after);
            let distance = legs.map(|(from, to)| point.distance_to_segment(from, to));
            // Before the task begins and after it ends there is no leg.
            if before.is_some() {
                self.deviation = distance.fold(f64::INFINITY, f64::min);
                self.max_deviation = self.max_deviation.max(self.deviation);
            }
        }
    }
}

#[cfg(test)]
mod tests;
