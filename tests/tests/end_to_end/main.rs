//! The programs over real sockets: what is refused, what is repeated, what is taken over, and what stays.
//!
//! Every test has a server of its own. What needs a robot's real time is in `real_time`.

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod agents;
mod bad_input;
mod command_line;
mod comparisons;
mod connections;
mod data;
mod events;
mod evolutions;
mod operators;
mod steps;
mod tokens;

use serde_json::Value;
use umwelt_api::RobotId;
use umwelt_api::robot::Description;
use umwelt_api::task;
use umwelt_client::Client;
use umwelt_tests::http;
use umwelt_tests::rover::id;
use umwelt_tests::server::Server;

/// A task that begins at once: to (`x_m`, 0), without calibration.
fn straight_to(x_m: f64) -> task::Spec {
    task::Spec {
        waypoints: vec![task::Waypoint { x_m, y_m: 0.0 }],
        tolerance_m: Some(0.01),
        reverse: false,
        calibration: None,
        max_deviation_m: None,
        check: None,
        square: None,
    }
}

/// Describes the robot `name`, all by default.
async fn describe(client: &Client, name: &str) -> RobotId {
    let robot = id(name);
    client.put_robot(&robot, &Description::default()).await.unwrap();
    robot
}

/// All that the server shows of a robot, but for the time that passes.
async fn shown(server: &Server, robot: &RobotId) -> Vec<Value> {
    let mut shown = Vec::new();
    for path in ["", "/task", "/environment"] {
        let path = format!("/v1/robots/{robot}{path}");
        let mut body = http::call(server.address, "GET", &path, &[], b"").await.json();
        if let Some(object) = body.as_object_mut() {
            object.remove("last_seen_s_ago");
            object.remove("pose_age_s");
        }
        shown.push(body);
    }
    shown
}
