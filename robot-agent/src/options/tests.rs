use super::*;
use clap::CommandFactory;
use umwelt_agent::drive::Drive as _;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::SlipChannel;

fn plan(arguments: &[&str]) -> Result<Plan, String> {
    let all = ["umwelt-agent", "--robot", "rover-7"].iter().chain(arguments);
    Options::try_parse_from(all).map_err(|error| error.to_string())?.plan()
}

fn refused(arguments: &[&str]) -> String {
    plan(arguments).err().unwrap_or_else(|| panic!("{arguments:?} was taken"))
}

#[test]
fn the_command_line_is_consistent() {
    Options::command().debug_assert();
}

#[test]
fn a_floor_is_a_preset_or_channels() {
    assert_eq!(slip("oily"), Ok(Slip::OILY));
    let expected = Slip {
        forward: SlipChannel::new(-0.1, 0.15).unwrap(),
        turn: SlipChannel::new(0.05, 0.0).unwrap(),
        ..Slip::NONE
    };
    assert_eq!(slip("forward=-0.1:0.15,turn=0.05:0"), Ok(expected));
    for wrong in
        ["", "lava", "forward", "forward=1", "forward=x:1", "up=0:0", "turn=0:-1", "turn=0:9"]
    {
        assert!(slip(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn what_is_asked_for_is_what_runs() {
    let plan = plan(&["--link", "bad", "--seed", "7", "--max-speed", "0.2", "--start", "-1,2,0.5"])
        .unwrap();
    assert_eq!(plan.config.link, LinkModel::preset("bad"));
    assert_eq!((plan.config.seed, plan.config.drive.max_linear), (7, Some(0.2)));
    assert!(matches!(plan.which, Which::Sim(_)));
}

/// Guards against: a simulated robot that becomes of the kind that it is described as, where another one was asked for.
#[test]
fn a_simulated_robot_can_be_of_another_kind_than_described() {
    let kind = |arguments: &[&str]| {
        let Which::Sim(mut sim) = plan(arguments).unwrap().which else { panic!("no simulation") };
        let before = sim.model().drive.kind;
        sim.describe(&Drive::default());
        (before, sim.model().drive.kind)
    };
    let skid = Kind::SkidSteer(SkidSteer { turn_by_speed: 0.5, sideways: -0.02 });
    let said = ["--kind", "skid-steer", "--sideways", "-0.02", "--turn-by-speed", "0.5"];
    assert_eq!(kind(&said), (skid, skid));
    assert_eq!(kind(&[]), (Kind::Differential, Kind::Differential));
}

#[test]
fn a_wrong_call_says_what_is_wrong() {
    for (arguments, reason) in [
        (&["--kind", "differential", "--sideways", "0.1"] as &[&str], "--kind skid-steer only"),
        (&["--drive", "pipe", "--kind", "skid-steer"], "--kind goes with --drive sim only"),
        (&["--link", "worse"] as &[&str], "neither one of clean, normal"),
        (&["--link", "trace:/nowhere.csv"], "/nowhere.csv: No such file"),
        (&["--drive", "pipe", "--slip", "oily"], "--slip goes with --drive sim only"),
        (&["--output", "twist"], "--output goes with --drive pipe only"),
        (&["--wheel-radius", "0"], "0 is not positive"),
        (&["--track-width", "inf"], "inf is not finite"),
        (
            &["--min-speed", "0.5", "--max-speed", "0.4"],
            "--min-speed 0.5 is larger than --max-speed 0.4",
        ),
        (&["--dead-time", "9"], "a dead time of 9 s"),
        (&["--server", "ftp://h"], "http://"),
        (&["--token-file", "/nowhere/token"], "/nowhere/token"),
        (&["--start", "1,2"], "X,Y,HEADING"),
        (&["--trace", "/nowhere/t.csv"], "/nowhere/t.csv"),
    ] {
        let said = refused(arguments);
        assert!(said.contains(reason), "{arguments:?}: {said}");
    }
}

/// The names that these flags had before they were those of `umwelt robot add`.
#[test]
fn the_old_names_of_flags_are_taken_still() {
    let new = ["--max-turn", "2", "--min-turn", "0.3", "--max-turn-acceleration", "4"];
    let old = ["--max-angular", "2", "--min-angular", "0.3", "--max-angular-acceleration", "4"];
    assert_eq!(plan(&new).unwrap().config.drive, plan(&old).unwrap().config.drive);
    for flag in ["--position-noise", "--noise-position", "--heading-noise", "--noise-heading"] {
        assert!(plan(&[flag, "0.001"]).is_ok(), "{flag}");
    }
}
