//! `umwelt robot calibrate`: the robot drives a square both ways, and what of wheels and track is not as described is said.

use super::super::failure::Failure;
use super::super::output::Output;
use super::super::progress::{say, wait};
use super::super::quantity::{self, metres};
use super::super::square_report;
use super::accept::accept;
use super::motion::Motion;
use super::ready::refusal;
use clap::Args;
use serde_json::json;
use std::time::Duration;
use umwelt_api::robot::Robot;
use umwelt_api::square::{Report, Square};
use umwelt_api::task::Spec;
use umwelt_api::watch;
use umwelt_api::{RobotId, Validate};
use umwelt_client::Client;

const MOTION: Motion<Report> = Motion {
    name: "square",
    again: "calibrate",
    look: Duration::from_secs(1),
    longest: 8.0,
    report: |task| task.square,
    how_far,
};

/// Part of the side by which a robot may be beside its square: with wheels and track described as they are it is less.
const BESIDE: f64 = 0.3;

#[derive(Debug, Args)]
pub(in crate::cli) struct Calibrate {
    /// The robot
    #[arg(value_name = "ID")]
    robot: RobotId,
    /// Side of the square; ten track widths without, at least 0.5 m and at most 4 m
    #[arg(long, value_name = "M")]
    side: Option<f64>,
    /// Runs each way, 1 to 5
    #[arg(long, value_name = "N", default_value_t = Square::default().runs)]
    runs: u32,
    /// Part of the largest speed, 0.1 to 1
    #[arg(long, value_name = "SHARE", default_value_t = Square::default().speed_share)]
    speed: f64,
    /// Calibrate it although it has a task under way, which is given up
    #[arg(long)]
    replace_task: bool,
    /// Drive nothing: describe the robot with the wheel radius and the track with which it moves as it does, as identified so
    /// far (`umwelt environment show`)
    #[arg(long, conflicts_with_all = ["side", "runs", "speed", "replace_task"])]
    accept: bool,
}

pub(super) const HELP: &str = "\
The robot drives a square to the left and the same square to the right (UMBmark), open loop. Before it starts, the room that
it needs is said. Where it is seen to end says how track width, wheels and their ratio differ from the description; nothing is
changed. With --accept nothing is driven: the robot is described by what is identified of it. Ctrl-C brings the robot to rest.

The exit status is 0 where there is a figure and 1 where there is none; --json prints the report. docs/calibrate.md says how it
is found. Run `umwelt robot check ID` first.

Examples:
  umwelt robot calibrate rover-7
  umwelt robot calibrate rover-7 --accept
  umwelt robot calibrate rover-7 --side 2 --runs 3 --speed 0.4
  umwelt --json robot calibrate rover-7 | jq .systematic.track_width_m";

impl Calibrate {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        let id = &self.robot;
        if self.accept {
            return accept(client, output, id).await;
        }
        let robot = wait(client.get_robot(id)).await?;
        if let Some(reason) = refusal(&robot, self.replace_task) {
            return Err(Failure::Failed(format!("{id} is not calibrated: {reason}")));
        }
        let square = Square { side_m: self.side, runs: self.runs, speed_share: self.speed };
        let spec = spec(square)?;
        say(&announcement(&robot, &square));
        let duration = square.duration_s(&robot.spec.drive);
        let report = MOTION.drive(client, id, &spec, duration).await?;
        output.result(&report, |report| square_report::text(id, report))?;
        match report.systematic {
            Some(_) => Ok(()),
            None => Err(Failure::Failed(format!("{id} is not calibrated"))),
        }
    }
}

/// The task that is this square, as the contract fills it in.
fn spec(square: Square) -> Result<Spec, Failure> {
    let spec = json!({ "waypoints": [], "square": square });
    let spec: Spec = serde_json::from_value(spec)
        .map_err(|error| Failure::Failed(format!("no square: {error}")))?;
    // Before the room is said, which would be that of no square.
    spec.validate().map_err(|problems| Failure::wrong_body("what is asked for", &problems))?;
    Ok(spec)
}

/// What the robot is about to do, and how much room it needs.
fn announcement(robot: &Robot, square: &Square) -> String {
    let Robot { robot: id, spec, .. } = robot;
    let side = square.side_of_m(&spec.drive);
    let room = (1.0 + BESIDE) * side + spec.drive.track_width_m;
    let beside = BESIDE * side + spec.drive.track_width_m;
    let times = if square.runs == 1 { "once" } else { &format!("{} times", square.runs) };
    let minutes = (square.duration_s(&spec.drive) / 60.0).ceil();
    // What rounding of sums has added is no decimetre.
    let up = |room: f64| (10.0 * room - 1e-6).ceil() / 10.0;
    format!(
        "{id} drives a square of {} to its left and to its right, {times} each, for some {minutes:.0} min in all.\nKeep {:.1} m \
         ahead of it and to either side, and {:.1} m behind it, free and in sight of the tracker. Ctrl-C brings it to rest.",
        metres(side),
        up(room),
        up(beside),
    )
}

/// Which run it is at; or why the robot rests until it is resumed.
fn how_far(robot: &Robot) -> Result<String, String> {
    at_rest(robot).map_or(Ok(()), Err)?;
    Ok(robot.task.as_ref().map_or_else(String::new, |progress| {
        let run = (progress.leg + 1).min(progress.legs);
        format!(", run {run} of {}", progress.legs)
    }))
}

/// Why the robot rests until it is resumed; it goes on by itself where poses are missing.
fn at_rest(robot: &Robot) -> Option<String> {
    let watch = robot.watch.as_ref()?;
    (watch.rests && watch.state != watch::State::NoPoses).then(|| quantity::watch(watch))
}

#[cfg(test)]
mod tests {
    use super::super::ready::tests::robot;
    use super::*;

    #[test]
    fn the_room_is_said_before_the_robot_moves() {
        let said = announcement(&robot(json!({})), &Square::default());
        assert!(
            said.contains("a square of 1.000 m to its left and to its right, once each"),
            "{said}"
        );
        assert!(said.contains("for some 3 min in all"), "{said}");
        assert!(
            said.contains("Keep 1.4 m ahead of it and to either side, and 0.4 m behind"),
            "{said}"
        );
        let square = Square { side_m: Some(0.5), runs: 3, ..Square::default() };
        assert!(announcement(&robot(json!({})), &square).contains("3 times each"));
    }

    #[test]
    fn a_robot_that_the_watch_brought_to_rest_ends_it_with_the_remedy() {
        let watch = |state: &str| {
            json!({"watch": {"state": state, "rests": true, "seen": "commanded 1 m", "remedy": "free the robot",
                "since_s_ago": 1.0}})
        };
        assert!(at_rest(&robot(watch("stuck"))).is_some_and(|it| it.contains("free the robot")));
        assert_eq!(at_rest(&robot(watch("no-poses"))), None);
        assert_eq!(at_rest(&robot(json!({}))), None);
    }

    #[test]
    fn what_is_asked_for_is_what_the_task_is() {
        let square = Square { side_m: Some(0.7), runs: 2, speed_share: 0.5 };
        let spec = spec(square).unwrap();
        assert_eq!((spec.square, spec.waypoints.len()), (Some(square), 0));
        let wrong = super::spec(Square { runs: 9, ..square });
        assert!(matches!(wrong, Err(Failure::Wrong(text)) if text.contains("square.runs")));
    }
}
