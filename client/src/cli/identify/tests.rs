//! Files of made-up robots: read, refused, identified.

use super::super::Cli;
use super::super::Command;
use super::*;
use clap::Parser;
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use umwelt_core::geometry::WheelSpeeds;
use umwelt_core::kinematics::{Drive, inverse};
use umwelt_core::plant::{Plant, PlantModel, Slip};

const POSES: &str = "t_s,x_m,y_m,heading_rad\n";
const TWISTS: &str = "t_s,linear,angular\n";

/// A robot with a lag of 0.1 s and a dead time of 0.04 s that turns there and back: poses, and commands as twists and as
/// wheel speeds.
fn recorded() -> [String; 3] {
    let drive = Drive { lag: 0.1, dead_time: 0.04, ..Drive::default() };
    let model =
        PlantModel { drive, slip: Slip::HARD, noise: PoseNoise::CAMERA, ..PlantModel::default() };
    let mut plant = Plant::new(model, umwelt_core::geometry::Pose::default(), 1).unwrap();
    let [mut poses, mut twists] = [POSES, TWISTS].map(str::to_owned);
    let mut wheels = "t_s,left_rad_per_s,right_rad_per_s,note\n".to_owned();
    for step in 0..900_u32 {
        let time = f64::from(step) * 0.03;
        let angular: f64 = [0.0, 0.8, 0.0, -0.8][step as usize / 40 % 4];
        let twist = Twist::new(0.02 * angular.max(0.0), angular);
        let seen = plant.observe();
        let heading = seen.heading.radians();
        writeln!(poses, "{time:.3},{:.5},{:.5},{heading:.5}", seen.x, seen.y).unwrap();
        writeln!(twists, "{time:.3},{},{angular}", twist.linear).unwrap();
        let WheelSpeeds { left, right } = inverse(&drive, twist);
        writeln!(wheels, "{time:.3},{left:.6},{right:.6},").unwrap();
        plant.advance(inverse(&drive, twist), 0.03);
    }
    [poses, twists, wheels]
}

/// What `umwelt identify` says of these files, with these flags.
fn run(files: &[&str], flags: &str, json: bool) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let mut line = vec!["umwelt".to_owned(), "identify".to_owned()];
    for (index, text) in files.iter().enumerate() {
        let path = folder.path().join(format!("{index}.csv"));
        fs::write(&path, text).unwrap();
        line.push(path.display().to_string());
    }
    line.extend(flags.split_whitespace().map(str::to_owned));
    let cli = Cli::try_parse_from(line).map_err(|error| error.to_string())?;
    let Command::Identify(identify) = cli.command else { panic!("another command") };
    let (mut output, written) = Output::kept(json);
    match identify.run(&mut output) {
        Ok(()) => Ok(String::from_utf8(written.lock().unwrap().clone()).unwrap()),
        Err(Failure::Wrong(text)) => {
            Err(text.replace(&format!("{}/", folder.path().display()), ""))
        }
        Err(other) => panic!("{other:?}"),
    }
}

#[test]
fn poses_and_commands_in_any_form_and_order_say_the_same() {
    let [poses, twists, wheels] = recorded();
    let delay = |files: &[&str], flags: &str| {
        let said: Value = serde_json::from_str(&run(files, flags, true).unwrap()).unwrap();
        let (low, mean) = (&said["delay_s"]["low_s"], said["delay_s"]["mean_s"].as_f64().unwrap());
        assert!(low.as_f64().unwrap() < mean && (mean - 0.14).abs() < 0.005, "{said}");
        assert!(said["predicted"]["identified"]["heading_p90_rad"].is_f64(), "{said}");
        mean
    };
    let said = delay(&[&poses, &twists], "");
    assert_eq!(delay(&[&twists, &poses], "--drive"), said);
    assert_eq!(delay(&[&twists, &poses], "--drive track_width_m=0.1"), said);
    let by_wheels = delay(&[&wheels, &poses], "--drive wheel_radius_m=0.03,track_width_m=0.1");
    assert!((by_wheels - said).abs() < 1e-4);
    // Both in one file, each row one of them, with a column that is nobody's.
    let mut both =
        "battery_v,t_s,x_m,y_m,heading_rad,linear_m_per_s,angular_rad_per_s\n".to_owned();
    for (pose, twist) in poses.lines().zip(twists.lines()).skip(1) {
        let (time, twist) = twist.split_once(',').unwrap();
        writeln!(both, "12.1,{pose},,\n,{time},,,,{twist}").unwrap();
    }
    assert_eq!(delay(&[&both], ""), said);
}

