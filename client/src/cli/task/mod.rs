//! `umwelt task`.

mod assign;

use super::check_report;
use super::failure::Failure;
use super::input;
use super::output::Output;
use super::progress::{StatusLine, wait};
use super::quantity::{self, metres, millimetres};
use super::square_report;
use super::table::{Column, Table};
pub(super) use assign::assign;
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval};
use umwelt_api::RobotId;
use umwelt_api::Validate;
use umwelt_api::robot::{Robot, State};
use umwelt_api::task::{Calibration, Spec, Stage, Task, Waypoint};
use umwelt_client::{Client, Error};

/// How often progress is asked for: fast enough for an eye, slow enough for a bad link.
const LOOK: Duration = Duration::from_millis(500);

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Give a robot a task, in place of the one before
    #[command(after_help = SET_EXAMPLES)]
    Set(Box<Set>),
    /// Show the task of a robot and how far it has got
    Show {
        /// The robot
        #[arg(value_name = "ID")]
        robot: RobotId,
    },
    /// Cancel the task of a robot: it ramps to rest
    Cancel {
        /// The robot
        #[arg(value_name = "ID")]
        robot: RobotId,
    },
}

const SET_EXAMPLES: &str = "\
With --calibrate the robot first turns left and right and drives 0.3 m forward and back, to learn what floor and link are
like. Give it the room, or another calibration: each flag of one asks for it.

A task that is the same as the one under way goes on as it is; once the robot has arrived, it is driven again. --again
drives it from its beginning in any case.

With --watch the exit status is 0 once the robot has arrived. Ctrl-C ends the watching, not the task.

Examples:
  umwelt task set rover-7 --waypoint 0.2,0 --waypoint 0,0 --calibrate --watch
  umwelt task set rover-7 --waypoint -0.2,-0.1 --reverse --calibration-straight 0.1
  umwelt --json task show rover-7 | jq .spec | umwelt task set rover-8 --file -";

#[derive(Debug, Args)]
pub(super) struct Set {
    /// The robot
    #[arg(value_name = "ID")]
    robot: RobotId,
    /// A place to stop at, in metres; again for each further one
    #[arg(
        long = "waypoint",
        value_name = "X,Y",
        required_unless_present = "file",
        value_parser = input::waypoint,
        allow_hyphen_values = true
    )]
    waypoints: Vec<Waypoint>,
    /// Task in JSON, - for standard input; flags win over it
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Distance from a waypoint within which the robot has arrived [default: that of the robot]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Largest distance from the path before the robot rests [default: the leg's length, at least ten track widths]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    max_deviation: Option<f64>,
    /// Drive in reverse toward waypoints behind the robot, rather than turn round
    #[arg(long)]
    reverse: bool,
    /// Drive from the beginning, even where this very task is under way
    #[arg(long)]
    again: bool,
    /// Show progress until the robot arrives
    #[arg(long)]
    watch: bool,
    // Last, because its heading holds for all flags below it.
    #[command(flatten)]
    calibration: CalibrationFlags,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Calibration")]
struct CalibrationFlags {
    /// Turn left and right and drive ahead and back before the task, to learn the floor [default: begin at once]
    #[arg(long)]
    calibrate: bool,
    /// Begin at once although the file has a calibration
    #[arg(
        long,
        conflicts_with_all = [
            "calibrate",
            "calibration_straight",
            "calibration_rotations",
            "calibration_turn",
            "calibration_rotate",
            "calibration_pause",
        ]
    )]
    no_calibration: bool,
    /// Length of the straight part, forward and back; 0 where there is no room [default: 0.3]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    calibration_straight: Option<f64>,
    /// How often the robot turns, alternately left and right [default: 10]
    #[arg(long, value_name = "N")]
    calibration_rotations: Option<u32>,
    /// Angular velocity of the turns [default: 0.8]
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    calibration_turn: Option<f64>,
    /// Time of each turn [default: 0.9]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    calibration_rotate: Option<f64>,
    /// Rest after each turn [default: 0.3]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    calibration_pause: Option<f64>,
}

