use super::*;
use clap::Parser;
use umwelt_api::task::Progress;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    set: Set,
}

fn spec(flags: &str) -> Result<Spec, Failure> {
    Line::parse_from(format!("set a {flags}").split_whitespace()).set.spec()
}

fn task(stage: Stage, leg: usize) -> Task {
    let progress = Progress {
        stage,
        leg,
        legs: 2,
        deviation_m: 0.001,
        max_deviation_m: 0.0041,
        elapsed_s: 12.0,
        limited_by: None,
        watch: None,
    };
    let spec = spec("--waypoint 0.2,0 --waypoint 0,-0.1 --calibrate --tolerance 0.01").unwrap();
    Task {
        robot: "a".parse().unwrap(),
        spec,
        progress,
        etag: "\"1\"".to_owned(),
        check: None,
        square: None,
    }
}

#[test]
fn coordinates_may_be_negative_and_flags_may_follow() {
    let spec = spec("--waypoint -0.2,-0.1 --waypoint 0,1 --reverse --tolerance 0.02").unwrap();
    let waypoints = [(-0.2, -0.1), (0.0, 1.0)].map(|(x_m, y_m)| Waypoint { x_m, y_m });
    assert_eq!(spec.waypoints, waypoints);
    assert_eq!((spec.reverse, spec.tolerance_m), (true, Some(0.02)));
}

#[test]
fn the_robot_calibrates_where_it_is_told_to() {
    let calibration = |flags: &str| spec(&format!("--waypoint 1,0 {flags}")).unwrap().calibration;
    assert_eq!(calibration(""), None);
    assert_eq!(calibration("--calibrate"), Some(Calibration::default()));
    assert_eq!(calibration("--no-calibration"), None);
    let straight = Calibration { straight_m: 0.1, rotations: 4, ..Calibration::default() };
    assert_eq!(calibration("--calibration-straight 0.1 --calibration-rotations 4"), Some(straight));
}

#[test]
fn flags_win_over_the_calibration_of_a_file_and_nothing_adds_one() {
    let flags = |line: &str| {
        Line::parse_from(format!("set a --waypoint 1,0 {line}").split_whitespace()).set.calibration
    };
    let of_file = Calibration { rotations: 2, ..Calibration::default() };
    assert_eq!(flags("").on_top_of(None), None);
    assert_eq!(flags("").on_top_of(Some(of_file)), Some(of_file));
    let turned = Calibration { angular_rad_per_s: 1.5, ..of_file };
    assert_eq!(flags("--calibration-turn 1.5").on_top_of(Some(of_file)), Some(turned));
    assert_eq!(flags("--no-calibration").on_top_of(Some(of_file)), None);
}

#[test]
fn a_task_is_shown_waypoint_by_waypoint() {
    assert_eq!(
        show(&task(Stage::Driving, 1)),
        "\
a: driving to waypoint 2 of 2, 12.0 s, deviation 1.0 mm (largest 4.1 mm)
2 waypoints, after a calibration of 10 turns and 0.300 m straight, within 10.0 mm

WAYPOINT        X         Y
       1  0.200 m   0.000 m  reached
       2  0.000 m  -0.100 m  driving
"
    );
    assert_eq!(show(&task(Stage::Arrived, 2)).matches("reached").count(), 2);
    assert_eq!(show(&task(Stage::Calibrating, 0)).matches("calibrating").count(), 1);
}
