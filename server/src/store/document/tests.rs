//! What is kept of every version means what it meant, field by field. The golden files called `least` have the fewest
//! fields that there can be: what a base says is pinned by them.

use super::*;
use serde_json::json;
use std::fmt::Debug;
use std::path::PathBuf;
use std::{env, fs};
use umwelt_core::settings::Method;

/// The golden files `name-1.json`, ..., from version `first` on, say the same, and the newest is what is written today.
/// With `UPDATE_GOLDEN` set it is written anew: before a form goes out, never after. Returns the newest.
pub(crate) fn golden<T: Debug + PartialEq>(
    form: &Form,
    name: &str,
    first: u64,
    read: impl Fn(&str) -> Result<T, Unreadable>,
    write: impl Fn(&T) -> String,
) -> String {
    let file = |version: u64| {
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("src/{name}-{version}.json"))
    };
    let body = |version| fs::read_to_string(file(version)).unwrap();
    let known = read(&body(first)).unwrap();
    let written = write(&known);
    if env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(file(form.version()), format!("{written}\n")).unwrap();
    }
    for version in first..=form.version() {
        let body = body(version);
        assert_eq!(serde_json::from_str::<Value>(&body).unwrap()["version"], version, "{name}");
        assert_eq!(read(&body).unwrap(), known, "{name}, version {version}");
    }
    // The program has other versions than the form.
    let plain = |body: &str| {
        let mut value: Value = serde_json::from_str(body).unwrap();
        value["program"] = Value::Null;
        value
    };
    let newest = body(form.version());
    assert_eq!(plain(&written), plain(&newest), "{name}: another form has a version of its own");
    newest
}

/// A body with one field less, whichever, means what the base says of it. It may be unreadable instead without an
/// `essential` field, or without one of those within a field that is named as `field/`.
pub(crate) fn one_field_less<T: Debug + PartialEq>(
    form: &Form,
    body: &str,
    essential: &[&str],
    read: impl Fn(&str) -> Result<T, Unreadable>,
) {
    let whole: Value = serde_json::from_str(body).unwrap();
    let root = if form.is_within { "/content" } else { "" };
    let mut paths = Vec::new();
    fields(whole.pointer(root).unwrap(), root, &mut paths);
    paths.retain(|path| path != "/version" && path != "/program");
    assert!(!paths.is_empty());
    let base: Value = serde_json::from_str(form.base).unwrap();
    for path in &paths {
        let parts = path.strip_prefix(root).unwrap().split('/').skip(1);
        let is_essential = essential.iter().any(|it| match it.strip_suffix('/') {
            Some(parent) => parts.clone().any(|part| part == parent),
            None => parts.clone().last() == Some(it),
        });
        let (mut less, mut plain) = (whole.clone(), whole.clone());
        let (parent, name) = path.rsplit_once('/').unwrap();
        less.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(name);
        let meant = match meaning(&base, parts) {
            Some(meaning) => meaning,
            None => {
                let less = read(&less.to_string());
                let has_no_meaning = less == read(body);
                assert!(
                    is_essential || has_no_meaning,
                    "{path}: the base does not say what its lack means"
                );
                continue;
            }
        };
        *plain.pointer_mut(path).unwrap() = meant;
        let (less, plain) = (read(&less.to_string()), read(&plain.to_string()));
        assert!(less == plain, "{path}");
        assert!(less.is_ok() || is_essential, "{path}");
    }
}

/// The paths of all fields.
fn fields(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(object) => {
            for (name, value) in object {
                let path = format!("{path}/{name}");
                fields(value, &path, found);
                found.push(path);
            }
        }
        Value::Array(items) => {
            for (index, value) in items.iter().enumerate() {
                fields(value, &format!("{path}/{index}"), found);
            }
        }
        _ => {}
    }
}

/// What it is to lack a field.
enum Lack {
    Meant,
    Null,
    Refused,
}

/// What the base says a missing field means; none where it must be there.
fn meaning<'a>(base: &Value, parts: impl Iterator<Item = &'a str>) -> Option<Value> {
    let (mut at, mut lack) = (base, Lack::Meant);
    for part in parts {
        (at, lack) = match at {
            Value::Array(items) => (items.first()?, Lack::Meant),
            Value::Object(fields) => match fields.get(part) {
                Some(found) => (found, Lack::Meant),
                None => match fields.get(&format!("{part}!")) {
                    Some(found) => (found, Lack::Refused),
                    None => (fields.get(&format!("{part}?"))?, Lack::Null),
                },
            },
            _ => return None,
        };
    }
    match lack {
        Lack::Null => return Some(Value::Null),
        Lack::Refused => return None,
        Lack::Meant => {}
    }
    let mut lacking = Value::Object(Map::new());
    let base = Value::Object(Map::from_iter([("it".to_owned(), at.clone())]));
    base::fill(&mut lacking, &base.to_string()).ok()?;
    Some(lacking["it"].clone())
}

fn at(name: &str) -> String {
    format!("store/document/golden/{name}")
}

