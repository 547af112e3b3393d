//! What is read is what was said, wherever in a body it stands: each law over every place of a full body of each kind.

use super::*;
use crate::{comparison, evolution, prior, robot, step, task, training};
use serde_json::json;

/// A kind of body: how it is read and said again, and one that has everything that it can have.
struct Kind {
    name: &'static str,
    read: fn(&[u8]) -> Result<Value, Problems>,
    full: Value,
}

fn said<T: Serialize>(read: Result<T, Problems>) -> Result<Value, Problems> {
    read.map(|body| serde_json::to_value(body).unwrap())
}

fn kinds() -> Vec<Kind> {
    let channel = json!({"mu": -0.5, "k": 2.5, "r": 3.5, "s": 0.5});
    let channels =
        json!({"forward": channel, "lateral": channel, "turn": channel, "drift": channel});
    let mut robot = serde_json::to_value(robot::Spec::default()).unwrap();
    robot["predictor"] = json!({"kind": "monte-carlo", "agents": 100, "cell_m": 0.25, "seed": 7});
    robot["prior"] = channels.clone();
    let mut prior = channels.clone();
    prior["note"] = json!("of the wet hall");
    let slip = json!({"mean": 0.25, "sd": 0.25});
    let trace =
        json!({"kind": "trace", "rows": [{"t_s": 0.5, "rtt_s": 0.25}, {"t_s": 1.5, "rtt_s": 0.5}]});
    let training = |rtt: Value| {
        json!({
            "slip": {"forward": slip, "lateral": slip, "turn": slip, "drift": slip},
            "link": {
                "sensor_delay_s": 0.25, "rtt": rtt, "in_order": true,
                "late": {"probability": 0.25, "after_late": 0.5, "extra_s": 0.5},
                "outages": [{"start_s": 1.5, "duration_s": 0.5}],
                "silences": {"rate_per_s": 0.125, "shortest_s": 0.5, "longest_s": 1.5},
            },
            "fitness": "bad", "weight": 1.5, "note": "a hall",
        })
    };
    let lognormal = json!({"kind": "lognormal", "median_s": 0.25, "p99_s": 0.5});
    let evolution = json!({
        "preset": "quick", "environments": ["normal"], "population": 4, "generations": 3, "trials": 2,
        "selection_trials": 2, "report_trials": 3, "seed": 7, "prior": "found", "max_time_s": 60.5,
    });
    let comparison = json!({
        "scenario": "thesis", "methods": ["bayesian/20"], "trials": 10, "seed": 3, "prior": "found",
    });
    let task = json!({
        "waypoints": [{"x_m": 0.5, "y_m": -0.0}, {"x_m": 1.5, "y_m": 0.25}], "tolerance_m": 0.0125, "reverse": true,
        "calibration": {
            "rotations": 4, "angular_rad_per_s": 1.5, "rotate_s": 0.5, "pause_s": 0.5, "straight_m": 0.25,
        },
    });
    let step = json!({
        "sequence": 7, "epoch": 4711, "sent_s": 12.5,
        "observations": [{"x_m": 0.5, "y_m": 0.25, "heading_rad": -0.5, "taken_s": 12.25}],
        "deliveries": [{"sequence": 5, "loop_delay_s": 0.25}],
        "playing": {"horizon": 4, "since_s": 12.25},
    });
    let kind = |name, read, full| Kind { name, read, full };
    vec![
        kind("robot", |json| said(robot::Description::read(json)), robot),
        kind("task", |json| said(task::Spec::read(json)), task),
        kind("step", |json| said(step::Request::read(json)), step),
        kind("prior", |json| said(prior::Spec::read(json)), prior),
        kind("training", |json| said(training::Spec::read(json)), training(trace)),
        kind("training", |json| said(training::Spec::read(json)), training(lognormal)),
        kind("evolution", |json| said(evolution::Request::read(json)), evolution),
        kind("comparison", |json| said(comparison::Request::read(json)), comparison),
    ]
}

