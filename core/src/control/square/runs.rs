//! What is seen of the runs of a square: where the robot rests between its motions, and what was commanded meanwhile.

use super::MOST_RUNS;
use super::course::{Course, MOTIONS, Part};
use super::report::{Ending, Report, Return};
use crate::actuation::Slew;
use crate::exchange::Observation;
use crate::geometry::{Angle, Point, Pose, Twist};
use crate::kinematics::{self, Drive};
use crate::task::Square;
use crate::time::RobotTime;
use arrayvec::ArrayVec;

/// Least poses of the rests at the beginning and the end of a run.
const LEAST_POSES: u32 = 3;

/// Time in s that the last rest of a run is seen at least, before it counts.
const SEEN_FOR: f64 = 1.0;

/// Part by which a motion may differ from what it is to be: the rest is known, as it was commanded. More is another motion.
const SAME_MOTION: f64 = 0.05;

/// Runs that may be begun anew before the square is given up.
const MOST_ANEW: u32 = 5;

/// Times the diagonal of the square that a robot may be away from where its run began.
const ALLOWED: f64 = 2.0;

/// Poses in a row that are too far away, so that no single one ends a square.
const FAR_POSES: u32 = 5;

/// What a pose came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// The run goes on.
    OnTheWay,
    /// The run is over; the next one begins.
    Returned,
    /// The run is none: it is to begin anew.
    Disturbed,
    /// The square is over.
    Over(Ending),
}

/// Where the robot rested: the mean of its poses, and where it was commanded to be.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    seen: Pose,
    commanded: Pose,
}

/// The poses of one rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rest {
    first: Pose,
    count: u32,
    /// Sums of their differences from the first, in m and rad.
    sums: [f64; 3],
}

impl Rest {
    fn add(&mut self, pose: Pose) {
        if self.count == 0 {
            self.first = pose;
        }
        self.count += 1;
        let first = self.first;
        let off = [pose.x - first.x, pose.y - first.y, pose.heading.minus(first.heading)];
        for (sum, off) in self.sums.iter_mut().zip(off) {
            *sum += off;
        }
    }

    fn mean(&self) -> Pose {
        let [x, y, heading] = self.sums.map(|sum| sum / f64::from(self.count.max(1)));
        let first = self.first;
        Pose { x: first.x + x, y: first.y + y, heading: first.heading + heading }
    }
}

/// The run under way.
#[derive(Clone, Debug, Default, PartialEq)]
struct Run {
    /// Where the robot rested before each motion so far.
    places: ArrayVec<Place, { MOTIONS as usize }>,
    rest: Rest,
    /// Since when zero is commanded; none within a motion.
    zero_since: Option<RobotTime>,
    /// Where it was commanded to be, from anywhere.
    commanded: Pose,
    /// What the motion under way came to, in m and rad.
    motion: Twist,
    /// Poses in a row that are too far away.
    far: u32,
    /// Why it is no run of the square.
    fault: Option<Ending>,
}

/// The runs of one square.
#[derive(Clone, Debug, PartialEq)]
pub struct Runs {
    course: Course,
    drive: Drive,
    /// What the robot makes of changes of plans.
    slew: Slew,
    run: Run,
    returns: ArrayVec<Return, MOST_RUNS>,
    /// Runs begun anew after a fault.
    anew: u32,
    begun: Option<RobotTime>,
    now: RobotTime,
}

impl Runs {
    /// Nothing seen yet.
    pub fn new(course: Course, drive: &Drive) -> Self {
        Self {
            course,
            drive: *drive,
            slew: Slew::new(Twist::ZERO),
            run: Run::default(),
            returns: ArrayVec::new(),
            anew: 0,
            begun: None,
            now: RobotTime::ZERO,
        }
    }

    /// The square as it was asked for.
    pub fn square(&self) -> Square {
        self.course.square()
    }

    /// Number of runs that were driven to their end: that of the one under way.
    pub fn driven(&self) -> u32 {
        self.returns.len() as u32
    }

    /// The run under way begins anew.
    pub fn begin_anew(&mut self) {
        self.run = Run::default();
    }

    /// The robot's clock counts anew.
    pub fn restart_clock(&mut self) {
        // What it took until then goes on to count.
        self.begun = self.begun.map(|begun| RobotTime::ZERO - (self.now - begun));
        self.now = RobotTime::ZERO;
        self.begin_anew();
    }

    /// `twist` was demanded from `from` on for `duration` s: what a robot makes of that which keeps to its limits.
    pub fn command(&mut self, from: RobotTime, twist: Twist, duration: f64) {
        let (drive, mut slew, mut time) = (self.drive, self.slew, from);
        slew.hold(&drive, twist, duration, |twist, duration| {
            self.played(time, twist, duration);
            time += duration;
        });
        self.slew = slew;
    }

