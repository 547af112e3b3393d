use super::description::{ATTRIBUTIONS, METHODS};
use super::*;
use clap::Parser;
use serde_json::Value;
use umwelt_api::robot::{Attribution, Description, Method, Pose, Spec};
use umwelt_api::task::{Progress, Stage};

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    add: Add,
}

fn said(flags: &str) -> Value {
    let line = Line::parse_from(format!("add a {flags}").split_whitespace());
    json!(line.add.flags.description(None).unwrap())
}

fn robot(id: &str, state: State) -> Robot {
    Robot {
        robot: id.parse().unwrap(),
        spec: Spec::default(),
        described: Description::read(br#"{"drive": {"lag_s": 0}}"#).unwrap().into_inner(),
        state,
        last_seen_s_ago: None,
        stopped: false,
        held: false,
        max_speed_m_per_s: None,
        pose: None,
        pose_age_s: None,
        watch: None,
        task: None,
        epoch: None,
        loop_delay_median_s: None,
        etag: "\"1\"".to_owned(),
    }
}

#[test]
fn flags_say_what_they_say_and_nothing_else() {
    assert_eq!(said(""), json!({}));
    let drive = json!({"lag_s": 0.12, "max_linear_m_per_s": 0.2});
    let expected =
        json!({"method": "fixed-bad", "horizon_slots": 3, "drift": true, "drive": drive});
    assert_eq!(said("--method fixed-bad --slots 3 --lag 0.12 --max-speed 0.2 --drift"), expected);
    let drive =
        json!({"kind": "skid-steer", "sideways_m_per_rad": -0.021, "turn_by_speed_s_per_m": 0.4});
    let flags = "--kind skid-steer --sideways -0.021 --turn-by-speed 0.4";
    assert_eq!(said(flags), json!({"drive": drive}));
    assert_eq!(said("--prior wet-hall"), json!({"prior": "wet-hall"}));
}

#[test]
fn a_change_says_only_what_is_changed() {
    let patch = |flags: &str, unset: &[&str]| {
        let line = Line::parse_from(format!("add a {flags}").split_whitespace());
        let unset: Vec<_> = unset.iter().map(|&it| it.to_owned()).collect();
        line.add.flags.patch(&unset).map(|patch| json!(patch))
    };
    let expected = json!({"drive": {"lag_s": 0.1, "dead_time_s": null}, "method": null});
    assert_eq!(patch("--lag 0.1", &["drive.dead_time_s", "method"]).unwrap(), expected);
    for (flags, unset, why) in [
        ("", [].as_slice(), "nothing to change"),
        ("", &["drive.lag"], "no such field"),
        ("--lag -1", &[], "drive.lag_s is -1.0: OUT_OF_RANGE"),
    ] {
        let Err(Failure::Wrong(text)) = patch(flags, unset) else { panic!("{flags} {unset:?}") };
        assert!(text.contains(why), "{text}");
    }
}

#[test]
fn names_of_choices_are_those_of_the_wire() {
    let read = |name: &&str| Value::String((*name).to_owned());
    assert!(METHODS.iter().map(read).all(|name| serde_json::from_value::<Method>(name).is_ok()));
    assert!(
        ATTRIBUTIONS
            .iter()
            .map(read)
            .all(|name| serde_json::from_value::<Attribution>(name).is_ok())
    );
    assert!(STATES.iter().map(read).all(|name| serde_json::from_value::<State>(name).is_ok()));
}

#[test]
fn a_lost_robot_stays_on_the_list_with_its_last_pose() {
    let pose = Pose { x_m: 0.2, y_m: -0.0412, heading_rad: -1.5712, taken_s: 12.0 };
    let progress = Progress {
        stage: Stage::Driving,
        leg: 1,
        legs: 2,
        deviation_m: 0.001,
        max_deviation_m: 0.0041,
        elapsed_s: 9.0,
        limited_by: None,
        watch: None,
    };
    let lost = Robot {
        last_seen_s_ago: Some(312.0),
        stopped: true,
        pose: Some(pose),
        task: Some(progress),
        loop_delay_median_s: Some(0.2124),
        ..robot("rover-7", State::Lost)
    };
    let page = Page { robots: vec![robot("a", State::Never), lost], ..Page::default() };
    assert_eq!(list(&page), "\
ROBOT    STATE               SEEN  TASK               X         Y     HEADING  LARGEST DEVIATION  LOOP DELAY
a        never seen             -  -                  -         -           -                  -           -
rover-7  lost, stopped  5 min ago  driving 2/2  0.200 m  -0.041 m  -1.571 rad             4.1 mm      212 ms
");
}

#[test]
fn a_robot_that_holds_shows() {
    let held = Robot { held: true, max_speed_m_per_s: Some(0.05), ..robot("a", State::Connected) };
    let text = show(&held);
    assert!(text.starts_with("a: connected, held by the robot itself\n"), "{text}");
    assert!(text.contains("\n  max speed   0.050 m/s, as the robot itself allows\n"), "{text}");
    let page = Page { robots: vec![held], ..Page::default() };
    assert!(list(&page).contains("connected, held"), "{}", list(&page));
}

#[test]
fn a_robot_is_shown_with_every_field_of_its_description() {
    let text = show(&robot("a", State::Never));
    assert!(text.starts_with("a: never seen\n  pose        -\n"), "{text}");
    for line in [
        "drive.wheel_radius_m 0.03 m default",
        "drive.lag_s 0 s set",
        "steering.alpha_m_per_s 0.2 m/s derived",
        "horizon_slots 40 derived",
        "predictor.kind moments default",
    ] {
        let is_there = |shown: &str| shown.split_whitespace().eq(line.split(' '));
        assert!(text.lines().any(is_there), "{line}: {text}");
    }
}
