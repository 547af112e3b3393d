//! Reads poses and commands line by line.

use super::super::failure::Failure;
use super::super::input;
use super::columns::{Column, Columns, cells};
use super::drive::Wheels;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use umwelt_core::drive::Recording;
use umwelt_core::exchange::Observation;
use umwelt_core::geometry::{Pose, Twist};
use umwelt_core::time::RobotTime;

/// Longest line: a file without an end of line is no CSV.
const MAX_LINE: u64 = 64 << 10;

/// How often the number of rows is said.
const EVERY: usize = 10_000;

/// Poses and commands of all files, with their times in s.
#[derive(Default)]
pub(super) struct Rows {
    poses: Vec<(f64, Pose)>,
    commands: Vec<(f64, Twist)>,
}

/// A file under way.
struct Place<'a> {
    name: &'a str,
    line: usize,
    /// The last times of poses and of commands.
    pose: f64,
    command: f64,
}

impl Place<'_> {
    fn wrong(&self, text: &str) -> Failure {
        Failure::Wrong(format!("{} line {}: {text}", self.name, self.line))
    }
}

impl Rows {
    /// Adds those of a file; calls `progress` with the number of rows so far now and then.
    pub(super) fn read(
        &mut self,
        path: &Path,
        wheels: &Wheels,
        progress: &mut impl FnMut(usize),
    ) -> Result<(), Failure> {
        let name = input::name(path);
        let failed = |error: &io::Error| Failure::Wrong(format!("cannot read {name}: {error}"));
        let mut lines: Box<dyn BufRead> = if input::is_standard(path) {
            Box::new(io::stdin().lock())
        } else {
            Box::new(BufReader::new(File::open(path).map_err(|error| failed(&error))?))
        };
        let mut place =
            Place { name: &name, line: 0, pose: f64::NEG_INFINITY, command: f64::NEG_INFINITY };
        let (mut columns, mut bytes) = (None, Vec::new());
        loop {
            bytes.clear();
            let limited = (&mut lines).take(MAX_LINE).read_until(b'\n', &mut bytes);
            let read = limited.map_err(|error| failed(&error))?;
            if read == 0 {
                break;
            }
            place.line += 1;
            if read as u64 == MAX_LINE {
                return Err(place.wrong("longer than 64 KiB: is it CSV?"));
            }
            let text = String::from_utf8_lossy(&bytes);
            let row = text.trim_start_matches('\u{feff}').trim();
            if row.is_empty() {
                continue;
            }
            match &columns {
                None => columns = Some(Columns::read(row).map_err(|it| place.wrong(&it))?),
                Some(columns) => self.row(row, columns, wheels, &mut place)?,
            }
            if place.line.is_multiple_of(EVERY) {
                progress(self.poses.len() + self.commands.len());
            }
        }
        match columns {
            Some(_) => Ok(()),
            None => Err(Failure::Wrong(format!("{name} is empty: it has to begin with a header"))),
        }
    }

    fn row(
        &mut self,
        row: &str,
        columns: &Columns,
        wheels: &Wheels,
        place: &mut Place,
    ) -> Result<(), Failure> {
        let cells: Vec<&str> = cells(row).collect();
        let pose = group(&cells, columns.pose, place)?;
        let turning = group(&cells, columns.wheels, place)?;
        let twist = group(&cells, columns.twist, place)?.map(|[v, w]| Twist::new(v, w));
        let command = match (twist, turning) {
            (None, Some([left, right])) => Some(wheels.twist(left, right).ok_or_else(|| {
                place.wrong(
                    "wheel speeds say nothing without wheels: add --drive wheel_radius_m=...,track_width_m=...",
                )
            })?),
            (twist, _) => twist,
        };
        if pose.is_none() && command.is_none() {
            return Ok(());
        }
        let Some([time]) = group(&cells, Some([columns.time]), place)? else {
            return Err(
                place.wrong("t_s is empty: every row with a pose or a command needs its time")
            );
        };
        if let Some([x, y, heading]) = pose {
            place.pose = later(place.pose, time, "pose", place)?;
            self.poses.push((time, Pose::new(x, y, heading)));
        }
        if let Some(twist) = command {
            place.command = later(place.command, time, "command", place)?;
            self.commands.push((time, twist));
        }
        Ok(())
    }

    /// All of them in their order, the times of poses later by `shift` s. Of commands at one time the last one holds, of poses
    /// the first one.
    pub(super) fn recording(self, shift: f64) -> Recording {
        let Self { mut poses, mut commands } = self;
        // Stable: what is of one time stays in its order.
        poses.sort_by(|one, other| one.0.total_cmp(&other.0));
        poses.dedup_by(|next, kept| next.0 == kept.0);
        commands.sort_by(|one, other| one.0.total_cmp(&other.0));
        commands.dedup_by(|next, kept| {
            let is_same_time = next.0 == kept.0;
            if is_same_time {
                *kept = *next;
            }
            is_same_time
        });
        let observation = |(time, pose)| Observation { pose, taken: RobotTime::new(time + shift) };
        Recording {
            poses: poses.into_iter().map(observation).collect(),
            commands: commands.into_iter().map(|(time, it)| (RobotTime::new(time), it)).collect(),
        }
    }
}

/// The numbers of these columns; none where all of their cells are empty.
fn group<const N: usize>(
    cells: &[&str],
    columns: Option<[Column; N]>,
    place: &Place,
) -> Result<Option<[f64; N]>, Failure> {
    let Some(columns) = columns else { return Ok(None) };
    let cell = |place: usize| cells.get(place).copied().unwrap_or_default();
    if columns.iter().all(|(_, place)| cell(*place).is_empty()) {
        return Ok(None);
    }
    let mut numbers = [0.0; N];
    for (number, (name, at)) in numbers.iter_mut().zip(columns) {
        let text = cell(at);
        if text.is_empty() {
            return Err(place.wrong(&format!(
                "{name} is empty: fill it, or empty all cells of that pose or command"
            )));
        }
        let read = text.parse().ok().filter(|number: &f64| number.is_finite());
        *number = read.ok_or_else(|| {
            place.wrong(&format!(
                "{name} is \"{text}\", no finite number: leave the row out, or its cells empty"
            ))
        })?;
    }
    Ok(Some(numbers))
}

/// `time`, where it is none before that of the `last` pose or command.
fn later(last: f64, time: f64, what: &str, place: &Place) -> Result<f64, Failure> {
    if time < last {
        return Err(place.wrong(&format!(
            "t_s is {time}, before the {what} above it at {last}: sort the rows by t_s, and give each recording by itself"
        )));
    }
    Ok(time)
}
