//! `umwelt robot`.

mod accept;
mod calibrate;
mod check;
mod description;
mod motion;
mod ready;

use super::failure::Failure;
use super::input;
use super::output::Output;
use super::progress::{say, wait};
use super::quantity::{self, metres, millimetres, milliseconds, or_unknown, radians};
use super::table::{Column, Table};
use super::unreadable::with;
use clap::{Args, Subcommand};
use description::{Flags, understood};
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;
use umwelt_api::RobotId;
use umwelt_api::problem::Status;
use umwelt_api::robot::{Page, Robot, State};
use umwelt_client::Client;

const STATES: &[&str] = &["never", "connected", "lost", "failed"];

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Describe a robot: what is not said follows from the rest
    #[command(after_help = ADD_EXAMPLES)]
    Add(Box<Add>),
    /// Change parts of what was said about a robot
    #[command(after_help = SET_EXAMPLES, arg_required_else_help = true)]
    Set(Box<Set>),
    /// List robots; one that fell silent stays, with its last pose
    List {
        /// Only robots in this state
        #[arg(long, value_parser = input::named::<State>(STATES))]
        state: Option<State>,
    },
    /// Show a robot: how it is now, and all that was said about it
    Show {
        /// The robot
        #[arg(value_name = "ID")]
        robot: RobotId,
    },
    /// Find what is wrong with a robot or its tracker: it wiggles for some 20 s
    #[command(after_help = check::HELP)]
    Check(check::Check),
    /// Find what of its wheels and track is not as described: it drives a square both ways (UMBmark)
    #[command(after_help = calibrate::HELP)]
    Calibrate(calibrate::Calibrate),
    /// Remove a robot with its task and what was learned; if it still drives, it ramps to rest
    Remove {
        /// The robot
        #[arg(value_name = "ID")]
        robot: RobotId,
    },
}

const ADD_EXAMPLES: &str = "\
Say what you know: wheels, track and top speed, and the noise of the tracker if you know it. The rest has a default, or
follows from what you say; the answer lists all of it. `umwelt robot set` changes parts of it later.
`umwelt --json robot show ID | jq .described` makes a file.

Examples:
  umwelt robot add rover-7
  umwelt robot add burger --wheel-radius 0.033 --track-width 0.16 --max-speed 0.22
  umwelt robot add rover-7 --method statistic --slots 1
  umwelt robot add rover-7 --file spec.json --lag 0.12
  jq .rover spec.json | umwelt robot add rover-7 --file - --replace";

const SET_EXAMPLES: &str = "\
Only what the flags say is changed; what follows from it follows. A task goes on; what was learned is kept unless method,
prior or drift change.

Examples:
  umwelt robot set rover-7 --prior wet-hall
  umwelt robot set rover-7 --max-speed 0.2 --position-noise 0.002
  umwelt robot set rover-7 --unset drive.lag_s --unset method";

#[derive(Debug, Args)]
pub(super) struct Add {
    /// The robot: 1 to 63 of A-Z, a-z, 0-9, -, _ and .
    #[arg(value_name = "ID")]
    robot: RobotId,
    /// Description in JSON, - for standard input; flags win over it
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Describe a robot anew that there is already: what is not said is default again
    #[arg(long)]
    replace: bool,
    #[command(flatten)]
    flags: Flags,
}

#[derive(Debug, Args)]
pub(super) struct Set {
    /// The robot
    #[arg(value_name = "ID")]
    robot: RobotId,
    /// A field that is to be default again, or to follow from the rest: drive.lag_s
    #[arg(long, value_name = "FIELD")]
    unset: Vec<String>,
    #[command(flatten)]
    flags: Flags,
}

impl Command {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        match self {
            Self::Add(add) => {
                let robot = self::add(client, &add).await?;
                output.result(&robot, |robot| described(robot, "described"))
            }
            Self::Set(set) => {
                let Set { robot, unset, flags } = *set;
                let patch = flags.patch(&unset)?;
                let robot = wait(client.patch_robot(&robot, &patch)).await?;
                output.result(&robot, |robot| described(robot, "changed"))
            }
            Self::List { state } => {
                let page: Page = wait(client.whole(state.map(State::name))).await?;
                if page.robots.is_empty() {
                    say("no robots; add one: umwelt robot add ID");
                }
                output.result(&page, list)
            }
            Self::Show { robot } => output.result(&wait(client.get_robot(&robot)).await?, show),
            Self::Check(check) => check.run(client, output).await,
            Self::Calibrate(calibrate) => calibrate.run(client, output).await,
            Self::Remove { robot } => {
                wait(client.delete_robot(&robot)).await?;
                let answer = json!({ "robot": robot, "removed": true });
                output.result(&answer, |_| format!("{robot} is removed"))
            }
        }
    }
}

