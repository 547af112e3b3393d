//! `umwelt robot`.

mod check;

use super::failure::Failure;
use super::input;
use super::output::Output;
use super::progress::{say, wait};
use super::quantity::{self, metres, millimetres, milliseconds, or_unknown, radians};
use super::table::{Column, Table};
use super::unreadable::with;
use clap::{Args, Subcommand};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;
use umwelt_api::Validate;
use umwelt_api::robot::{Attribution, Method, Page, PriorChoice, Robot, Spec, State};
use umwelt_api::{PriorId, RobotId};
use umwelt_client::Client;

const METHODS: &[&str] = &["fixed-normal", "fixed-bad", "statistic", "bayesian"];
const ATTRIBUTIONS: &[&str] = &["sent", "played"];
const STATES: &[&str] = &["never", "connected", "lost", "failed"];

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Describe a robot, for the first time or anew
    #[command(after_help = ADD_EXAMPLES)]
    Add(Box<Add>),
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
    /// Remove a robot with its task and what was learned; if it still drives, it ramps to rest
    Remove {
        /// The robot
        #[arg(value_name = "ID")]
        robot: RobotId,
    },
}

const ADD_EXAMPLES: &str = "\
What is neither in the file nor in a flag is that of a robot of the 0.1 m class, also when the robot was described
otherwise before. `umwelt --json robot show ID | jq .spec` makes a file.

Examples:
  umwelt robot add rover-7
  umwelt robot add rover-7 --method statistic --slots 1
  umwelt robot add rover-7 --prior wet-hall
  umwelt robot add rover-7 --file spec.json --lag 0.12
  jq .rover spec.json | umwelt robot add rover-7 --file -";

#[derive(Debug, Args)]
pub(super) struct Add {
    /// The robot: 1 to 63 of a-z, 0-9 and -
    #[arg(value_name = "ID")]
    robot: RobotId,
    /// Description in JSON, - for standard input; flags win over it
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// How the environment is identified
    #[arg(long, value_parser = input::named::<Method>(METHODS))]
    method: Option<Method>,
    /// What errors are measured against: commands as sent or as played
    #[arg(long, value_parser = input::named::<Attribution>(ATTRIBUTIONS))]
    attribution: Option<Attribution>,
    /// Use the drift channel: heading error per metre
    #[arg(long)]
    drift: bool,
    /// Slots of 30 ms per reply; 1 is the thesis
    #[arg(long, value_name = "N")]
    slots: Option<usize>,
    /// Nominal time from a pose being taken to its reply being applied
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    loop_delay: Option<f64>,
    /// How long the robot goes on without replies before it ramps to rest; 0 is for ever, for simulations
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    watchdog: Option<f64>,
    /// Standard deviation of an observed position
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    position_noise: Option<f64>,
    /// Standard deviation of an observed heading
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    heading_noise: Option<f64>,
    /// What the robot believes of the floor before any sample: a name of `umwelt prior list`
    #[arg(long, value_name = "NAME")]
    prior: Option<PriorId>,
    /// Distance to a waypoint at which the robot stops
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    stop_radius: Option<f64>,
    // Last, because its heading holds for all flags below it.
    #[command(flatten)]
    drive: Drive,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Drive")]
struct Drive {
    /// Radius of both wheels
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    wheel_radius: Option<f64>,
    /// Distance between the wheels
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    track_width: Option<f64>,
    /// Largest speed of either wheel
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    max_wheel_speed: Option<f64>,
    /// Largest speed
    #[arg(long, value_name = "M/S", allow_negative_numbers = true)]
    max_speed: Option<f64>,
    /// Smallest speed at which the motors turn
    #[arg(long, value_name = "M/S", allow_negative_numbers = true)]
    min_speed: Option<f64>,
    /// Largest angular velocity
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    max_turn: Option<f64>,
    /// Smallest angular velocity of a turn in place
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    min_turn: Option<f64>,
    /// Largest change of speed
    #[arg(long, value_name = "M/S^2", allow_negative_numbers = true)]
    max_acceleration: Option<f64>,
    /// Largest change of angular velocity
    #[arg(long, value_name = "RAD/S^2", allow_negative_numbers = true)]
    max_turn_acceleration: Option<f64>,
    /// Time constant with which the wheels follow a command
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    lag: Option<f64>,
    /// Time before the wheels begin to follow a command
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    dead_time: Option<f64>,
}

impl Command {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        match self {
            Self::Add(add) => {
                let spec = add.spec()?;
                let robot = wait(client.put_robot(&add.robot, &spec)).await?;
                output.result(&robot, |robot| format!("{} is described", robot.robot))
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
            Self::Remove { robot } => {
                wait(client.delete_robot(&robot)).await?;
                let answer = json!({ "robot": robot, "removed": true });
                output.result(&answer, |_| format!("{robot} is removed"))
            }
        }
    }
}

impl Add {
    /// The file, with the flags on top.
    fn spec(&self) -> Result<Spec, Failure> {
        let mut spec = Spec::default();
        let mut source = "the description".to_owned();
        if let Some(path) = &self.file {
            source = input::name(path);
            let json = input::read(path)?;
            let read = Spec::read(&json);
            spec = read.map_err(|problems| Failure::wrong_body(&source, &problems))?.into_inner();
            source.push_str(" with these flags");
        }
        replace(&mut spec.method, self.method);
        replace(&mut spec.attribution, self.attribution);
        spec.drift |= self.drift;
        replace(&mut spec.horizon_slots, self.slots);
        replace(&mut spec.loop_delay_s, self.loop_delay);
        replace(&mut spec.watchdog_s, self.watchdog);
        replace(&mut spec.noise.position_m, self.position_noise);
        replace(&mut spec.noise.heading_rad, self.heading_noise);
        replace(&mut spec.prior, self.prior.as_ref().map(PriorChoice::from));
        replace(&mut spec.steering.stop_radius_m, self.stop_radius);
        let (drive, flags) = (&mut spec.drive, &self.drive);
        replace(&mut drive.wheel_radius_m, flags.wheel_radius);
        replace(&mut drive.track_width_m, flags.track_width);
        replace(&mut drive.max_wheel_speed_rad_per_s, flags.max_wheel_speed);
        replace(&mut drive.max_linear_m_per_s, flags.max_speed);
        replace(&mut drive.min_linear_m_per_s, flags.min_speed);
        replace(&mut drive.max_angular_rad_per_s, flags.max_turn);
        replace(&mut drive.min_angular_rad_per_s, flags.min_turn);
        replace(&mut drive.max_linear_acceleration_m_per_s2, flags.max_acceleration);
        replace(&mut drive.max_angular_acceleration_rad_per_s2, flags.max_turn_acceleration);
        replace(&mut drive.lag_s, flags.lag);
        replace(&mut drive.dead_time_s, flags.dead_time);
        spec.validate().map_err(|problems| Failure::wrong_body(&source, &problems))?;
        Ok(spec)
    }
}

fn replace<T>(field: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *field = value;
    }
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
    let mut fields = Vec::new();
    flatten("", &serde_json::to_value(&robot.spec).unwrap_or_default(), &mut fields);
    let width = fields.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    for (name, value) in fields {
        let _ = writeln!(text, "  {name:<width$}  {value}");
    }
    text
}

/// Each field with its path, named as in the file: the names carry the units.
fn flatten(path: &str, value: &Value, fields: &mut Vec<(String, String)>) {
    let Value::Object(object) = value else {
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        fields.push((path.to_owned(), text));
        return;
    };
    for (name, value) in object {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        flatten(&path, value, fields);
    }
}

#[cfg(test)]
mod tests;