    fn played(&mut self, from: RobotTime, twist: Twist, duration: f64) {
        let run = &mut self.run;
        if twist == Twist::ZERO {
            if run.zero_since.is_none() {
                run.zero_since = Some(from);
                run.rest = Rest::default();
                self.end_motion();
            }
            return;
        }
        if run.zero_since.take().is_some() {
            let is_first = run.places.is_empty();
            let place = Place { seen: run.rest.mean(), commanded: run.commanded };
            let enough = if is_first { LEAST_POSES } else { 1 };
            if run.rest.count < enough || run.places.try_push(place).is_err() {
                run.fault = Some(Ending::TooFewPoses);
            }
            run.motion = Twist::ZERO;
        }
        run.motion.linear += twist.linear * duration;
        run.motion.angular += twist.angular * duration;
        run.commanded = run.commanded.then(kinematics::integrate(twist, duration));
    }

    /// A motion is over: whether it was that of the square.
    fn end_motion(&mut self) {
        let Some(number) = self.run.places.len().checked_sub(1) else { return };
        let Twist { linear, angular } = self.run.motion;
        let is_it = match self.course.motion(self.driven(), number as u32) {
            Part::Side(length) => (linear - length).abs() <= SAME_MOTION * length,
            Part::Turn(angle) => (angular - angle).abs() <= SAME_MOTION * angle.abs(),
            Part::Rest(_) => false,
        };
        if !is_it {
            self.run.fault.get_or_insert(Ending::Interrupted);
        }
    }

    /// An accepted pose; the commands up to it are known. `settling` is the time in s that the robot takes to rest.
    pub fn pose(&mut self, observation: Observation, settling: f64) -> Seen {
        let Observation { pose, taken } = observation;
        self.begun.get_or_insert(taken);
        self.now = taken;
        if let Some(fault) = self.run.fault {
            self.begin_anew();
            self.anew += 1;
            return if self.anew > MOST_ANEW { Seen::Over(fault) } else { Seen::Disturbed };
        }
        let run = &mut self.run;
        let Some(since) = run.zero_since else { return self.look_far(pose) };
        if taken - since < settling {
            return Seen::OnTheWay;
        }
        run.rest.add(pose);
        let is_last = run.places.is_full();
        let is_seen = taken - since >= settling + SEEN_FOR && run.rest.count >= LEAST_POSES;
        if !(is_last && is_seen) {
            return Seen::OnTheWay;
        }
        self.returned();
        if self.driven() >= self.course.runs() {
            Seen::Over(Ending::Driven)
        } else {
            Seen::Returned
        }
    }

    fn look_far(&mut self, pose: Pose) -> Seen {
        let allowed = ALLOWED * self.course.side() * std::f64::consts::SQRT_2;
        let run = &mut self.run;
        let start = run.places.first();
        let is_far = start.is_some_and(|start| start.seen.point().distance(pose.point()) > allowed);
        run.far = if is_far { run.far + 1 } else { 0 };
        if run.far >= FAR_POSES { Seen::Over(Ending::TooFar) } else { Seen::OnTheWay }
    }

    /// Takes down the return of the run under way, and begins the next one.
    fn returned(&mut self) {
        let run = &self.run;
        let Some(start) = run.places.first().copied() else { return };
        let end = Place { seen: run.rest.mean(), commanded: run.commanded };
        let seen = end.seen.relative_to(start.seen);
        let commanded = end.commanded.relative_to(start.commanded);
        let places = || run.places.iter().copied().chain([end]);
        let sides = |of: fn(Place) -> Pose| {
            let sides = places().zip(places().skip(1)).step_by(2);
            let length = |(from, to): (Place, Place)| of(from).point().distance(of(to).point());
            sides.map(length).sum::<f64>() / 4.0
        };
        let returned = Return {
            is_left: Course::is_left(self.driven()),
            error: Point::new(seen.forward - commanded.forward, seen.lateral - commanded.lateral),
            heading: Angle::new(seen.turn - commanded.turn).radians(),
            side: sides(|place| place.seen),
            commanded: sides(|place| place.commanded),
        };
        let _ = self.returns.try_push(returned);
        self.begin_anew();
    }

    /// Time in s since the first pose.
    pub fn span(&self) -> f64 {
        self.begun.map_or(0.0, |begun| self.now - begun)
    }

    /// The report of a square that ended so, of a robot described by `drive`.
    pub fn report(&self, ending: Ending, drive: &Drive) -> Report {
        Report::of(ending, &self.course, &self.returns, drive, self.span())
    }
}
