//! Writes the limits into the schemas: those that the checks ask for, recorded from a walk of each check.

use crate::check::{Check, Limit, Validate};
use crate::endpoint::Schemas;
use crate::{comparison, evolution, prior, robot, robot_check, square, step, task, training};
use utoipa::openapi::schema::{ArrayItems, Schema, SchemaType, Type};
use utoipa::openapi::{Object, RefOr};
use utoipa::{Number, ToSchema};

/// Writes each limit of everything that the server or the robot takes in.
///
/// # Panics
/// Where a check asks about a field that its schema does not have: a mistake in this crate, found by its tests.
pub(super) fn apply(schemas: &mut Schemas) {
    let monte_carlo = robot::Predictor::MonteCarlo { agents: 1, cell_m: 0.01, seed: 0 };
    let prior = robot::PriorChoice::Inline(robot::Prior::default());
    let spec = robot::Spec { predictor: monte_carlo, prior, ..robot::Spec::default() };
    for example in [&robot::Spec::default(), &spec] {
        write(schemas, example);
        // A patch may have whatever a spec may have.
        write_to(schemas, &robot::Patch::name(), example);
    }
    write(
        schemas,
        &task::Spec {
            waypoints: vec![task::Waypoint { x_m: 0.0, y_m: 0.0 }],
            tolerance_m: Some(0.01),
            reverse: false,
            calibration: Some(task::Calibration::default()),
            max_deviation_m: Some(1.0),
            check: Some(robot_check::Wiggle::default()),
            square: Some(square::Square { side_m: Some(1.0), ..square::Square::default() }),
        },
    );
    write_evolve(schemas);
    let observation = step::Observation { x_m: 0.0, y_m: 0.0, heading_rad: 0.0, taken_s: 0.0 };
    write(
        schemas,
        &step::Request {
            sequence: 1,
            epoch: 0,
            sent_s: 0.0,
            observations: vec![observation],
            deliveries: vec![step::Delivery { sequence: 0, loop_delay_s: 0.0 }],
            playing: Some(step::Playing { horizon: 0, since_s: 0.0 }),
            hold: false,
            max_speed_m_per_s: Some(0.0),
            drive_tag: Some(0),
        },
    );
    write(
        schemas,
        &step::TaggedDrive { tag: 1, drive: robot::Drive::default(), corrected_up_to: Some(1.0) },
    );
    write(
        schemas,
        &step::Horizon {
            sequence: 0,
            answers: 0,
            start_s: 0.0,
            slot_s: 0.03,
            watchdog_s: 0.3,
            valid_until_s: None,
            wheel_speeds: vec![step::WheelSpeeds::default()],
        },
    );
}

/// Priors, simulated environments with each kind of link, evolutions and comparisons.
fn write_evolve(schemas: &mut Schemas) {
    write(schemas, &prior::Spec { note: Some(String::new()), ..prior::Spec::default() });
    for rtt in [
        training::Rtt::Constant { rtt_s: 0.0 },
        training::Rtt::Lognormal { median_s: 0.01, p99_s: 0.1 },
        training::Rtt::Trace { rows: vec![training::TraceRow { t_s: 0.0, rtt_s: 0.0 }] },
    ] {
        let model = training::LinkModel {
            sensor_delay_s: 0.0,
            rtt,
            late: training::LatePackets { after_late: Some(0.0), ..Default::default() },
            outages: vec![training::Outage { start_s: 0.0, duration_s: 0.0 }],
            silences: training::Silences::default(),
            in_order: true,
        };
        write(
            schemas,
            &training::Spec {
                slip: training::Floor::Slip(training::Slip::default()),
                link: training::Link::Model(Box::new(model)),
                fitness: training::Fitness::Normal,
                weight: 1.0,
                note: None,
            },
        );
    }
    write(
        schemas,
        &training::Spec {
            slip: training::Floor::Preset("hard".to_owned()),
            link: training::Link::Preset("normal".to_owned()),
            fitness: training::Fitness::Normal,
            weight: 1.0,
            note: None,
        },
    );
    let (prior, name) = (Some("mine".to_owned()), "normal".to_owned());
    let environments = Some(vec![name]);
    write(
        schemas,
        &evolution::Request { prior: prior.clone(), environments, ..Default::default() },
    );
    let methods = Some(vec!["bayesian".to_owned()]);
    write(schemas, &comparison::Request { prior, methods, ..Default::default() });
}

