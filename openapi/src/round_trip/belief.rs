//! The laws of priors, and the checks of the simulated environments in which they are evolved.

use super::strategies::prior;
use super::{pairs, problems};
use crate::checked::Checked;
use crate::problem::reason;
use crate::{prior, robot, training};
use proptest::prelude::*;
use serde_json::{Value, json};
use umwelt_core::identification::BUILT_IN_PRIORS;
use umwelt_core::settings::Prior;

proptest! {
    #[test]
    fn a_prior_survives_the_wire(core in prior(), note in prop::option::of("[ -~ä]{0,99}")) {
        let spec = prior::Spec { note: note.clone(), ..robot::Prior::from(core).into() };
        let read = prior::Spec::read(&serde_json::to_vec(&spec).unwrap()).unwrap();
        prop_assert_eq!((read.to_core(), &read.note), (core, &note));
        let shown = prior::Prior::new("a".parse().unwrap(), read.into_inner(), prior::Source::Put, "1");
        let json = serde_json::to_string(&shown).unwrap();
        let shown: prior::Prior = serde_json::from_str(&json).unwrap();
        prop_assert_eq!(shown.to_spec(), spec);
    }
}

#[test]
fn what_is_built_in_can_be_put_under_another_name() {
    for name in BUILT_IN_PRIORS {
        let spec = prior::Spec::from(robot::Prior::from(Prior::built_in(name).unwrap()));
        let checked = Checked::new(spec).unwrap();
        assert_eq!(Some(checked.to_core()), Prior::built_in(name), "{name}");
        assert_eq!(prior::built_in(name).ok(), Prior::built_in(name));
    }
    assert_eq!(prior::built_in("best").unwrap_err(), BUILT_IN_PRIORS);
}

#[test]
fn a_robot_names_its_prior_or_has_its_own() {
    let read = |prior: Value| {
        let body = json!({ "prior": prior, "horizon_slots": 1 }).to_string();
        robot::Description::read_known(body.as_bytes(), prior::built_in)
    };
    let (said, settings) = read(json!("flat")).unwrap();
    assert_eq!(settings.prior, Prior::flat());
    assert!(said.says("prior") && !said.says("prior.turn"));
    let (said, settings) = read(json!({"turn": {"mu": 0.1, "k": 1, "r": 4, "s": 0.1}})).unwrap();
    assert!(said.says("prior.turn") && settings.prior.turn.mu() == 0.1);
    assert_eq!(settings.prior.forward, Prior::default().forward);
    assert_eq!(robot::Spec::default().prior.name(), Some(robot::DEFAULT_PRIOR));
}

#[test]
fn a_bad_prior_of_a_robot_is_told_with_everything_else() {
    let bad = |prior: Value| {
        let body = json!({ "prior": prior, "horizon_slots": 0, "drive": {"lag": 1} }).to_string();
        robot::Description::read_known(body.as_bytes(), prior::built_in).unwrap_err()
    };
    let told = |prior: Value| {
        let mut found = problems::<()>(Err(bad(prior)));
        let others =
            pairs(&[(reason::UNKNOWN_FIELD, "drive.lag"), (reason::OUT_OF_RANGE, "horizon_slots")]);
        found.retain(|problem| !others.contains(problem));
        found
    };
    assert_eq!(told(json!("best")), pairs(&[(reason::UNKNOWN_PRIOR, "prior")]));
    let problems = bad(json!("best"));
    let unknown = problems.details().iter().find(|it| it.field == "prior").unwrap();
    assert_eq!(
        (&unknown.value, unknown.remedy.as_str()),
        (&json!("best"), "known: default, flat, thesis, thesis-20, empirical")
    );
    assert_eq!(told(json!("The best")), pairs(&[(reason::INVALID_ID, "prior")]));
    let numbers = json!({"turn": {"mu": 99, "k": 0, "r": 4, "s": 0.1, "t": 5}, "yaw": {}});
    let mut found = told(numbers);
    found.sort();
    assert_eq!(
        found,
        pairs(&[
            (reason::OUT_OF_RANGE, "prior.turn.k"),
            (reason::OUT_OF_RANGE, "prior.turn.mu"),
            (reason::UNKNOWN_FIELD, "prior.turn.t"),
            (reason::UNKNOWN_FIELD, "prior.yaw"),
        ])
    );
    // Of another type altogether: serde stops there, but says where and what else it could be.
    for (prior, field) in [
        (json!(5), "prior"),
        (json!(null), "prior"),
        (json!(["flat"]), "prior"),
        (json!({"turn": {"mu": "x"}}), "prior.turn.mu"),
    ] {
        assert_eq!(told(prior.clone()), pairs(&[(reason::MALFORMED, field)]), "{prior}");
    }
    assert!(bad(json!(5)).details()[0].remedy.contains("the name of a prior, or an object"));
}

