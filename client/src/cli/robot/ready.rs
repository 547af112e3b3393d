//! Whether a robot is to be moved now.

use super::super::quantity;
use umwelt_api::robot::{Robot, State};
use umwelt_api::task::Stage;

/// Why the robot is not to be moved now, and what to do about it. A task under way is no reason where it is to be replaced.
pub(super) fn refusal(robot: &Robot, replace_task: bool) -> Option<String> {
    let id = &robot.robot;
    let presence = quantity::presence(robot);
    match robot.state {
        State::Never => {
            return Some(format!(
                "it was never seen; start its agent: umwelt-agent --robot {id} --drive pipe"
            ));
        }
        State::Lost => return Some(format!("it is {presence}; see the log of its agent")),
        State::Failed => return Some(format!("it is {presence}; see the log of the server")),
        State::Connected => {}
    }
    if robot.stopped {
        return Some(format!("it is stopped; umwelt resume {id} lets it go"));
    }
    if robot.held {
        return Some("it is held by itself; let it go where it says hold".to_owned());
    }
    let under_way = robot
        .task
        .as_ref()
        .filter(|task| !matches!(task.stage, Stage::Idle | Stage::Arrived) && !replace_task);
    under_way.map(|task| {
        let doing = quantity::short_progress(task);
        format!("it has a task under way ({doing}); --replace-task gives that up")
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use serde_json::json;

    /// A robot that may be moved, but for what is said.
    pub(in super::super) fn robot(more: serde_json::Value) -> Robot {
        let mut robot = json!({"robot": "a", "spec": {}, "state": "connected", "last_seen_s_ago": 0.1,
            "stopped": false, "pose": null, "task": null, "epoch": 4, "loop_delay_median_s": null, "etag": "x"});
        for (name, value) in more.as_object().unwrap() {
            robot[name] = value.clone();
        }
        serde_json::from_value(robot).unwrap()
    }

    fn refused(more: serde_json::Value, replace_task: bool) -> Option<String> {
        refusal(&robot(more), replace_task)
    }

    #[test]
    fn a_robot_that_is_not_to_move_is_refused_with_a_remedy() {
        assert_eq!(refused(json!({}), false), None);
        for (more, remedy) in [
            (json!({"state": "never"}), "start its agent"),
            (json!({"state": "lost"}), "log of its agent"),
            (json!({"state": "failed"}), "log of the server"),
            (json!({"stopped": true}), "umwelt resume a"),
            (json!({"held": true}), "let it go"),
        ] {
            let said = refused(more.clone(), true).unwrap_or_default();
            assert!(said.contains(remedy), "{more}: {said}");
        }
        let task = |stage: &str| {
            json!({"task": {"stage": stage, "leg": 0, "legs": 1, "deviation_m": 0.0,
                "max_deviation_m": 0.0, "elapsed_s": 0.0}})
        };
        assert!(refused(task("driving"), false).is_some_and(|it| it.contains("--replace-task")));
        assert_eq!(refused(task("driving"), true), None);
        assert_eq!(refused(task("arrived"), false), None);
    }
}
