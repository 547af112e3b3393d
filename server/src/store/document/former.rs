//! The way upward from the forms of earlier versions.
//!
//! The first forms were core's own: its names, without units, and its enums. What leads from them is frozen: it knows the
//! names of then. What is missing stays missing: the base says what that means.

use serde_json::{Map, Value, json};

type Fields = Map<String, Value>;

/// From core's names of a robot to the specs of the wire, the values of its prior beside its name.
pub(super) fn robot(content: &mut Fields) {
    let name = content.remove("prior").filter(Value::is_string);
    if let Some(settings) = fields_in(content, "settings") {
        let prior = settings.get("prior").cloned();
        controller(settings);
        settings.extend(name.map(|name| ("prior".to_owned(), name)));
        content.extend(prior.map(|prior| ("prior".to_owned(), prior)));
    }
    inside(content, "task", task);
}

/// A robot of whose drive nothing was said but that followed at once goes on to: it is as if that had been said.
pub(super) fn lag(content: &mut Fields) {
    let kept = content.get("settings").and_then(|settings| settings.get("drive")).cloned();
    let Some(said) = fields_in(content, "said") else { return };
    let drive = said.entry("drive").or_insert_with(|| json!({}));
    if let (Some(Value::Object(kept)), Some(drive)) = (kept, drive.as_object_mut()) {
        for field in ["lag_s", "dead_time_s"] {
            if let Some(value) = kept.get(field) {
                drive.entry(field).or_insert_with(|| value.clone());
            }
        }
    }
}

/// A robot of which no method was said, nor what errors are measured against, goes on with what it had.
pub(super) fn method(content: &mut Fields) {
    let kept = content.get("settings").cloned().unwrap_or_default();
    let Some(said) = fields_in(content, "said") else { return };
    for field in ["method", "attribution"] {
        if let Some(value) = kept.get(field) {
            said.entry(field).or_insert_with(|| value.clone());
        }
    }
}

/// Only new fields, whose base says what their lack means.
pub(crate) fn same(_: &mut Fields) {}

/// The note goes to the values of a prior.
pub(super) fn prior(content: &mut Fields) {
    let note = content.remove("note").unwrap_or_default();
    inside(content, "prior", |prior| {
        prior.insert("note".to_owned(), note);
    });
}

/// From core's names of an environment to the spec of the wire, its name left to its key.
pub(super) fn environment(content: &mut Fields) {
    let note = content.remove("note").unwrap_or_default();
    if let Some(Value::Object(mut environment)) = content.remove("environment") {
        environment.remove("name");
        inside(&mut environment, "link", link);
        environment.insert("note".to_owned(), note);
        *content = environment;
    }
}

/// From core's names of the settings of a job to the specs of the wire.
pub(crate) fn job_settings(content: &mut Fields) {
    let Some(settings) = fields_in(content, "settings") else { return };
    inside(settings, "controller", controller);
    inside(settings, "task", task);
    inside(settings, "start", |start| {
        rename(start, &[("x", "x_m"), ("y", "y_m"), ("heading", "heading_rad")]);
    });
    rename(settings, &[("time_limit", "time_limit_s")]);
    each_in(settings, "contenders", |contender| rename(contender, &[("slots", "horizon_slots")]));
    each_in(settings, "environments", |environment| {
        inside(environment, "link", link);
        // That of a comparison has a robot of its own.
        if let Some(Value::Object(plant)) = environment.remove("plant") {
            environment.extend(plant);
        }
        inside(environment, "drive", drive);
        inside(environment, "noise", noise);
        inside(environment, "region", |region| {
            rename(region, &[("from", "from_m"), ("to", "to_m")]);
            inside(region, "link", link);
        });
    });
    inside(settings, "limits", |limits| {
        rename(limits, &[("deviation", "max_deviation_m"), ("time", "max_time_s")]);
    });
}

fn controller(settings: &mut Fields) {
    inside(settings, "drive", drive);
    inside(settings, "noise", noise);
    inside(settings, "variance", |variance| {
        rename(variance, &[("position", "position_m2"), ("heading", "heading_rad2")]);
    });
    inside(settings, "steering", |steering| {
        rename(
            steering,
            &[
                ("alpha", "alpha_m_per_s"),
                ("stop_radius", "stop_radius_m"),
                ("turn_tolerance", "turn_tolerance_rad"),
                ("turn_beyond", "turn_beyond_rad"),
            ],
        );
    });
    if let Some(predictor) = settings.get_mut("predictor") {
        tag(predictor, |agents| rename(agents, &[("cell", "cell_m")]));
    }
    // Slots have had one length ever since.
    settings.remove("slot");
    let names =
        [("slots", "horizon_slots"), ("loop_delay", "loop_delay_s"), ("watchdog", "watchdog_s")];
    rename(settings, &names);
}

