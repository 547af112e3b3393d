//! What was commanded and what was seen of it, in cells of some tenths of a second, and how noisy the poses are.

use crate::exchange::{Observation, PoseNoise};
use crate::geometry::Displacement;
use crate::kinematics::{Drive, MotionModel};
use crate::time::RobotTime;

/// Shortest cell in s: three slots, so that one lost or late command is not all of it.
pub const CELL: f64 = 0.1;

/// Longest cell in s: a crawling robot with a noisy camera needs long ones to be distinguished from one that stands.
const LONGEST_CELL: f64 = 1.0;

/// Cells remembered: more than two seconds of the shortest, 32 s of the longest.
const CELLS: usize = 32;

/// Cells that ended longer ago than this many s say nothing of now.
const FORGOTTEN: f64 = 24.0;

/// What a drive's delay or a camera's may be beyond what was described, in s: 200 ms of an unstamped camera and 200 ms
/// of lag (field facts). What was commanded within it may not be seen yet.
pub const UNDESCRIBED_DELAY: f64 = 0.4;

/// Part of the smallest speeds below which nothing counts as commanded: what a lag leaves over.
const COMMANDED: f64 = 0.5;

/// A pose's share in the estimate of the noise, once there are many.
const NOISE_SHARE: f64 = 0.05;

/// The variance of the second difference of white noise of variance 1: 1 + 4 + 1.
const SECOND_DIFFERENCE: f64 = 6.0;

/// Longest time in s between poses whose differences say something of noise.
const NOISE_GAP: f64 = 2.0;

/// What the robot is commanded to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Driving, also along a curve.
    #[default]
    Drive,
    /// Turning in place.
    Turn,
}

/// One pose after another, and what the commands alone make of the way between.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The accepted pose before.
    pub from: Observation,
    /// The pose.
    pub to: Observation,
    /// The motion commanded between them.
    pub commanded: Displacement,
    /// How far the pose lies from where that motion leads: world x and y in m, heading in rad.
    pub off: [f64; 3],
}

/// A stretch of one kind of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Cell {
    kind: Kind,
    until: RobotTime,
    span: f64,
    /// Whether the robot had moved this way for long enough that nothing of the motion before is in it.
    settled: bool,
    /// Direction commanded: +1 or -1.
    side: f64,
    /// Motion commanded that way in m or rad.
    commanded: f64,
    /// Fastest speed commanded in m/s or rad/s.
    peak: f64,
    /// Motion seen in that direction: forward, left, turned.
    seen: [f64; 3],
}

/// The cell that is being filled.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Open {
    start: Observation,
    cell: Cell,
    /// When something was last commanded.
    active: RobotTime,
}

/// Cells summed up, newest first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Time in s.
    pub span: f64,
    /// Motion commanded, in m or rad.
    pub commanded: f64,
    /// The part of it that must have been seen by now whatever was not described.
    pub early: f64,
    /// Fastest speed of that part.
    pub peak: f64,
    /// Fastest speed of all.
    pub fastest: f64,
    /// Motion seen in the commanded direction: forward, left, turned.
    pub seen: [f64; 3],
    /// Distance or angle covered whichever way, that of each cell by itself: noise of the poses included.
    pub covered: f64,
    /// How many cells.
    pub cells: u32,
    /// When the oldest cell began and the newest ended, in robot time.
    pub times: (RobotTime, RobotTime),
}

/// The last cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    cells: [Cell; CELLS],
    count: usize,
    next: usize,
    open: Option<Open>,
    /// The kind and direction of the motion now, and since when.
    stretch: Option<(Kind, f64, RobotTime)>,
}

impl Evidence {
    /// Forgets all of it.
    pub fn clear(&mut self) {
        (self.count, self.open, self.stretch) = (0, None, None);
    }

    /// The newest motion: what was commanded, in m or rad, and what was seen of the turning centre forward, to the left and
    /// turned, in the commanded direction.
    pub fn newest(&self) -> (f64, [f64; 3]) {
        let Cell { commanded, seen, .. } = self.cells[(self.next + CELLS - 1) % CELLS];
        (commanded, seen)
    }

