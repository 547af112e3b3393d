//! Laws: core -> wire -> JSON -> wire -> core loses nothing, and nothing wrong gets through.

mod belief;
mod job;
mod strategies;

use crate::checked::Checked;
use crate::problem::reason;
use crate::{prior, robot, step, task};
use proptest::prelude::*;
use proptest::sample::select;
use serde_json::{Value, json};
use strategies::{MAX, horizon, request, settings, task};
use umwelt_core::actuation::Playing;
use umwelt_core::exchange::{Delivery, Observation, Request};
use umwelt_core::geometry::{Point, Pose, WheelSpeeds};
use umwelt_core::horizon::{Horizon, SLOT};
use umwelt_core::kinematics;
use umwelt_core::local::LocalLimits;
use umwelt_core::settings::{Attribution, FollowsLink, Method, PoseNoise, Settings};
use umwelt_core::task as core_task;
use umwelt_core::time::RobotTime;
use umwelt_core::watch::Condition;

proptest! {
    #[test]
    fn a_robot_survives_the_wire(core in settings()) {
        let json = serde_json::to_vec(&robot::Spec::from(&core)).unwrap();
        prop_assert_eq!(robot::Description::read_known(&json, prior::built_in).map(|(_, it)| it), Ok(core));
    }

    #[test]
    fn a_task_survives_the_wire(core in task()) {
        let json = serde_json::to_vec(&task::Spec::from(&core)).unwrap();
        prop_assert_eq!(task::Spec::read(&json).map(|spec| spec.to_core(9.0)), Ok(core));
    }

    #[test]
    fn a_request_survives_the_wire(core in request(), epoch in 0..=MAX) {
        let json = serde_json::to_vec(&step::Request::from_core(&core, epoch)).unwrap();
        let wire = step::Request::read(&json).unwrap();
        prop_assert_eq!(wire.epoch, epoch);
        prop_assert_eq!(wire.to_core(), core);
    }

    #[test]
    fn a_horizon_survives_the_wire(core in horizon()) {
        let wire = step::Horizon::from(&core);
        prop_assert_eq!(wire.valid_until_s.unwrap_or(f64::INFINITY), core.valid_until().seconds());
        let json = serde_json::to_vec(&wire).unwrap();
        let wire: step::Horizon = serde_json::from_slice(&json).unwrap();
        prop_assert_eq!(wire.to_core(), Ok(core));
    }

    #[test]
    fn progress_survives_the_wire(leg in 0..9usize, deviation in 0.0..9.0f64, elapsed in 0.0..1e6f64) {
        for stage in [core_task::Stage::Idle, core_task::Stage::Calibrating, core_task::Stage::Turning,
                      core_task::Stage::Driving, core_task::Stage::Stopping, core_task::Stage::Arrived] {
            let core = core_task::Progress { stage, leg, legs: 9, deviation, max_deviation: 2.0 * deviation, elapsed,
                                                  limited_by: Some(core_task::Limit::Hold), watch: Some(Condition::OffPath) };
            let json = serde_json::to_string(&task::Progress::from(core)).unwrap();
            let wire: task::Progress = serde_json::from_str(&json).unwrap();
            prop_assert_eq!(core_task::Progress::from(wire), core);
        }
    }

    /// Whatever one number of a request is replaced by, reading neither panics nor lets it through unchecked.
    #[test]
    fn no_number_gets_through_unchecked(core in request(), which in any::<prop::sample::Index>(),
                                        bad in select(vec![json!(1e308), json!(-1e308), json!(-1), json!(u64::MAX), json!("1"), Value::Null, json!([])])) {
        let mut body = serde_json::to_value(step::Request::from_core(&core, 1)).unwrap();
        let mut paths = Vec::new();
        numbers(&body, String::new(), &mut paths);
        let path = &paths[which.index(paths.len())];
        *body.pointer_mut(path).unwrap() = bad;
        if let Ok(wire) = step::Request::read(body.to_string().as_bytes()) {
            let core = wire.to_core();
            prop_assert!(core.sequence <= MAX && core.sent.seconds().abs() <= 1e9);
            prop_assert!(core.observations.iter().all(|o| o.pose.x.abs() <= 1e4 && o.taken <= core.sent));
            prop_assert!(core.deliveries.iter().all(|d| (0.0..=86_400.0).contains(&d.loop_delay)));
        }
    }
}

