//! What comes in kinds is said so that makers of clients understand it: each kind is a schema with a name, all its fields
//! in one place, and a discriminator tells them apart.

use crate::endpoint::Schemas;
use serde_json::Value;
use utoipa::openapi::schema::{
    Discriminator, Object, ObjectBuilder, OneOfBuilder, Schema, SchemaType, Type,
};
use utoipa::openapi::{Ref, RefOr};

/// Gives the kinds of every type that has them names.
pub(super) fn name(schemas: &mut Schemas) {
    let (mut found, mut within) = (Schemas::new(), Vec::new());
    for (name, schema) in schemas.iter() {
        let RefOr::T(schema) = schema else { continue };
        if let Some(parts) = kinds(schemas, schema, &mut within) {
            found.extend(named(name, schema, parts));
        }
    }
    // What was only ever a part of another schema.
    within.iter().for_each(|name| drop(schemas.remove(name)));
    within.iter().for_each(|name| found.retain(|of, _| !of.starts_with(name.as_str())));
    schemas.extend(found);
}

/// One kind: the field that tells, its value, and all fields.
struct Kind {
    field: String,
    value: String,
    object: Object,
}

/// The kinds of a schema that is one of several objects with a field that tells which. A schema that such a one is a part
/// of has its fields in each of them; the part is added to `within`.
fn kinds(schemas: &Schemas, schema: &Schema, within: &mut Vec<String>) -> Option<Vec<Kind>> {
    match schema {
        Schema::OneOf(one_of) => {
            one_of.items.iter().map(|item| kind(flat(schemas, item)?)).collect::<Option<Vec<_>>>()
        }
        Schema::AllOf(all_of) => {
            let (mut inner, mut own) = (None, ObjectBuilder::new().build());
            for item in &all_of.items {
                let tagged = match item {
                    RefOr::Ref(reference) => {
                        let name = target(reference);
                        match schemas.get(name) {
                            Some(RefOr::T(schema)) => {
                                kinds(schemas, schema, within).map(|found| (name, found))
                            }
                            _ => None,
                        }
                    }
                    RefOr::T(_) => None,
                };
                match tagged {
                    Some(found) => inner = Some(found),
                    None => merge(&mut own, flat(schemas, item)?),
                }
            }
            let (name, mut found) = inner?;
            within.push(name.to_owned());
            for kind in &mut found {
                let words = kind.object.description.take();
                let payload = std::mem::replace(&mut kind.object, own.clone());
                merge(&mut kind.object, payload);
                kind.object.description = words;
            }
            Some(found)
        }
        _ => None,
    }
}

/// All fields of an object, those of its parts among them.
fn flat(schemas: &Schemas, schema: &RefOr<Schema>) -> Option<Object> {
    match schema {
        RefOr::Ref(reference) => flat(schemas, schemas.get(target(reference))?),
        RefOr::T(Schema::Object(object))
            if object.schema_type == SchemaType::Type(Type::Object) =>
        {
            Some(object.clone())
        }
        RefOr::T(Schema::AllOf(all_of)) => {
            let mut whole = ObjectBuilder::new().build();
            for item in &all_of.items {
                merge(&mut whole, flat(schemas, item)?);
            }
            whole.description = all_of.description.clone();
            Some(whole)
        }
        RefOr::T(_) => None,
    }
}

fn merge(into: &mut Object, other: Object) {
    into.schema_type = SchemaType::Type(Type::Object);
    into.properties.extend(other.properties);
    let missing = other.required.into_iter().filter(|name| !into.required.contains(name));
    into.required.extend(missing.collect::<Vec<_>>());
}

/// The kind that an object is, by the one field with a single value.
fn kind(mut object: Object) -> Option<Kind> {
    let (field, value) = object.properties.iter_mut().find_map(|(field, schema)| {
        let RefOr::T(Schema::Object(property)) = schema else { return None };
        let Some([Value::String(value)]) = property.enum_values.as_deref() else { return None };
        property.description = Some("Which kind it is".to_owned());
        Some((field.clone(), value.clone()))
    })?;
    Some(Kind { field, value, object })
}

/// The schema `name` as one of its kinds, and these.
fn named(name: &str, schema: &Schema, kinds: Vec<Kind>) -> Schemas {
    let mut discriminator = Discriminator::new("");
    let mut one_of = OneOfBuilder::new().description(description(schema));
    let mut found = Schemas::new();
    for Kind { field, value, object } in kinds {
        let of = format!("{name}{}", pascal(&value));
        let reference = Ref::from_schema_name(&of);
        discriminator.property_name = field;
        discriminator.mapping.insert(value, reference.ref_location.clone());
        one_of = one_of.item(reference);
        found.insert(of, Schema::Object(object).into());
    }
    let one_of = one_of.discriminator(Some(discriminator)).build();
    found.insert(name.to_owned(), Schema::OneOf(one_of).into());
    found
}

fn description(schema: &Schema) -> Option<String> {
    match schema {
        Schema::OneOf(one_of) => one_of.description.clone(),
        Schema::AllOf(all_of) => all_of.description.clone(),
        _ => None,
    }
}

/// `pose_set_aside` and `built-in` as `PoseSetAside` and `BuiltIn`.
fn pascal(value: &str) -> String {
    let words = value.split(['_', '-']).filter_map(|word| {
        let mut letters = word.chars();
        letters.next().map(|first| first.to_uppercase().chain(letters).collect::<String>())
    });
    words.collect()
}

fn target(reference: &Ref) -> &str {
    reference.ref_location.rsplit('/').next().unwrap_or_default()
}