    /// Takes in one step; `least` is the motion in m and rad that a cell is to hold. Returns the kind of the cell that it
    /// ended, if it did.
    pub fn push(&mut self, drive: &Drive, step: &Step, least: [f64; 2]) -> Option<Kind> {
        let Step { from, to, commanded, .. } = step;
        let commanded = drive.of_centre(*commanded);
        let span = to.taken - from.taken;
        let (forward, turn) = (commanded.forward, commanded.turn);
        let is_active = forward.abs() >= COMMANDED * drive.min_linear * span
            || turn.abs() >= COMMANDED * drive.min_angular * span;
        if !is_active {
            let open = self.open.as_mut()?;
            open.cell.span += span;
            // The tail of the motion may come a while after its command.
            if to.taken - open.active <= UNDESCRIBED_DELAY {
                return None;
            }
            self.stretch = None;
            return self.close(drive, to);
        }
        let in_place = forward.abs() < drive.track_width / 2.0 * turn.abs();
        let (kind, motion) = if in_place { (Kind::Turn, turn) } else { (Kind::Drive, forward) };
        let side = 1.0_f64.copysign(motion);
        let mut ended = None;
        if let Some(open) = &self.open
            && (open.cell.kind, open.cell.side) != (kind, side)
        {
            ended = self.close(drive, from);
        }
        let since = match self.stretch {
            Some((now, way, since)) if (now, way) == (kind, side) => since,
            // From rest there is no other motion that may still go on.
            None => from.taken - UNDESCRIBED_DELAY,
            Some(_) => from.taken,
        };
        self.stretch = Some((kind, side, since));
        let settled = |start: &Observation| start.taken - since >= UNDESCRIBED_DELAY;
        let new =
            |start: &Observation| Cell { kind, side, settled: settled(start), ..Cell::default() };
        let cell = new(from);
        let open = self.open.get_or_insert(Open { start: *from, cell, active: to.taken });
        open.active = to.taken;
        let cell = &mut open.cell;
        cell.span += span;
        cell.commanded += motion.abs();
        cell.peak = cell.peak.max(motion.abs() / span);
        let is_long = cell.commanded >= least[kind as usize] || cell.span >= LONGEST_CELL;
        if cell.span >= CELL && is_long {
            let active = open.active;
            ended = self.close(drive, to);
            self.open = Some(Open { start: *to, cell: new(to), active });
        }
        ended
    }

    fn close(&mut self, drive: &Drive, end: &Observation) -> Option<Kind> {
        let Open { start, mut cell, .. } = self.open.take()?;
        if cell.span == 0.0 {
            return None;
        }
        let moved = drive.of_centre(end.pose.relative_to(start.pose));
        cell.until = end.taken;
        cell.seen = [moved.forward, moved.lateral, moved.turn].map(|it| cell.side * it);
        self.cells[self.next] = cell;
        self.next = (self.next + 1) % CELLS;
        self.count = (self.count + 1).min(CELLS);
        Some(cell.kind)
    }

    /// The newest cells of a kind, as few as are `enough`; none where all of them are not.
    pub fn latest(&self, kind: Kind, enough: impl Fn(&Sums) -> bool) -> Option<Sums> {
        self.sum(|cell| cell.kind == kind, enough)
    }

    /// The same of cells in which nothing is of another motion before, or of the same the other way.
    pub fn latest_settled(&self, kind: Kind, enough: impl Fn(&Sums) -> bool) -> Option<Sums> {
        self.sum(|cell| cell.kind == kind && cell.settled, enough)
    }

    /// Whether nothing of another motion is in the newest cell.
    pub fn is_settled(&self) -> bool {
        self.cells[(self.next + CELLS - 1) % CELLS].settled
    }

    fn sum(&self, counts: impl Fn(&Cell) -> bool, enough: impl Fn(&Sums) -> bool) -> Option<Sums> {
        let newest = self.cells[(self.next + CELLS - 1) % CELLS].until;
        let mut sums = Sums { times: (newest, newest), ..Sums::default() };
        for back in 1..=self.count {
            let cell = &self.cells[(self.next + CELLS - back) % CELLS];
            if newest - cell.until > FORGOTTEN {
                return None;
            }
            if !counts(cell) {
                continue;
            }
            sums.span += cell.span;
            sums.commanded += cell.commanded;
            sums.fastest = sums.fastest.max(cell.peak);
            if newest - cell.until >= UNDESCRIBED_DELAY {
                sums.early += cell.commanded;
                sums.peak = sums.peak.max(cell.peak);
            }
            for (sum, seen) in sums.seen.iter_mut().zip(cell.seen) {
                *sum += seen;
            }
            sums.covered += cell.seen[if cell.kind == Kind::Turn { 2 } else { 0 }].abs();
            sums.cells += 1;
            sums.times.0 = cell.until - cell.span;
            if enough(&sums) {
                return Some(sums);
            }
        }
        None
    }
}

/// How noisy the poses are, as they show it themselves: described noise may be none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jitter {
    last: Option<[f64; 3]>,
    count: u32,
    position: f64,
    heading: f64,
}

impl Jitter {
    /// Takes in how far a pose lies from where it was expected. What is constant in it is no noise: the variance of
    /// the second difference of white noise is six times that of the noise.
    pub fn push(&mut self, step: &Step) {
        if step.to.taken - step.from.taken > NOISE_GAP {
            self.last = None;
            return;
        }
        if let Some(last) = self.last.replace(step.off) {
            let [x, y, around] = [0, 1, 2].map(|i| {
                let difference = step.off[i] - last[i];
                difference * difference / SECOND_DIFFERENCE
            });
            self.count = self.count.saturating_add(1);
            let share = NOISE_SHARE.max(1.0 / f64::from(self.count));
            self.position += share * (f64::midpoint(x, y) - self.position);
            self.heading += share * (around - self.heading);
        }
    }

    /// The noise to reckon with: what is described, or what shows where that is more.
    pub fn at_least(&self, described: PoseNoise) -> PoseNoise {
        PoseNoise {
            position: described.position.max(self.position.sqrt()),
            heading: described.heading.max(self.heading.sqrt()),
        }
    }
}