/// Every place in `value` that `is_meant`: as a JSON pointer, and as an error names it.
fn places(value: &Value, is_meant: fn(&Value) -> bool) -> Vec<(String, String)> {
    fn walk(
        value: &Value,
        at: (String, String),
        is_meant: fn(&Value) -> bool,
        found: &mut Vec<(String, String)>,
    ) {
        if is_meant(value) {
            found.push(at.clone());
        }
        let (pointer, path) = at;
        for (name, value) in value.as_object().into_iter().flatten() {
            let dot = if path.is_empty() { "" } else { "." };
            let inner = (format!("{pointer}/{name}"), format!("{path}{dot}{name}"));
            walk(value, inner, is_meant, found);
        }
        for (index, value) in value.as_array().into_iter().flatten().enumerate() {
            let inner = (format!("{pointer}/{index}"), format!("{path}[{index}]"));
            walk(value, inner, is_meant, found);
        }
    }
    let mut found = Vec::new();
    walk(value, Default::default(), is_meant, &mut found);
    found
}

/// `kind`'s full body with something else at `pointer`.
fn with(kind: &Kind, pointer: &str, other: impl Fn(&Value) -> Value) -> Vec<u8> {
    let mut body = kind.full.clone();
    let place = body.pointer_mut(pointer).unwrap();
    *place = other(place);
    serde_json::to_vec(&body).unwrap()
}

fn refused(kind: &Kind, body: &[u8]) -> Problems {
    let text = String::from_utf8_lossy(body);
    (kind.read)(body).expect_err(&format!("{}: {text}", kind.name))
}

#[test]
fn a_full_body_is_read_as_it_was_said() {
    for kind in kinds() {
        let read = (kind.read)(&serde_json::to_vec(&kind.full).unwrap()).unwrap();
        for (pointer, path) in places(&kind.full, |value| !value.is_object() && !value.is_array()) {
            let given = kind.full.pointer(&pointer).unwrap();
            assert_eq!(read.pointer(&pointer), Some(given), "{}: {path}", kind.name);
        }
    }
}

/// Guards against: `"calibration": []` makes ten turns.
#[test]
fn a_list_is_no_object_wherever_it_stands() {
    for kind in kinds() {
        let objects = places(&kind.full, Value::is_object);
        assert!(!objects.is_empty());
        for (pointer, path) in objects {
            let values =
                |it: &Value| it.as_object().unwrap().values().cloned().collect::<Vec<_>>().into();
            for body in [with(&kind, &pointer, values), with(&kind, &pointer, |_| json!([]))] {
                let problems = refused(&kind, &body);
                let detail = &problems.details()[0];
                // Within a tagged enum the field is that of the enum.
                assert!(path.starts_with(&detail.field), "{}: {path}: {detail:?}", kind.name);
                assert!(detail.remedy.contains("an object"), "{}: {detail:?}", kind.name);
            }
        }
    }
}

#[test]
fn whole_numbers_may_be_said_with_a_fraction_of_zero_and_not_with_another() {
    for kind in kinds() {
        let integers = places(&kind.full, |value| value.is_u64());
        let plain = (kind.read)(&serde_json::to_vec(&kind.full).unwrap()).unwrap();
        for (pointer, path) in integers {
            let text = serde_json::to_string(&kind.full).unwrap();
            let number = kind.full.pointer(&pointer).unwrap().as_u64().unwrap();
            let other = |literal: &str| {
                let marked = with(&kind, &pointer, |_| json!("HERE"));
                String::from_utf8(marked).unwrap().replace("\"HERE\"", literal).into_bytes()
            };
            for same in
                [format!("{number}.0"), format!("{number}.000e0"), format!("{}e-1", 10 * number)]
            {
                assert_eq!(
                    (kind.read)(&other(&same)),
                    Ok(plain.clone()),
                    "{path}: {same} in {text}"
                );
            }
            for wrong in ["20.5", "-3.0", "-3", "1e17", "\"20\"", "true", "[20]", "{}"] {
                let problems = refused(&kind, &other(wrong));
                assert!(problems.details()[0].field.starts_with(&path[..3]), "{problems}");
            }
        }
    }
}