fn drive(drive: &mut Fields) {
    rename(
        drive,
        &[
            ("wheel_radius", "wheel_radius_m"),
            ("track_width", "track_width_m"),
            ("max_wheel_speed", "max_wheel_speed_rad_per_s"),
            ("max_linear", "max_linear_m_per_s"),
            ("min_linear", "min_linear_m_per_s"),
            ("max_angular", "max_angular_rad_per_s"),
            ("min_angular", "min_angular_rad_per_s"),
            ("max_linear_acceleration", "max_linear_acceleration_m_per_s2"),
            ("max_angular_acceleration", "max_angular_acceleration_rad_per_s2"),
            ("lag", "lag_s"),
            ("dead_time", "dead_time_s"),
        ],
    );
}

fn noise(noise: &mut Fields) {
    rename(noise, &[("position", "position_m"), ("heading", "heading_rad")]);
}

fn task(task: &mut Fields) {
    each_in(task, "waypoints", |point| rename(point, &[("x", "x_m"), ("y", "y_m")]));
    rename(task, &[("tolerance", "tolerance_m"), ("max_deviation", "max_deviation_m")]);
    inside(task, "calibration", |calibration| {
        rename(
            calibration,
            &[
                ("angular", "angular_rad_per_s"),
                ("rotate", "rotate_s"),
                ("pause", "pause_s"),
                ("straight", "straight_m"),
            ],
        );
    });
}

fn link(link: &mut Fields) {
    rename(link, &[("sensor_delay", "sensor_delay_s")]);
    if let Some(rtt) = link.get_mut("rtt") {
        round_trip(rtt);
    }
    inside(link, "late", |late| rename(late, &[("extra", "extra_s")]));
    each_in(link, "outages", |outage| {
        rename(outage, &[("start", "start_s"), ("duration", "duration_s")]);
    });
    inside(link, "silences", |silences| {
        let names = [("rate", "rate_per_s"), ("shortest", "shortest_s"), ("longest", "longest_s")];
        rename(silences, &names);
    });
}

fn round_trip(rtt: &mut Value) {
    let Some(kinds) = rtt.as_object_mut() else { return };
    if let Some(constant) = kinds.remove("constant") {
        *rtt = json!({"kind": "constant", "rtt_s": constant});
    } else if let Some(Value::Array(rows)) = kinds.remove("trace") {
        let row = |row: &Value| json!({"t_s": row[0], "rtt_s": row[1]});
        *rtt = json!({"kind": "trace", "rows": rows.iter().map(row).collect::<Vec<_>>()});
    } else {
        tag(rtt, |quantiles| rename(quantiles, &[("median", "median_s"), ("p99", "p99_s")]));
    }
}

/// From `"moments"` and `{"monte-carlo": {...}}` to `{"kind": ..., ...}`, its fields as `rename` has them.
fn tag(value: &mut Value, rename: impl FnOnce(&mut Fields)) {
    match value {
        Value::String(kind) => *value = json!({"kind": kind}),
        Value::Object(kinds) => {
            let Some((kind, Value::Object(mut fields))) = std::mem::take(kinds).into_iter().next()
            else {
                return;
            };
            rename(&mut fields);
            fields.insert("kind".to_owned(), kind.into());
            *value = fields.into();
        }
        _ => {}
    }
}

fn fields_in<'a>(fields: &'a mut Fields, name: &str) -> Option<&'a mut Fields> {
    fields.get_mut(name).and_then(Value::as_object_mut)
}

fn inside(fields: &mut Fields, name: &str, change: impl FnOnce(&mut Fields)) {
    if let Some(inner) = fields_in(fields, name) {
        change(inner);
    }
}

fn each_in(fields: &mut Fields, name: &str, change: impl Fn(&mut Fields)) {
    let items = fields.get_mut(name).and_then(Value::as_array_mut);
    items.into_iter().flatten().filter_map(Value::as_object_mut).for_each(change);
}

fn rename(fields: &mut Fields, names: &[(&str, &str)]) {
    for (before, after) in names {
        if let Some(value) = fields.remove(*before) {
            fields.insert((*after).to_owned(), value);
        }
    }
}
