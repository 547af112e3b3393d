//! What is sent has schemas that allow nothing beside what they name; those of what comes back stay open, because later
//! versions show more. A type that goes both ways has two of them: `RobotSpec` and `RobotSpecRequest`.

use serde_json::{Map, Value};
use std::collections::BTreeSet;
use utoipa::openapi::path::Operation;
use utoipa::openapi::schema::{AdditionalProperties, ArrayItems, Schema, SchemaType, Type};
use utoipa::openapi::{Content, OpenApi, RefOr};

const PREFIX: &str = "#/components/schemas/";

/// What the closed form of a schema is called that is shown too.
const SUFFIX: &str = "Request";

/// Gives request bodies closed schemas.
pub(super) fn close(document: &mut OpenApi) {
    // As JSON it is easier to see what refers to what.
    let value = serde_json::to_value(&*document).unwrap_or_default();
    let schemas = value["components"]["schemas"].as_object().cloned().unwrap_or_default();
    let (mut bodies, mut rest) = (Vec::new(), Vec::new());
    for item in value["paths"].as_object().into_iter().flat_map(Map::values) {
        for (keyword, part) in item.as_object().into_iter().flatten().flat_map(|(_, it)| fields(it))
        {
            if keyword == "requestBody" { &mut bodies } else { &mut rest }.push(part);
        }
    }
    let (sent, shown) = (reachable(&schemas, bodies), reachable(&schemas, rest));
    let has_fields = |name: &String| {
        let inner = reachable(&schemas, vec![&schemas[name]]);
        std::iter::once(name).chain(&inner).any(|name| says(&schemas[name], "properties"))
    };
    let closed: BTreeSet<String> = sent.into_iter().filter(has_fields).collect();
    let twice: BTreeSet<String> = closed.intersection(&shown).cloned().collect();
    let Some(components) = &mut document.components else { return };
    for name in &closed {
        let Some(mut schema) = components.schemas.get(name).cloned() else { continue };
        shut(&mut schema, &twice);
        let name = if twice.contains(name) { format!("{name}{SUFFIX}") } else { name.clone() };
        components.schemas.insert(name, schema);
    }
    for item in document.paths.paths.values_mut() {
        [&mut item.put, &mut item.post].into_iter().flatten().for_each(|it| lead(it, &twice));
    }
}

fn fields(value: &Value) -> impl Iterator<Item = (&String, &Value)> {
    value.as_object().into_iter().flatten()
}

/// Leads the body of an operation to the closed form of its schema.
fn lead(operation: &mut Operation, twice: &BTreeSet<String>) {
    let Some(RefOr::T(body)) = &mut operation.request_body else { return };
    let bodies = body.content.values_mut();
    for content in bodies {
        if let RefOr::T(Content { schema: Some(schema), .. }) = content {
            shut(schema, twice);
        }
    }
}

/// Allows no fields beside those that a schema names; what it refers to is the closed form of that.
fn shut(schema: &mut RefOr<Schema>, twice: &BTreeSet<String>) {
    let schema = match schema {
        RefOr::Ref(reference) => return point(&mut reference.ref_location, twice),
        RefOr::T(schema) => schema,
    };
    match schema {
        Schema::Object(object) => {
            if object.schema_type == SchemaType::Type(Type::Object) {
                let nothing = AdditionalProperties::FreeForm(false);
                object.additional_properties = Some(Box::new(nothing));
            }
            object.properties.values_mut().for_each(|inner| shut(inner, twice));
        }
        Schema::Array(array) => {
            if let ArrayItems::RefOrSchema(items) = &mut array.items {
                shut(items, twice);
            }
        }
        Schema::OneOf(one_of) => {
            one_of.items.iter_mut().for_each(|inner| shut(inner, twice));
            let kinds = one_of.discriminator.iter_mut().flat_map(|it| it.mapping.values_mut());
            kinds.for_each(|target| point(target, twice));
        }
        Schema::AllOf(all_of) => all_of.items.iter_mut().for_each(|inner| shut(inner, twice)),
        Schema::AnyOf(any_of) => any_of.items.iter_mut().for_each(|inner| shut(inner, twice)),
        _ => {}
    }
}

/// Points to the closed form of a schema where there are two.
fn point(target: &mut String, twice: &BTreeSet<String>) {
    if target.strip_prefix(PREFIX).is_some_and(|name| twice.contains(name)) {
        target.push_str(SUFFIX);
    }
}

/// The names of all schemas that `from` refers to, directly or not.
fn reachable<'a>(schemas: &'a Map<String, Value>, mut open: Vec<&'a Value>) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    while let Some(value) = open.pop() {
        match value {
            Value::Object(fields) => {
                let target = fields.get("$ref").and_then(Value::as_str);
                let name = target.and_then(|target| target.strip_prefix(PREFIX));
                if let Some(name) = name.filter(|name| found.insert((*name).to_owned())) {
                    open.extend(schemas.get(name));
                }
                open.extend(fields.values());
            }
            Value::Array(items) => open.extend(items),
            _ => {}
        }
    }
    found
}

/// Whether a keyword stands somewhere in a schema itself.
fn says(schema: &Value, keyword: &str) -> bool {
    match schema {
        Value::Object(fields) => {
            fields.contains_key(keyword) || fields.values().any(|inner| says(inner, keyword))
        }
        Value::Array(items) => items.iter().any(|inner| says(inner, keyword)),
        _ => false,
    }
}