#[test]
fn every_number_of_a_simulated_environment_is_checked() {
    let read = |body: Value| training::Spec::read(body.to_string().as_bytes());
    let body = json!({"slip": {"turn": {"mean": 1.0, "sd": -1}}, "weight": 0, "fitnes": 1, "note": "x".repeat(1001), "link": {
        "sensor_delay_s": -1, "rtt": {"kind": "lognormal", "median_s": 2, "p99_s": 1},
        "late": {"probability": 0.5, "after_late": 1.0, "extra_s": 61},
        "outages": [{"start_s": 5, "duration_s": 2}, {"start_s": 6, "duration_s": 1}],
        "silences": {"rate_per_s": 10, "shortest_s": 10, "longest_s": 5}}});
    let mut found = problems(read(body));
    found.sort();
    assert_eq!(
        found,
        pairs(&[
            (reason::INCONSISTENT, "link.late.after_late"),
            (reason::INCONSISTENT, "link.outages[1].start_s"),
            (reason::INCONSISTENT, "link.rtt.p99_s"),
            (reason::INCONSISTENT, "link.silences.longest_s"),
            (reason::OUT_OF_RANGE, "link.late.extra_s"),
            (reason::OUT_OF_RANGE, "link.sensor_delay_s"),
            (reason::OUT_OF_RANGE, "slip.turn.mean"),
            (reason::OUT_OF_RANGE, "slip.turn.sd"),
            (reason::OUT_OF_RANGE, "weight"),
            (reason::UNKNOWN_FIELD, "fitnes"),
            (reason::WRONG_LENGTH, "note"),
        ])
    );
    let silent = json!({"slip": "hard", "link": {"rtt": {"kind": "constant", "rtt_s": 0},
                        "silences": {"rate_per_s": 10, "shortest_s": 10, "longest_s": 10}}});
    assert_eq!(
        problems(read(silent)),
        pairs(&[(reason::INCONSISTENT, "link.silences.rate_per_s")])
    );
    let unknown = read(json!({"slip": "lava", "link": "worse"})).unwrap_err();
    assert_eq!(unknown.details()[0].reason, reason::UNKNOWN_PRESET);
    assert!(unknown.details()[1].remedy.contains("wifi-bursty"), "{unknown}");
    let rows = |rows: Value| {
        read(json!({"slip": "hard", "link": {"rtt": {"kind": "trace", "rows": rows}}}))
    };
    assert_eq!(problems(rows(json!([]))), pairs(&[(reason::WRONG_LENGTH, "link.rtt.rows")]));
    let row = |t: f64| json!({"t_s": t, "rtt_s": 0.1});
    let back = problems(rows(json!([row(1.0), row(1.0)])));
    assert_eq!(back, pairs(&[(reason::INCONSISTENT, "link.rtt.rows[1].t_s")]));
    let most: Vec<_> = (0..=training::MAX_ROWS).map(|t| row(t as f64)).collect();
    assert!(rows(json!(most[1..])).is_ok() && rows(json!(most)).is_err());
    assert_eq!(problems(read(json!({"slip": "hard"}))), pairs(&[(reason::MALFORMED, "link")]));
}

#[test]
fn a_used_prior_names_some_robots_and_counts_all() {
    let spec = prior::Spec::default();
    let prior = prior::Prior::new("a".parse().unwrap(), spec, prior::Source::Put, "1");
    let robots = |count: usize| (0..count).map(|it| format!("r{it}").parse().unwrap());
    let used = prior.clone().used_by(robots(250));
    assert_eq!((used.robots.len(), used.robot_count), (prior::MAX_ROBOTS, 250));
    let used = prior.used_by(robots(2));
    assert_eq!((used.robots.len(), used.robot_count), (2, 2));
}
