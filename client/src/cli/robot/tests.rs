use super::*;
use clap::Parser;
use umwelt_api::robot::Pose;
use umwelt_api::task::{Progress, Stage};

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    add: Add,
}

fn spec(flags: &str) -> Result<Spec, Failure> {
    Line::parse_from(format!("add a {flags}").split_whitespace()).add.spec()
}

fn robot(id: &str, state: State) -> Robot {
    Robot {
        robot: id.parse().unwrap(),
        spec: Spec::default(),
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
    assert_eq!(spec("").unwrap(), Spec::default());
    let changed = spec("--method fixed-bad --slots 3 --lag 0.12 --max-speed 0.2 --drift").unwrap();
    let mut expected =
        Spec { method: Method::FixedBad, horizon_slots: 3, drift: true, ..Spec::default() };
    expected.drive.lag_s = 0.12;
    expected.drive.max_linear_m_per_s = 0.2;
    assert_eq!(changed, expected);
    assert_eq!(spec("--prior wet-hall").unwrap().prior.name(), Some("wet-hall"));
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
    assert!(text.contains("\n  drive.wheel_radius_m"), "{text}");
    assert!(text.contains("\n  predictor.kind"), "{text}");
}