/// Describes a robot; one that there is already only where it is to be `replace`d.
async fn add(client: &Client, add: &Add) -> Result<Robot, Failure> {
    let said = add.flags.description(add.file.as_deref())?;
    if add.replace {
        return Ok(wait(client.put_robot(&add.robot, &said)).await?);
    }
    match wait(client.if_absent().put_robot(&add.robot, &said)).await {
        Err(error) if error.status() == Some(Status::AlreadyExists) => {
            let robot = &add.robot;
            Err(Failure::Failed(format!(
                "{robot} is described already. Change parts of it: umwelt robot set {robot} ...; or describe it anew, with \
                 all that is not said default again: --replace"
            )))
        }
        answer => Ok(answer?),
    }
}

/// That it is `done`, and all that is known of it then.
fn described(robot: &Robot, done: &str) -> String {
    format!("{} is {done}\n{}", robot.robot, understood(robot).trim_end())
}

fn list(page: &Page) -> String {
    if page.robots.is_empty() {
        return with(String::new(), &page.unreadable);
    }
    let mut table = Table::new([
        Column::Text("ROBOT"),
        Column::Text("STATE"),
        Column::Number("SEEN"),
        Column::Text("TASK"),
        Column::Number("X"),
        Column::Number("Y"),
        Column::Number("HEADING"),
        Column::Number("LARGEST DEVIATION"),
        Column::Number("LOOP DELAY"),
    ]);
    for robot in &page.robots {
        let stopped = if robot.stopped { ", stopped" } else { "" };
        let held = if robot.held { ", held" } else { "" };
        let watch = robot.watch.as_ref();
        let watch = watch.map_or_else(String::new, |watch| format!(", {}", watch.state.name()));
        table.row([
            robot.robot.to_string(),
            format!("{}{stopped}{held}{watch}", quantity::state(robot.state)),
            or_unknown(robot.last_seen_s_ago, |s| format!("{} ago", quantity::span(s))),
            or_unknown(robot.task.as_ref(), quantity::short_progress),
            or_unknown(robot.pose, |pose| metres(pose.x_m)),
            or_unknown(robot.pose, |pose| metres(pose.y_m)),
            or_unknown(robot.pose, |pose| radians(pose.heading_rad)),
            or_unknown(robot.task, |task| millimetres(task.max_deviation_m)),
            or_unknown(robot.loop_delay_median_s, milliseconds),
        ]);
    }
    with(table.to_string(), &page.unreadable)
}

fn show(robot: &Robot) -> String {
    let mut text = format!("{}: {}\n", robot.robot, quantity::presence(robot));
    let lines = [
        (
            "pose",
            or_unknown(robot.pose.as_ref(), |pose| {
                let age = robot.pose_age_s;
                let age = age.map_or_else(String::new, |s| format!(", {} old", quantity::span(s)));
                format!("{}{age}", quantity::pose(pose))
            }),
        ),
        ("watch", robot.watch.as_ref().map_or_else(|| "all is well".to_owned(), quantity::watch)),
        ("task", or_unknown(robot.task.as_ref(), quantity::progress)),
        (
            "loop delay",
            or_unknown(robot.loop_delay_median_s, |s| format!("{} (median)", milliseconds(s))),
        ),
        (
            "max speed",
            or_unknown(robot.max_speed_m_per_s, |max| {
                format!("{max:.3} m/s, as the robot itself allows")
            }),
        ),
        ("epoch", or_unknown(robot.epoch, |epoch| epoch.to_string())),
        ("etag", robot.etag.clone()),
    ];
    // Writing to a String cannot fail.
    for (name, value) in lines {
        let _ = writeln!(text, "  {name:<10}  {value}");
    }
    text.push_str("described as\n");
    text.push_str(&understood(robot));
    text
}

#[cfg(test)]
mod tests;