fn write<T: Validate + ToSchema>(schemas: &mut Schemas, example: &T) {
    write_to(schemas, &T::name(), example);
}

/// Writes the limits of `example` into the schema `name`.
fn write_to(schemas: &mut Schemas, name: &str, example: &impl Validate) {
    for (path, limit) in Check::limits(example) {
        let steps = path.replace("[0]", ".[]");
        let steps: Vec<_> = steps.split('.').collect();
        let mut name = name.to_owned();
        let mut rest = steps.as_slice();
        loop {
            let found = schemas.get_mut(&name).map(|schema| place(schema, rest, &limit));
            match found {
                Some(Found::Written) => break,
                Some(Found::In { schema, left }) => {
                    name = schema;
                    rest = &steps[steps.len() - left..];
                }
                Some(Found::Nothing) | None => panic!("{name} has no field {path}"),
            }
        }
    }
}

enum Found {
    Written,
    /// Go on in the schema of this name with so many steps left.
    In {
        schema: String,
        left: usize,
    },
    Nothing,
}

fn place(schema: &mut RefOr<Schema>, steps: &[&str], limit: &Limit) -> Found {
    let schema = match schema {
        RefOr::Ref(reference) => {
            let name = reference.ref_location.rsplit('/').next().unwrap_or_default();
            return Found::In { schema: name.to_owned(), left: steps.len() };
        }
        RefOr::T(schema) => schema,
    };
    let Some((first, rest)) = steps.split_first() else { return write_here(schema, limit) };
    match schema {
        Schema::Object(object) => match object.properties.get_mut(*first) {
            Some(property) => place(property, rest, limit),
            None => Found::Nothing,
        },
        Schema::Array(array) => match &mut array.items {
            ArrayItems::RefOrSchema(items) if *first == "[]" => place(items, rest, limit),
            _ => Found::Nothing,
        },
        Schema::OneOf(one_of) => place_in_any(&mut one_of.items, steps, limit),
        Schema::AllOf(all_of) => place_in_any(&mut all_of.items, steps, limit),
        Schema::AnyOf(any_of) => place_in_any(&mut any_of.items, steps, limit),
        _ => Found::Nothing,
    }
}

fn place_in_any(items: &mut [RefOr<Schema>], steps: &[&str], limit: &Limit) -> Found {
    for item in items {
        match place(item, steps, limit) {
            Found::Nothing => {}
            found => return found,
        }
    }
    Found::Nothing
}

fn write_here(schema: &mut Schema, limit: &Limit) -> Found {
    match (schema, limit) {
        (Schema::Object(object), Limit::Number(range)) => {
            set(object, Number::Float(range.min), Number::Float(range.max))
        }
        (Schema::Object(object), Limit::Integer(range)) => {
            set(object, Number::UInt(*range.start() as usize), Number::UInt(*range.end() as usize))
        }
        (Schema::Object(object), Limit::Length(range)) => {
            object.min_length = (*range.start() > 0).then_some(*range.start());
            object.max_length = Some(*range.end());
            Found::Written
        }
        (Schema::Object(object), Limit::Pattern(pattern)) if is_text(object) => {
            object.pattern = Some((*pattern).to_owned());
            Found::Written
        }
        (Schema::Object(object), Limit::OneOf(known)) if is_text(object) => {
            let known = known.iter().map(|it| it.as_str().into());
            object.enum_values = Some(known.collect());
            Found::Written
        }
        (Schema::Array(array), Limit::EachOnce) => {
            array.unique_items = true;
            Found::Written
        }
        (Schema::Array(array), Limit::Length(range)) => {
            array.min_items = Some(*range.start());
            array.max_items = Some(*range.end());
            Found::Written
        }
        // A name or the thing: the limit of a name is that of the text among them.
        (Schema::OneOf(one_of), limit) => place_in_any(&mut one_of.items, &[], limit),
        _ => Found::Nothing,
    }
}

fn is_text(object: &Object) -> bool {
    match &object.schema_type {
        SchemaType::Type(kind) => *kind == Type::String,
        SchemaType::Array(kinds) => kinds.contains(&Type::String),
        SchemaType::AnyValue => false,
    }
}

fn set(object: &mut Object, min: Number, max: Number) -> Found {
    object.minimum = Some(min);
    object.maximum = Some(max);
    Found::Written
}