/// A zero is a zero, whatever its sign; what cannot be exact is not taken for it.
#[test]
fn whole_numbers_end_where_they_are_no_longer_exact() {
    let sequence = |literal: &str| {
        let text = format!(r#"{{"sequence": {literal}, "epoch": 1, "sent_s": 0}}"#);
        step::Request::read(text.as_bytes()).map(|it| it.sequence)
    };
    assert_eq!((sequence("-0"), sequence("-0.0"), sequence("0e9")), (Ok(0), Ok(0), Ok(0)));
    assert_eq!(sequence("9007199254740991.0"), Ok((1 << 53) - 1));
    for literal in ["9007199254740992.0", "9007199254740993.0", "9007199254740992", "1e300"] {
        assert!(sequence(literal).is_err(), "{literal}");
    }
    let remedy = sequence("1e300").unwrap_err().details()[0].remedy.clone();
    assert_eq!(remedy, "use a whole number from 0 to 9007199254740991");
}

/// Guards against: of a field that stands twice one is obeyed, and no one knows which.
#[test]
fn a_field_that_stands_twice_is_refused_wherever_it_stands() {
    for kind in kinds() {
        for (pointer, path) in places(&kind.full, Value::is_object) {
            let object = kind.full.pointer(&pointer).unwrap().as_object().unwrap();
            for (name, value) in object {
                let inner = serde_json::to_string(object).unwrap();
                let twice = inner.replacen('{', &format!("{{\"{name}\":{value},"), 1);
                let marked = with(&kind, &pointer, |_| json!("HERE"));
                let body = String::from_utf8(marked).unwrap().replace("\"HERE\"", &twice);
                let problems = refused(&kind, body.as_bytes());
                assert!(
                    problems.details()[0].remedy.contains("twice"),
                    "{path}.{name}: {problems}"
                );
            }
        }
    }
}

/// Each value of a wrong kind: our words, the field, the value.
#[test]
fn what_does_not_fit_is_told_with_field_value_and_remedy() {
    let of = |json: &str| match task::Spec::read(json.as_bytes()) {
        Err(problems) => {
            let detail = problems.details()[0].clone();
            (detail.field, detail.value, detail.remedy)
        }
        Ok(_) => panic!("{json} was taken"),
    };
    let cases = [
        (r#"{"waypoints": 7}"#, "waypoints", json!(7), "use a list, not a number"),
        (r#"{"waypoints": null}"#, "waypoints", json!(null), "use a list, not null"),
        (
            r#"{"waypoints": [{"x_m": "1", "y_m": 0}]}"#,
            "waypoints[0].x_m",
            json!("1"),
            "use a number, not a text",
        ),
        (
            r#"{"waypoints": [{"x_m": 1}]}"#,
            "waypoints[0].y_m",
            json!(null),
            "it is missing and has no default: say it",
        ),
        (
            r#"{"waypoints": [], "reverse": 1}"#,
            "reverse",
            json!(1),
            "use true or false, not a number",
        ),
        (
            r#"{"waypoints": [], "calibration": "yes"}"#,
            "calibration",
            json!("yes"),
            "use an object with rotations, angular_rad_per_s, rotate_s, pause_s, straight_m, not a text",
        ),
        (
            r#"{"waypoints": [], "calibration": {"rotations": 5e9}}"#,
            "calibration.rotations",
            json!(5e9),
            "use a whole number from 0 to 4294967295",
        ),
    ];
    for (json, field, value, remedy) in cases {
        assert_eq!(of(json), (field.to_owned(), value, remedy.to_owned()), "{json}");
    }
    let method = robot::Description::read(br#"{"method": "magic"}"#).unwrap_err();
    assert!(
        method
            .to_string()
            .starts_with(r#"MALFORMED: method is "magic": use one of: fixed-normal, "#)
    );
    let kind = robot::Description::read(br#"{"predictor": {"kind": "monte-carlo", "agents": 5}}"#)
        .unwrap_err();
    assert_eq!(kind.details()[0].field, "predictor.cell_m");
    let prior = robot::Description::read(br#"{"prior": 7}"#).unwrap_err();
    let told =
        "MALFORMED: prior is 7: use the name of a prior, or an object with one, not a number";
    assert_eq!(prior.to_string(), told);
}

#[test]
fn what_is_no_json_is_told_in_our_words() {
    let deep = format!("{}{}", "[".repeat(2000), "]".repeat(2000));
    let cases: [(&[u8], &str, &str); 17] = [
        (b"", "", "the body is empty"),
        (b" \n ", "", "the body is empty"),
        (
            b"{\"waypoints\": [{\"x_m\": NaN, \"y_m\": 0}]}",
            "waypoints[0].x_m",
            "NaN is no number in JSON",
        ),
        (b"{\"tolerance_m\": -Infinity}", "tolerance_m", "-Infinity is no number in JSON"),
        (b"{\"tolerance_m\": 1e999}", "tolerance_m", "1e999 is beyond every number"),
        (b"{\"reverse\": True}", "reverse", "True is no word of JSON"),
        (b"{\"reverse\": None}", "reverse", "None is no word of JSON"),
        (b"{\"reverse\":\n  maybe}", "reverse", "it is no JSON from maybe on, at line 2 column"),
        (b"{'reverse': true}", "", "it is no JSON at line 1 column 2"),
        (b"{\"reverse\": true,}", "", "it is no JSON at line 1 column 18"),
        (b"{} {}", "", "it is no JSON at line 1 column 4: send one JSON object and nothing else"),
        (b"{\"waypoints\": [", "waypoints", "the text ends in the middle of a value"),
        (b"\xff\xfe{\0}\0", "", "it begins with the byte-order mark of UTF-16"),
        (b"{\0}\0", "", "it is UTF-16 or UTF-32"),
        (b"\x1f\x8b\x08\0", "", "it is compressed (gzip)"),
        (b"{\"a\": \"\xc3\x28\"}", "", "byte 7 is no text of UTF-8"),
        (deep.as_bytes(), "", "lists and objects lie more than 127 deep"),
    ];
    for (body, field, words) in cases {
        let problems = task::Spec::read(body).unwrap_err();
        let detail = &problems.details()[0];
        assert_eq!(detail.reason, reason::MALFORMED);
        assert!(detail.remedy.starts_with(words), "{words}: {detail:?}");
        assert!(detail.field.starts_with(field), "{field}: {detail:?}");
    }
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    let plain: &[u8] = br#"{"waypoints": [{"x_m": 0.5, "y_m": 0}]}"#;
    let marked = [b"\xef\xbb\xbf", plain].concat();
    assert_eq!(task::Spec::read(&marked), task::Spec::read(plain));
    assert!(task::Spec::read(&[b" \xef\xbb\xbf", plain].concat()).is_err(), "not in the middle");
}

/// Guards against: a long hostile body that takes long to refuse.
#[test]
fn many_fields_are_refused_at_once() {
    let fields: String = (0..20_000).map(|index| format!("\"f{index}\":1,")).collect();
    let body = format!("{{{fields}\"x\":1}}");
    assert_eq!(step::Request::read(body.as_bytes()).unwrap_err().details()[0].field, "f0");
    assert_eq!(robot::Description::read(body.as_bytes()).unwrap_err().len(), 20_001);
}

/// Guards against: a field that is left out where it has its default is unknown to whoever says the default.
#[test]
fn a_field_that_a_type_leaves_out_is_known_all_the_same() {
    #[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
    struct Inner {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        limit: Option<f64>,
    }
    #[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
    struct Outer {
        inner: Vec<Inner>,
    }
    impl Validate for Outer {
        fn check(&self, _: &mut Check) {}
    }
    let read = |json: &str| read_shared::<Outer>(json.as_bytes()).map(Checked::into_inner);
    let inner = |limit| Ok(Outer { inner: vec![Inner { limit }] });
    assert_eq!(read(r#"{"inner": [{"limit": null}]}"#), inner(None));
    assert_eq!(read(r#"{"inner": [{"limit": 1.5}]}"#), inner(Some(1.5)));
    let unknown = read(r#"{"inner": [{"limits": null}]}"#).unwrap_err();
    assert_eq!(unknown.details()[0].field, "inner[0].limits");
}

/// Guards against serde's other spelling of a variant: its number.
#[test]
fn a_variant_is_never_told_by_its_number() {
    for number in [json!(0), json!(1), json!(7), json!(true), json!(null), json!([]), json!({})] {
        let body = json!({"predictor": {"kind": number}}).to_string();
        let problems = robot::Description::read(body.as_bytes()).expect_err(&body);
        assert_eq!(problems.details()[0].field, "predictor.kind", "{problems}");
    }
}
