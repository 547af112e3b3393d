//! `umwelt robot check`: the robot wiggles, and what is wrong with it or its tracker is said.

use super::super::check_report;
use super::super::failure::Failure;
use super::super::output::Output;
use super::super::progress::{say, wait};
use super::super::quantity::metres;
use super::motion::Motion;
use super::ready::refusal;
use clap::Args;
use serde_json::json;
use std::time::Duration;
use umwelt_api::RobotId;
use umwelt_api::robot::Robot;
use umwelt_api::robot_check::{Report, Wiggle};
use umwelt_api::task::Spec;
use umwelt_client::Client;

const MOTION: Motion<Report> = Motion {
    name: "check",
    again: "check",
    look: Duration::from_millis(500),
    longest: 4.0,
    report: |task| task.check,
    how_far: |_| Ok(String::new()),
};

/// Times the length of a drive that is to be free around the robot, beside the robot itself.
const ROOM: f64 = 2.0;

#[derive(Debug, Args)]
pub(in crate::cli) struct Check {
    /// The robot
    #[arg(value_name = "ID")]
    robot: RobotId,
    /// Check it although it has a task under way, which is given up
    #[arg(long)]
    replace_task: bool,
}

pub(super) const HELP: &str = "\
The robot turns left and right and drives a short way forward and back, for some 20 s. Before it starts, the room that it
needs is said. Nothing is learned of the floor. Ctrl-C brings the robot to rest.

The exit status is 0 where all is well and 1 where something is wrong; --json prints the report. docs/check.md lists what
may be found.

Examples:
  umwelt robot check rover-7
  umwelt --json robot check rover-7 | jq '.findings[].name'";

impl Check {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        let id = &self.robot;
        let robot = wait(client.get_robot(id)).await?;
        if let Some(reason) = refusal(&robot, self.replace_task) {
            return Err(Failure::Failed(format!("{id} is not checked: {reason}")));
        }
        let wiggle = Wiggle::default();
        say(&announcement(&robot, &wiggle));
        let duration = wiggle.duration_s(&robot.spec.drive);
        let report = MOTION.drive(client, id, &spec(wiggle)?, duration).await?;
        output.result(&report, |report| check_report::text(id, report))?;
        match report.findings.len() {
            0 => Ok(()),
            1 => Err(Failure::Failed(format!("one thing is wrong with {id} or its tracker"))),
            count => {
                Err(Failure::Failed(format!("{count} things are wrong with {id} or its tracker")))
            }
        }
    }
}

/// The task that is this check, as the contract fills it in.
fn spec(wiggle: Wiggle) -> Result<Spec, Failure> {
    let spec = json!({ "waypoints": [], "check": wiggle });
    serde_json::from_value(spec).map_err(|error| Failure::Failed(format!("no check: {error}")))
}

/// What the robot is about to do, and how much room it needs.
fn announcement(robot: &Robot, wiggle: &Wiggle) -> String {
    let Robot { robot: id, spec, .. } = robot;
    let drive = &spec.drive;
    let (length, turn) = (wiggle.length_m(drive), wiggle.turn_rad(drive));
    let room = ROOM * length + drive.track_width_m;
    format!(
        "{id} rests for {:.0} s, then turns left and right by {turn:.2} rad and drives {} forward and back, for {:.0} s in \
         all.\nKeep {:.1} m around it free and in sight of the tracker. Ctrl-C brings it to rest.",
        wiggle.rest_s,
        metres(length),
        wiggle.duration_s(drive),
        (10.0 * room).ceil() / 10.0,
    )
}

#[cfg(test)]
mod tests {
    use super::super::ready::tests::robot;
    use super::*;

    #[test]
    fn the_room_is_said_before_the_robot_moves() {
        let said = announcement(&robot(json!({})), &Wiggle::default());
        assert!(said.contains("drives 0.109 m forward and back, for 20 s in all"), "{said}");
        assert!(said.contains("Keep 0.4 m around it free and in sight"), "{said}");
    }
}