impl Command {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        match self {
            Self::Set(set) => {
                let spec = set.spec()?;
                let task = wait(assign(client, &set.robot, &spec, set.again)).await?;
                if !set.watch {
                    return output.result(&task, accepted);
                }
                output.line(&task, accepted)?;
                watch(client, output, task).await
            }
            Self::Show { robot } => output.result(&wait(client.get_task(&robot)).await?, show),
            Self::Cancel { robot } => {
                wait(client.cancel_task(&robot)).await?;
                let answer = json!({ "robot": robot, "cancelled": true });
                output.result(&answer, |_| format!("the task of {robot} is cancelled"))
            }
        }
    }
}

impl Set {
    /// The file, with the flags on top.
    fn spec(&self) -> Result<Spec, Failure> {
        let mut source = "the task".to_owned();
        let mut spec = match &self.file {
            Some(path) => {
                source = input::name(path);
                let json = input::read(path)?;
                let read = Spec::read(&json);
                let spec = read.map_err(|problems| Failure::wrong_body(&source, &problems))?;
                source.push_str(" with these flags");
                spec.into_inner()
            }
            None => empty()?,
        };
        if !self.waypoints.is_empty() {
            spec.waypoints.clone_from(&self.waypoints);
        }
        if self.tolerance.is_some() {
            spec.tolerance_m = self.tolerance;
        }
        if self.max_deviation.is_some() {
            spec.max_deviation_m = self.max_deviation;
        }
        spec.reverse |= self.reverse;
        spec.calibration = self.calibration.on_top_of(spec.calibration);
        spec.validate().map_err(|problems| Failure::wrong_body(&source, &problems))?;
        Ok(spec)
    }
}

/// A task without waypoints as the contract fills it in.
fn empty() -> Result<Spec, Failure> {
    let spec = json!({ "waypoints": [] });
    serde_json::from_value(spec).map_err(|error| Failure::Failed(format!("no empty task: {error}")))
}

impl CalibrationFlags {
    fn on_top_of(&self, before: Option<Calibration>) -> Option<Calibration> {
        let Self {
            calibrate,
            no_calibration,
            calibration_straight,
            calibration_rotations,
            calibration_turn,
            calibration_rotate,
            calibration_pause,
        } = self;
        let numbers =
            [calibration_straight, calibration_turn, calibration_rotate, calibration_pause];
        let given = *calibrate
            || calibration_rotations.is_some()
            || numbers.iter().any(|number| number.is_some());
        if *no_calibration {
            return None;
        }
        if !given {
            return before;
        }
        let before = before.unwrap_or_default();
        Some(Calibration {
            rotations: calibration_rotations.unwrap_or(before.rotations),
            angular_rad_per_s: calibration_turn.unwrap_or(before.angular_rad_per_s),
            rotate_s: calibration_rotate.unwrap_or(before.rotate_s),
            pause_s: calibration_pause.unwrap_or(before.pause_s),
            straight_m: calibration_straight.unwrap_or(before.straight_m),
        })
    }
}

async fn watch(client: &Client, output: &mut Output, task: Task) -> Result<(), Failure> {
    let robot = task.robot.clone();
    tokio::select! {
        ended = follow(client, output, task) => ended,
        _ = tokio::signal::ctrl_c() => Err(Failure::Failed(format!(
            "not watched to the end; {robot} goes on: umwelt task show {robot}, umwelt stop {robot}"
        ))),
    }
}

