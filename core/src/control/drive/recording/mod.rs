//! A recording of a robot that somebody drove: its poses, its commands, and what they say of its drive.
//!
//! It is cut into stretches of motion for a belief ([`identified`]). What that is worth shows in poses that it has not seen:
//! the drive identified from the first half predicts the second ([`ahead`]).

mod ahead;
mod identified;
mod jumps;
mod rough;

pub use ahead::{ErrorsAhead, Followed, Percentiles};
pub use identified::{Comparison, Identified};

use super::stretch::{APART, GAP};
use super::{Commanded, LONGEST, MAX_SPAN, Stretch};
use crate::exchange::Observation;
use crate::geometry::Twist;
use crate::time::RobotTime;
use std::iter::Peekable;

/// What a stamp may be early by in s: poses every 20 ms are not all exactly so far apart.
const JITTER: f64 = 0.002;

/// For so many s before a stretch it is known what was commanded: after the longest sum of dead time and lag the state of the
/// wheels before is forgotten.
const HISTORY: f64 = 2.0 * LONGEST;

/// Fewest poses of a stretch that says something.
const FEWEST: usize = 3;

/// Poses and commands of one robot, by one clock as far as that was possible.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Every pose later than the one before.
    pub poses: Vec<Observation>,
    /// What was commanded from a time on until the next one, each later than the one before.
    pub commands: Vec<(RobotTime, Twist)>,
}

impl Recording {
    /// When poses are of use in s: what was commanded is known for [`LONGEST`] before, and was not given up since. None
    /// where poses and commands have no such time in common.
    ///
    /// After the last command it is known for [`LONGEST`], and on where that was to rest: robots stop by themselves
    /// when commands fail to come.
    pub fn known(&self) -> Option<(RobotTime, RobotTime)> {
        let ((first, _), (last, twist)) = (self.commands.first()?, self.commands.last()?);
        let end = if *twist == Twist::ZERO { RobotTime::NEVER } else { *last + LONGEST };
        let from = (*first + LONGEST).later(self.poses.first()?.taken);
        let until = end.earlier(self.poses.last()?.taken);
        (from < until).then_some((from, until))
    }

    /// The stretches in which something is commanded to move, or was shortly before.
    pub fn stretches(&self) -> impl Iterator<Item = (Stretch, Commanded)> + '_ {
        let (from, until) = self.known().unwrap_or((RobotTime::NEVER, RobotTime::NEVER));
        let known = self.poses.iter().copied();
        let known = known.skip_while(move |pose| pose.taken < from);
        let mut poses = known.take_while(move |pose| pose.taken <= until).peekable();
        let (mut before, mut in_force) = (None, 0);
        std::iter::from_fn(move || {
            loop {
                let stretch = next_stretch(&mut poses, &mut before)?;
                let (first, last) = stretch.ends()?;
                let commanded = self.commanded(first.taken - HISTORY, last.taken, &mut in_force);
                if stretch.poses.len() >= FEWEST && commanded.moves() {
                    return Some((stretch, commanded));
                }
            }
        })
    }

    /// What was commanded from `from` to `until`. `in_force` is the index of a command at `from` or before; of the last of
    /// these, afterwards.
    fn commanded(&self, from: RobotTime, until: RobotTime, in_force: &mut usize) -> Commanded {
        let begins = |index: usize| self.commands.get(index).map(|(time, _)| *time);
        while begins(*in_force + 1).is_some_and(|begin| begin <= from) {
            *in_force += 1;
        }
        let mut commanded = Commanded::new(from);
        let mut time = from;
        for (index, (_, twist)) in self.commands.iter().enumerate().skip(*in_force) {
            if time >= until {
                break;
            }
            let end = begins(index + 1).map_or(until, |next| next.earlier(until));
            if end > time {
                commanded.add(*twist, end - time);
                time = end;
            }
        }
        commanded
    }
}

/// The poses up to the next gap, or as many as a stretch holds. It begins with the last one `before` where there is no gap.
fn next_stretch(
    poses: &mut Peekable<impl Iterator<Item = Observation>>,
    before: &mut Option<Observation>,
) -> Option<Stretch> {
    let mut stretch = Stretch::default();
    let mut last = before.take().or_else(|| poses.next())?;
    let first = last;
    stretch.push(first);
    while let Some(pose) = poses.peek().copied() {
        let apart = pose.taken - last.taken;
        if apart > GAP {
            return Some(stretch);
        }
        if apart >= APART - JITTER {
            if pose.taken - first.taken > MAX_SPAN || !stretch.push(pose) {
                *before = Some(last);
                return Some(stretch);
            }
            last = pose;
        }
        poses.next();
    }
    Some(stretch)
}

#[cfg(test)]
mod tests;