#[test]
fn people_see_what_was_read_what_it_says_and_what_that_is_worth() {
    let [poses, twists, _] = recorded();
    let text = run(&[&poses, &twists], "", false).unwrap();
    for part in ["900, 33 per second", "  delay ", "  dead time", "taken in, 0 not understood"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(text.contains("predicted 0.27 s ahead") && text.contains("with lag 0 (-"), "{text}");
    assert!(!text.contains("note:"), "{text}");
}

/// Guards against: numbers of a recording that has none to tell.
#[test]
fn a_recording_that_says_little_is_said_to() {
    let [poses, twists, _] = recorded();
    let first = |text: &str| text.lines().take(61).collect::<Vec<_>>().join("\n");
    let text = run(&[&first(&poses), &first(&twists)], "", false).unwrap();
    assert!(text.contains("note: "), "{text}");
    let late = run(&[&poses, &twists], "--shift-poses -0.4", false).unwrap();
    assert!(late.contains("--shift-poses"), "{late}");
}

#[test]
fn what_is_wrong_is_named_with_its_place_and_remedy() {
    let [poses, twists, wheels] = recorded();
    let one = |row: &str| format!("{POSES}0,0,0,0\n{row}\n");
    let later = poses.replace("\n0.", "\n100.");
    for (files, flags, parts) in [
        (vec![one("0.1,nan,0,0")], "", vec!["0.csv line 3: x_m is \"nan\"", "leave the row out"]),
        (vec![one("0.1,0,0,inf")], "", vec!["line 3: heading_rad is \"inf\""]),
        (vec![one("0.1,0,,0")], "", vec!["line 3: y_m is empty", "fill it"]),
        (vec![one(",0,0,0")], "", vec!["line 3: t_s is empty"]),
        (vec![one("-1,0,0,0")], "", vec!["line 3: t_s is -1, before the pose above it at 0"]),
        (vec!["0,0,0,0\n".to_owned()], "", vec!["line 1: this is no header", "t_s, x_m"]),
        (vec!["t_s,x_m,heading_rad\n".to_owned()], "", vec!["line 1: there is no column y_m"]),
        (vec!["x_m,y_m,heading_rad\n".to_owned()], "", vec!["there is no column t_s"]),
        (vec!["t_s,speed\n".to_owned()], "", vec!["neither poses nor commands"]),
        (vec![String::new()], "", vec!["0.csv is empty"]),
        (vec![one(""), twists.clone()], "", vec!["1 poses, at least 20 are needed"]),
        (vec![poses.clone()], "", vec!["no commands", "left_rad_per_s"]),
        (vec![poses.clone(), wheels], "", vec!["1.csv line 2: wheel speeds", "--drive wheel_"]),
        (vec![poses.clone(), format!("{TWISTS}0,0,0\n")], "", vec!["all commands are to rest"]),
        (
            vec![poses.clone(), format!("{TWISTS}500,0,1\n501,0,0\n")],
            "",
            vec!["poses are of t_s 0.000 to 26.970 s", "500.000 to 501.000 s", "--shift-poses"],
        ),
        (vec![later], "--drive wheel_radius_m=x", vec!["\"wheel_radius_m=x\" is not"]),
        (vec![poses.clone()], "--drive radius=1", vec!["drive.radius is 1.0: UNKNOWN_FIELD"]),
        (vec![poses.clone()], "--drive wheel_radius_m=-1", vec!["OUT_OF_RANGE"]),
        (vec![poses.clone()], "--drive run.csv", vec!["put each FILE before --drive"]),
        (vec![poses.clone()], "--drive /nonexistent.json", vec!["cannot read /nonexistent.json"]),
        (vec![poses.clone()], "--position-noise 0", vec!["use a number above 0"]),
        (vec![poses], "--ahead nan", vec!["use more than 0"]),
        (vec![], "", vec!["FILE"]),
    ] {
        let files: Vec<&str> = files.iter().map(String::as_str).collect();
        let why = run(&files, flags, false).expect_err("it is wrong");
        assert!(parts.iter().all(|part| why.contains(part)), "{parts:?}: {why}");
    }
}

#[test]
fn of_commands_at_one_time_the_last_holds_and_of_poses_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    let wheels = Wheels::read("").unwrap();
    let mut rows = Rows::default();
    let text = "t_s,x_m,y_m,heading_rad,linear,angular\n1,2,3,7,0,1\r\n1,9,9,9,0,2\n\n2,0,0,0,,\n";
    fs::write(&path, format!("\u{feff}{text}")).unwrap();
    rows.read(&path, &wheels, &mut |_| ()).unwrap();
    let recording = rows.recording(0.5);
    assert_eq!(recording.commands, [(RobotTime::new(1.0), Twist::new(0.0, 2.0))]);
    assert_eq!(recording.poses.len(), 2);
    let first = recording.poses[0];
    assert_eq!((first.taken, first.pose.x), (RobotTime::new(1.5), 2.0));
    assert!((first.pose.heading.radians() - (7.0 - std::f64::consts::TAU)).abs() < 1e-12);
    assert!(rows_of(Path::new("/nonexistent.csv")).contains("cannot read /nonexistent.csv"));
}

fn rows_of(path: &Path) -> String {
    let wheels = Wheels::read("").unwrap();
    match Rows::default().read(path, &wheels, &mut |_| ()) {
        Err(Failure::Wrong(text)) => text,
        other => panic!("{other:?}"),
    }
}

/// Guards against: a description that says more than a drive is refused.
#[test]
fn of_a_description_the_drive_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rover.json");
    fs::write(&path, r#"{"drift": true, "drive": {"wheel_radius_m": 0.05, "track_width_m": 0.2}}"#)
        .unwrap();
    let wheels = Wheels::read(&path.display().to_string()).unwrap();
    let twist = wheels.twist(1.0, 3.0).unwrap();
    assert!((twist.linear - 0.1).abs() < 1e-12 && (twist.angular - 0.5).abs() < 1e-12);
    assert!(Wheels::read("track_width_m=0.2").unwrap().twist(1.0, 3.0).is_none());
}