/// Follows a task until the robot arrives.
///
/// A bad link or a restarting server does not end it; another task in its place, or none, does.
async fn follow(client: &Client, output: &mut Output, mut task: Task) -> Result<(), Failure> {
    let robot = task.robot.clone();
    let mut line = StatusLine::new();
    let mut looks = interval(LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        looks.tick().await;
        let (now, shown) = match look(client, &robot).await {
            Ok(seen) => seen,
            Err(error) if error.is_transient() => {
                line.show("no answer", &format!("still trying: {error}"));
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        if now.etag != task.etag {
            return Err(Failure::Failed(format!("{robot} was given another task meanwhile")));
        }
        let news = now.progress != task.progress;
        task = now;
        if task.progress.stage == Stage::Arrived {
            line.clear();
            let arrived = |task: &Task| format!("{robot} {}", quantity::progress(&task.progress));
            return output.line(&task, arrived);
        }
        if news {
            output.json_line(&task)?;
        }
        line.show(&substance(&shown, &task), &status(&shown, &task));
    }
}

async fn look(client: &Client, robot: &RobotId) -> Result<(Task, Robot), Error> {
    let (task, robot) = tokio::join!(client.get_task(robot), client.get_robot(robot));
    Ok((task?, robot?))
}

/// What is worth a line of its own in a log.
fn substance(robot: &Robot, task: &Task) -> String {
    let Robot { state, stopped, held, watch, .. } = robot;
    let watch = watch.as_ref().map_or("", |watch| watch.state.name());
    format!("{state:?} {stopped} {held} {watch} {}", quantity::short_progress(&task.progress))
}

/// How a robot gets on, and what it waits for.
fn status(robot: &Robot, task: &Task) -> String {
    let progress = quantity::progress(&task.progress);
    let id = &robot.robot;
    if robot.stopped {
        return format!("{id}: stopped until resumed (umwelt resume {id}); {progress}");
    }
    if robot.held && robot.state == State::Connected {
        return format!("{id}: held by the robot itself, goes on when it lets go; {progress}");
    }
    match robot.state {
        State::Connected => match &robot.watch {
            Some(watch) => {
                let rests = watch.rests && watch.state != umwelt_api::watch::State::NoPoses;
                let resume = if rests { format!(" (umwelt resume {id})") } else { String::new() };
                format!("{id}: {}{resume}; {progress}", quantity::watch(watch))
            }
            None => format!("{id}: {progress}"),
        },
        State::Never => format!("{id}: never seen, goes when its agent comes; {progress}"),
        State::Failed => {
            format!("{id}: the server's computation for it does not end, see its log; {progress}")
        }
        State::Lost => {
            format!("{id}: {}, goes on when it is back; {progress}", quantity::presence(robot))
        }
    }
}

fn accepted(task: &Task) -> String {
    if task.spec.check.is_some() {
        return format!("{}: a check", task.robot);
    }
    if let Some(square) = &task.spec.square {
        let runs =
            if square.runs == 1 { "once".to_owned() } else { format!("{} times", square.runs) };
        return format!("{}: a square, {runs} each way", task.robot);
    }
    let calibration = match &task.spec.calibration {
        None => "no calibration".to_owned(),
        Some(Calibration { rotations, straight_m, .. }) => {
            format!("after a calibration of {rotations} turns and {} straight", metres(*straight_m))
        }
    };
    let count = task.spec.waypoints.len();
    let waypoints = if count == 1 { "waypoint" } else { "waypoints" };
    format!("{}: {count} {waypoints}, {calibration}", task.robot)
}

fn show(task: &Task) -> String {
    let Task { robot, spec, progress, .. } = task;
    if spec.check.is_some() {
        let report = task.check.as_ref();
        let report = report.map_or_else(String::new, |report| check_report::text(robot, report));
        return format!("{}, {}\n{report}", accepted(task), quantity::progress(progress));
    }
    if spec.square.is_some() {
        let report = task.square.as_ref();
        let report = report.map_or_else(String::new, |report| square_report::text(robot, report));
        return format!("{}, {}\n{report}", accepted(task), quantity::progress(progress));
    }
    let within =
        spec.tolerance_m.map_or_else(String::new, |m| format!(", within {}", millimetres(m)));
    let reverse = if spec.reverse { ", in reverse where shorter" } else { "" };
    let mut table = Table::new([
        Column::Number("WAYPOINT"),
        Column::Number("X"),
        Column::Number("Y"),
        Column::Text(""),
    ]);
    for (index, waypoint) in spec.waypoints.iter().enumerate() {
        let state = match index {
            _ if progress.stage == Stage::Idle || progress.stage == Stage::Calibrating => "",
            index if index < progress.leg => "reached",
            index if index == progress.leg => quantity::stage(progress.stage),
            _ => "",
        };
        let number = (index + 1).to_string();
        table.row([number, metres(waypoint.x_m), metres(waypoint.y_m), state.to_owned()]);
    }
    format!(
        "{robot}: {}\n{}{within}{reverse}\n\n{table}",
        quantity::progress(progress),
        accepted(task).split_once(": ").map_or("", |(_, rest)| rest),
    )
}

#[cfg(test)]
mod tests;