fn numbers(value: &Value, path: String, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(path),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .for_each(|(i, item)| numbers(item, format!("{path}/{i}"), found)),
        Value::Object(fields) => {
            fields.iter().for_each(|(name, value)| numbers(value, format!("{path}/{name}"), found))
        }
        _ => {}
    }
}

/// `(reason, field)` of each problem.
fn problems<T: std::fmt::Debug>(read: Result<T, crate::Problems>) -> Vec<(String, String)> {
    let problems = read.expect_err("it is wrong");
    problems.details().iter().map(|detail| (detail.reason.clone(), detail.field.clone())).collect()
}

fn pairs(expected: &[(&str, &str)]) -> Vec<(String, String)> {
    expected.iter().map(|(reason, field)| ((*reason).to_owned(), (*field).to_owned())).collect()
}

#[test]
fn the_defaults_are_cores_and_pass() {
    let (said, settings) = robot::Description::read_known(b"{}", prior::built_in).unwrap();
    let thesis = Settings { drive: kinematics::Drive::default(), ..settings };
    assert_eq!((said, robot::Spec::from_core(&thesis, Some("default"))), Default::default());
    let follows_link = FollowsLink { loop_delay: true, slots: true, watchdog: true };
    let expected = Settings {
        slots: 40,
        noise: PoseNoise::CAMERA,
        follows_link,
        identifies_lag: true,
        identifies_dead_band: true,
        identifies_noise: true,
        method: Method::Adaptive,
        attribution: Attribution::Played,
        ..Settings::default()
    };
    assert_eq!(thesis, expected);
    let kinematics::Drive { lag, dead_time, .. } = settings.drive;
    assert_eq!((lag, dead_time), (0.11, 0.02), "until they are identified");
    let thesis = core_task::Task::thesis();
    assert_eq!(Checked::new(task::Spec::from(&thesis)).unwrap().to_core(9.0), thesis);
}

#[test]
fn all_problems_are_told_at_once_with_their_paths() {
    let body = json!({"waypoints": [{"x_m": 0, "y_m": 0}, {"x_m": 1e308, "y_m": -1e5, "z_m": 1}],
                      "tolerance_m": 0, "speed": 3, "calibration": {"rotations": 5000, "rotate_s": 1e300}});
    let expected = pairs(&[
        (reason::UNKNOWN_FIELD, "speed"),
        (reason::UNKNOWN_FIELD, "waypoints[1].z_m"),
        (reason::OUT_OF_RANGE, "waypoints[1].x_m"),
        (reason::OUT_OF_RANGE, "waypoints[1].y_m"),
        (reason::OUT_OF_RANGE, "tolerance_m"),
        (reason::OUT_OF_RANGE, "calibration.rotations"),
        (reason::OUT_OF_RANGE, "calibration.rotate_s"),
    ]);
    let mut found = problems(task::Spec::read(body.to_string().as_bytes()));
    found[..2].sort();
    assert_eq!(found, expected);
}

#[test]
fn fields_that_contradict_each_other_are_refused() {
    let body = json!({"drive": {"min_linear_m_per_s": 0.2, "lag_s": 9}, "watchdog_s": 0.01, "steering": {"turn_beyond_rad": 0.05},
                      "predictor": {"kind": "moments", "agents": 5}});
    let expected = pairs(&[
        (reason::UNKNOWN_FIELD, "predictor.agents"),
        (reason::OUT_OF_RANGE, "drive.lag_s"),
        (reason::INCONSISTENT, "watchdog_s"),
        (reason::INCONSISTENT, "drive.min_linear_m_per_s"),
        (reason::INCONSISTENT, "steering.turn_beyond_rad"),
    ]);
    assert_eq!(
        problems(robot::Description::read_known(body.to_string().as_bytes(), prior::built_in)),
        expected
    );
}

