//! What a robot did, and the limits that it kept.

use std::collections::{HashMap, VecDeque};
use std::path::Path;
use umwelt_agent::TraceRow;
use umwelt_core::geometry::{Pose, Twist, WheelSpeeds};
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics::{self, Drive};

/// Longest window in s over which changes of speed are looked at: longer than a whole ramp.
const WINDOW: f64 = 0.6;

/// Rounding of times and speeds in a written trace, in s of acceleration.
const ROUNDING: f64 = 1e-3;

/// Longest time in s without a row: many slots, for a machine that has other things to do.
const HOLE: f64 = 0.5;

/// Reads the trace that an agent wrote.
///
/// # Panics
/// Where it is no trace.
pub fn read(path: &Path) -> Vec<TraceRow> {
    let text = std::fs::read_to_string(path);
    let text = text.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    lines
        .map(|line| {
            let values = line.split(',').map(|value| value.parse::<f64>().ok());
            let row: HashMap<&str, Option<f64>> = header.iter().copied().zip(values).collect();
            let value = |name: &str| row.get(name).copied().flatten();
            let known = |name: &str| {
                value(name).unwrap_or_else(|| panic!("no {name} in {line:?} under {header:?}"))
            };
            let pose = value("x_m").map(|x| Pose::new(x, known("y_m"), known("heading_rad")));
            let (left, right) = (known("left_rad_per_s"), known("right_rad_per_s"));
            TraceRow { time: known("t_s"), pose, applied: WheelSpeeds { left, right } }
        })
        .collect()
}

/// The twist that a row commands.
pub fn twist(drive: &Drive, row: &TraceRow) -> Twist {
    kinematics::forward(drive, row.applied)
}

/// The limits of a drive, kept by what a robot is told one by one: wheel and body speeds, and their changes.
///
/// Over any time the change is what the acceleration limits allow in that time and one slot more, which may come at
/// once as in any stepped command; the step between rest and the smallest speed is free.
#[derive(Clone, Debug)]
pub struct Limits {
    drive: Drive,
    recent: VecDeque<(f64, Twist)>,
}

impl Limits {
    /// Those of `drive`, of a robot that has been told nothing yet.
    pub fn new(drive: Drive) -> Self {
        Self { drive, recent: VecDeque::new() }
    }

    /// Takes in that the wheels are told `applied` from `time` s on; says which limit that does not keep.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn check(&mut self, time: f64, applied: WheelSpeeds) -> Result<(), String> {
        let drive = &self.drive;
        let now = kinematics::forward(drive, applied);
        let wheel = applied.left.abs().max(applied.right.abs());
        // What is no number is within no limit.
        let is_slow = now.linear.abs() <= drive.max_linear + ROUNDING * 1e-3
            && now.angular.abs() <= drive.max_angular + ROUNDING * 1e-2;
        let is_wheel_slow = wheel <= drive.max_wheel_speed + ROUNDING * 1e-2;
        while self.recent.front().is_some_and(|(before, _)| *before + WINDOW < time) {
            self.recent.pop_front();
        }
        let mut wrong = None;
        for &(before, twist) in &self.recent {
            let allowed = time - before + SLOT + ROUNDING;
            let needed = drive.change_time(twist, now);
            if time < before {
                wrong = Some(format!("time goes back from {before} s to {time} s"));
            } else if needed > allowed {
                wrong = Some(format!(
                    "{needed} s of acceleration in {allowed} s, from {twist:?} to {now:?} at {time} s"
                ));
            }
        }
        self.recent.push_back((time, now));
        match wrong {
            _ if !is_slow => Err(format!("too fast: {now:?} at {time} s")),
            _ if !is_wheel_slow => Err(format!("wheel too fast: {applied:?} at {time} s")),
            Some(wrong) => Err(wrong),
            None => Ok(()),
        }
    }
}

/// Checks that wheel and body speeds and their changes kept the limits of `drive` at every moment.
///
/// # Panics
/// Where a limit was not kept.
pub fn assert_within_limits(rows: &[TraceRow], drive: &Drive) {
    assert!(rows.len() > 10, "a trace of {} rows shows nothing", rows.len());
    let mut limits = Limits::new(*drive);
    for row in rows {
        assert_eq!(limits.check(row.time, row.applied), Ok(()), "{row:?}");
    }
}

/// Checks that the robot rested from `from` to `to`, both in robot time, and that nothing of it is unknown.
///
/// # Panics
/// Where it moved, or nothing is known about a part of that time.
pub fn assert_rests(rows: &[TraceRow], from: f64, to: f64) {
    let mut known = from;
    for row in rows.iter().filter(|row| (from..=to).contains(&row.time)) {
        assert_eq!(row.applied, WheelSpeeds::ZERO, "it moves at {} s: {row:?}", row.time);
        assert!(row.time <= known + HOLE, "nothing is known from {known} s to {} s", row.time);
        known = row.time;
    }
    assert!(to <= known + HOLE, "nothing is known from {known} s to {to} s");
}

/// The last row at or before robot time `time`.
///
/// # Panics
/// Where there is none.
pub fn at(rows: &[TraceRow], time: f64) -> &TraceRow {
    rows.iter().rfind(|row| row.time <= time).expect("the trace begins before")
}