#[test]
fn robots_of_every_version_mean_what_they_meant() {
    for name in ["robot", "named-prior", "least-robot"] {
        let read = |body: &str| robot::record(body, 7);
        let write = |record: &_| robot::of_record(record).unwrap();
        let newest = golden(&robot::FORM, &at(name), 1, read, write);
        let essential = ["settings", "drive", "prior", "waypoints", "x_m", "y_m", "kind", "said/"];
        one_field_less(&robot::FORM, &newest, &essential, read);
        one_field_less_of_version_1(&robot::FORM, name, read);
    }
}

/// Guards against: a robot that followed at once because nothing else was said begins to be identified.
#[test]
fn a_robot_of_which_nothing_was_said_goes_on_as_it_did() {
    let body = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/src/store/document/golden/least-robot-3.json"
    ));
    let mut body: Value = serde_json::from_str(&body.unwrap()).unwrap();
    body["said"] = json!({"drive": {"wheel_radius_m": 0.03}});
    let told = robot::record(&body.to_string(), 7).unwrap().told;
    assert!(told.said.says("drive.lag_s") && told.said.says("drive.dead_time_s"));
    assert!(!told.settings.identifies_lag && told.settings.follows_link.loop_delay);
    assert_eq!((told.settings.drive.lag, told.settings.drive.dead_time), (0.0, 0.0));
    body["version"] = json!(4);
    let told = robot::record(&body.to_string(), 7).unwrap().told;
    assert!(told.settings.identifies_lag);
    // The same of the method that is the default by now: a patch would bring it.
    assert!(told.said.says("method") && told.said.says("attribution"));
    assert_eq!(told.settings.method, Method::Bayesian);
    body["version"] = json!(5);
    assert!(!robot::record(&body.to_string(), 7).unwrap().told.said.says("method"));
}

#[test]
fn priors_of_every_version_mean_what_they_meant() {
    for name in ["prior", "champion", "least-prior"] {
        let read = |body: &str| prior::prior("p".to_owned(), body);
        let write = |prior: &_| prior::of_prior(prior).unwrap();
        let newest = golden(&prior::FORM, &at(name), 1, read, write);
        let essential = ["prior", "source/"];
        one_field_less(&prior::FORM, &newest, &essential, read);
        one_field_less_of_version_1(&prior::FORM, name, read);
    }
}

#[test]
fn environments_of_every_version_mean_what_they_meant() {
    type Spec = umwelt_api::training::Spec;
    for name in ["wet-hall", "odd", "least-environment"] {
        let read = |body: &str| {
            environment::FORM.read_with(body, |content| {
                let spec: Spec = serde_json::from_value(content).map_err(|it| it.to_string())?;
                let core = environment::environment("e".to_owned(), &spec)?;
                Ok::<_, String>((core, spec.note))
            })
        };
        let newest = golden(&environment::FORM, &at(name), 1, read, |(core, note)| {
            environment::FORM.write(&environment::of_environment(core, note.clone())).unwrap()
        });
        let essential = ["slip", "link", "rtt", "rtt/"];
        one_field_less(&environment::FORM, &newest, &essential, read);
        one_field_less_of_version_1(&environment::FORM, name, read);
    }
}

/// A body of version 1 with one field less is still read, but for what nothing can stand for.
fn one_field_less_of_version_1<T: Debug>(
    form: &Form,
    name: &str,
    read: impl Fn(&str) -> Result<T, Unreadable>,
) {
    let file = format!("{}/src/{}-1.json", env!("CARGO_MANIFEST_DIR"), at(name));
    let whole: Value = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
    let mut paths = Vec::new();
    fields(&whole, "", &mut paths);
    paths.retain(|path| path != "/version");
    let unreadable: Vec<_> = paths
        .iter()
        .filter(|path| {
            let mut less = whole.clone();
            let (parent, name) = path.rsplit_once('/').unwrap();
            less.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(name);
            read(&less.to_string()).is_err()
        })
        .collect();
    let essential = [
        "settings",
        "drive",
        "prior",
        "slip",
        "link",
        "waypoints",
        "rtt",
        "evolution",
        "seed",
        "optimizer",
        "fitness",
        "kind",
        "monte-carlo",
        "agents",
        "cell",
        "environment",
    ];
    for path in unreadable {
        assert!(path.split('/').any(|part| essential.contains(&part)), "{path} of {form:?}");
    }
}

#[test]
fn what_cannot_be_read_says_who_wrote_it() {
    let read = |body: &str| robot::record(body, 1).unwrap_err();
    let newer = read(r#"{"version": 9, "program": "0.7.0", "settings": 5}"#);
    assert_eq!(newer.written_by(), Some("0.7.0"));
    assert_eq!(newer.to_string(), "its form is of version 9, this program reads 1 to 5");
    let strange = read(r#"{"version": 2, "program": "0.2.0", "task": 5}"#);
    assert_eq!(strange.written_by(), Some("0.2.0"));
    for body in
        ["", "{", "[]", "{}", r#"{"version": 0}"#, r#"{"version": "2"}"#, r#"{"version": -1}"#]
    {
        let Unreadable::Meaningless { what, program: None } = read(body) else { panic!("{body}") };
        assert!(!what.is_empty());
    }
}