#[test]
fn a_check_is_a_task_of_its_own() {
    let said = |body: &str| problems(task::Spec::read(body.as_bytes()));
    let alone = task::Spec::read(br#"{"waypoints": [], "check": {}}"#).unwrap().to_core(0.01);
    assert_eq!(alone, core_task::Task::checking(core_task::Check::default()));
    let beside = r#"{"waypoints": [{"x_m": 0, "y_m": 0}], "check": {"rest_s": 0.1}}"#;
    let expected =
        pairs(&[(reason::OUT_OF_RANGE, "check.rest_s"), (reason::INCONSISTENT, "check")]);
    assert_eq!(said(beside), expected);
    let calibrated = r#"{"waypoints": [], "calibration": {}, "check": {}}"#;
    assert_eq!(said(calibrated), pairs(&[(reason::INCONSISTENT, "check")]));
    // A server of before takes a task without a check: it refuses fields that it does not know.
    let way = serde_json::to_value(task::Spec::from(&core_task::Task::thesis())).unwrap();
    assert_eq!(way.get("check"), None);
}

#[test]
fn a_square_is_a_task_of_its_own() {
    let said = |body: &str| problems(task::Spec::read(body.as_bytes()));
    let alone = task::Spec::read(br#"{"waypoints": [], "square": {}}"#).unwrap().to_core(0.01);
    assert_eq!(alone, core_task::Task::squaring(core_task::Square::default()));
    let odd = r#"{"waypoints": [], "square": {"side_m": 20, "runs": 0, "speed_share": 2}}"#;
    let fields = ["square.side_m", "square.runs", "square.speed_share"];
    assert_eq!(said(odd), pairs(&fields.map(|field| (reason::OUT_OF_RANGE, field))));
    for beside in [
        r#"{"waypoints": [{"x_m": 0, "y_m": 0}], "square": {}}"#,
        r#"{"waypoints": [], "calibration": {}, "square": {}}"#,
        r#"{"waypoints": [], "check": {}, "square": {}}"#,
    ] {
        assert_eq!(said(beside), pairs(&[(reason::INCONSISTENT, "square")]), "{beside}");
    }
    // A server of before takes a task without a square.
    let way = serde_json::to_value(task::Spec::from(&core_task::Task::thesis())).unwrap();
    assert_eq!(way.get("square"), None);
}

#[test]
fn times_out_of_order_are_refused() {
    let at = |taken: f64| json!({"x_m": 0, "y_m": 0, "heading_rad": 0, "taken_s": taken});
    let body = json!({"sequence": 5, "epoch": 1, "sent_s": 10.0, "observations": [at(1.0), at(1.0), at(11.0)],
                      "deliveries": [{"sequence": 5, "loop_delay_s": 0.2}], "playing": {"horizon": 1, "since_s": 10.5}});
    let expected = pairs(&[
        (reason::INCONSISTENT, "observations[2].taken_s"),
        (reason::INCONSISTENT, "observations[1].taken_s"),
        (reason::INCONSISTENT, "deliveries[0].sequence"),
        (reason::INCONSISTENT, "playing.since_s"),
    ]);
    assert_eq!(problems(step::Request::read(body.to_string().as_bytes())), expected);
}

/// The documented sizes, and that no allowed body is refused for its size.
#[test]
fn the_largest_bodies_fit() {
    let x = -9_876.543_210_987_654;
    let waypoints = vec![Point::new(x, x); core_task::MAX_WAYPOINTS];
    let task = core_task::Task { waypoints, ..core_task::Task::thesis() };
    let size = serde_json::to_vec(&task::Spec::from(&task)).unwrap().len();
    assert!(2 * size < task::MAX_BODY, "{size}");
    let sent = RobotTime::new(987_654_321.012_345_6);
    let observation = Observation { pose: Pose { x, y: x, ..Pose::new(x, x, x) }, taken: sent };
    let request = Request {
        sequence: MAX,
        connection: 0,
        sent,
        observations: [observation; 32].into(),
        deliveries: [Delivery { sequence: MAX, loop_delay: 86_399.012_345_678 }; 16].into(),
        playing: Some(Playing { horizon: MAX, since: sent }),
        limits: LocalLimits { hold: true, max_speed: Some(0.123_456_789_012_345_6) },
    };
    let size = serde_json::to_vec(&step::Request::from_core(&request, MAX)).unwrap().len();
    assert!(8 * size < step::MAX_BODY, "{size}");
}

/// A server of before takes the request of a robot that allows everything: it refuses fields that it does not know.
#[test]
fn a_robot_that_allows_everything_says_nothing_of_it() {
    let request = Request { sequence: 1, sent: RobotTime::new(1.0), ..Request::EMPTY };
    let said = serde_json::to_value(step::Request::from_core(&request, 1)).unwrap();
    assert_eq!((said.get("hold"), said.get("max_speed_m_per_s")), (None, None));
    let held =
        json!({"sequence": 1, "epoch": 1, "sent_s": 1.0, "hold": true, "max_speed_m_per_s": null});
    let held = step::Request::read(held.to_string().as_bytes()).unwrap().to_core();
    assert_eq!(held.limits, LocalLimits { hold: true, max_speed: None });
    let wrong = json!({"sequence": 1, "epoch": 1, "sent_s": 1.0, "max_speed_m_per_s": -0.1});
    let found = problems(step::Request::read(wrong.to_string().as_bytes()));
    assert_eq!(found, pairs(&[(reason::OUT_OF_RANGE, "max_speed_m_per_s")]));
}

#[test]
fn lists_are_limited() {
    let body = json!({"sequence": 5, "epoch": 1, "sent_s": 10.0,
                      "observations": vec![json!({"x_m": 0, "y_m": 0, "heading_rad": 0, "taken_s": 1}); 33],
                      "deliveries": vec![json!({"sequence": 1, "loop_delay_s": 0.2}); 17]});
    let found = problems(step::Request::read(body.to_string().as_bytes()));
    assert!(found.contains(&(reason::WRONG_LENGTH.to_owned(), "observations".to_owned())));
    assert!(found.contains(&(reason::WRONG_LENGTH.to_owned(), "deliveries".to_owned())));
    let none = problems(task::Spec::read(br#"{"waypoints": []}"#));
    assert_eq!(none, pairs(&[(reason::INCONSISTENT, "waypoints")]));
}

#[test]
fn what_is_not_the_type_is_told_with_its_path_and_value() {
    let error = task::Spec::read(br#"{"waypoints": [{"x_m": "far", "y_m": 0}]}"#).unwrap_err();
    let detail = &error.details()[0];
    assert_eq!(
        (detail.reason.as_str(), detail.field.as_str()),
        (reason::MALFORMED, "waypoints[0].x_m")
    );
    assert_eq!(detail.value, "far");
    for text in ["", "{", "[]", "{} {}", "null", "{\"sent_s\": NaN}", "{\"sequence\": 1e400}"] {
        assert_eq!(problems(task::Spec::read(text.as_bytes()))[0].0, reason::MALFORMED, "{text}");
        assert_eq!(
            problems(step::Request::read(text.as_bytes()))[0].0,
            reason::MALFORMED,
            "{text}"
        );
    }
    let unknown =
        problems(step::Request::read(br#"{"sequence": 1, "epoch": 1, "sent_s": 0, "sent": 0}"#));
    assert_eq!(unknown, pairs(&[(reason::UNKNOWN_FIELD, "sent")]));
}

#[test]
fn a_number_that_does_not_exist_cannot_be_sent() {
    let mut horizon = Horizon {
        sequence: 1,
        answers: 1,
        start: RobotTime::ZERO,
        slot: SLOT,
        watchdog: 0.3,
        speeds: Default::default(),
    };
    horizon.speeds.push(WheelSpeeds { left: f64::NAN, right: 0.0 });
    assert!(serde_json::to_string(&step::Horizon::from(&horizon)).is_err());
    let pose =
        Observation { pose: Pose { x: f64::INFINITY, ..Pose::default() }, taken: RobotTime::ZERO };
    assert!(serde_json::to_string(&step::Observation::from(pose)).is_err());
    assert!(serde_json::to_string(&robot::Pose::from(pose)).is_err());
}

#[test]
fn a_reader_of_responses_ignores_what_it_does_not_know() {
    let robot = json!({
        "robot": "a", "spec": {"drive": {"encoder_ticks": 5}, "colour": "red"}, "state": "lost", "last_seen_s_ago": 2.5,
        "stopped": false, "pose": null, "task": null, "epoch": 4, "loop_delay_median_s": null, "etag": "x", "mood": "good",
    });
    assert_eq!(serde_json::from_value::<robot::Robot>(robot).unwrap().spec, robot::Spec::default());
}
