//! Giving a robot a task from the command line.

use super::super::progress::say;
use umwelt_api::RobotId;
use umwelt_api::problem::Status;
use umwelt_api::task::{Spec, Stage, Task};
use umwelt_client::{Client, Error};

/// Sets the task. The server leaves the very task that the robot has as it is; a caller that sets it again once the robot has
/// arrived, or says `again`, wants to see it driven once more.
pub(in crate::cli) async fn assign(
    client: &Client,
    robot: &RobotId,
    spec: &Spec,
    again: bool,
) -> Result<Task, Error> {
    let before = match client.get_task(robot).await {
        Ok(task) => Some(task.etag),
        Err(error) if error.status() == Some(Status::NotFound) => None,
        Err(error) => return Err(error),
    };
    let task = client.set_task(robot, spec).await?;
    if before.as_ref() != Some(&task.etag) {
        return Ok(task);
    }
    if !again && task.progress.stage != Stage::Arrived {
        say(&format!(
            "{robot} has this very task already and goes on with it; --again drives it from its beginning"
        ));
        return Ok(task);
    }
    // Only this one: another task that is set meanwhile is not cancelled.
    client.if_match(&task.etag).cancel_task(robot).await?;
    client.set_task(robot, spec).await
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_server::{Server, answer, json};
    use hyper::body::Incoming;
    use hyper::{Method, Request, StatusCode};
    use std::sync::{Arc, Mutex};
    use umwelt_api::ErrorBody;
    use umwelt_api::problem::Problem;

    fn task(stage: Stage) -> Task {
        let progress = serde_json::json!({"stage": stage, "leg": 0, "legs": 1, "deviation_m": 0.0,
            "max_deviation_m": 0.0, "elapsed_s": 0.0});
        let task = serde_json::json!({"robot": "a", "spec": {"waypoints": [{"x_m": 0.2, "y_m": 0.0}]},
            "progress": progress, "etag": "1"});
        serde_json::from_value(task).unwrap()
    }

    /// What is asked of a server whose robot has a task at `stage`, `same` as the one that is set or another.
    async fn asked(stage: Option<Stage>, same: bool, again: bool) -> Vec<String> {
        let asked = Arc::new(Mutex::new(Vec::new()));
        let log = Arc::clone(&asked);
        let server = Server::start(move |request: Request<Incoming>| {
            let if_match = request.headers().get("if-match").is_some();
            let method = request.method().clone();
            log.lock().unwrap().push(format!("{method}{}", if if_match { " if" } else { "" }));
            async move {
                let had = |stage| serde_json::to_string(&task(stage)).unwrap();
                match (method, stage) {
                    (Method::DELETE, _) => answer(StatusCode::NO_CONTENT, "text/plain", ""),
                    (Method::GET, None) => {
                        let problem = Problem::new(Status::NotFound, "robot a has no task");
                        let body = serde_json::to_string(&ErrorBody::from(problem)).unwrap();
                        json(StatusCode::NOT_FOUND, &body)
                    }
                    (Method::PUT, Some(stage)) if same => json(StatusCode::OK, &had(stage)),
                    (Method::PUT, _) => {
                        let new = had(Stage::Idle).replace("\"etag\":\"1\"", "\"etag\":\"2\"");
                        json(StatusCode::OK, &new)
                    }
                    (_, stage) => json(StatusCode::OK, &had(stage.unwrap())),
                }
            }
        })
        .await;
        let client = Client::new(&server.url).unwrap();
        let robot = "a".parse().unwrap();
        assign(&client, &robot, &task(Stage::Idle).spec, again).await.unwrap();
        asked.lock().unwrap().clone()
    }

    /// Guards against: "task set" after the arrival does nothing, or sends a robot that is under way back to its start.
    #[tokio::test]
    async fn a_task_that_is_done_is_driven_again_and_one_under_way_goes_on() {
        let set = ["GET", "PUT"].as_slice();
        let anew = ["GET", "PUT", "DELETE if", "PUT"].as_slice();
        for (stage, same, again, expected) in [
            (None, false, false, set),
            (None, false, true, set),
            (Some(Stage::Driving), false, false, set),
            (Some(Stage::Driving), false, true, set),
            (Some(Stage::Driving), true, false, set),
            (Some(Stage::Driving), true, true, anew),
            (Some(Stage::Arrived), true, false, anew),
            (Some(Stage::Arrived), false, false, set),
        ] {
            assert_eq!(asked(stage, same, again).await, expected, "{stage:?} {same} {again}");
        }
    }
}
