//! The page: a section per request body, a table per object in it.

use super::effects::effect;
use super::unit::unit;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use umwelt_api::robot::{DERIVED, IDENTIFIED};

const FRONT: &str = "# Parameters\n\n\
    Every field of every body that the server accepts. Generated from `openapi/openapi.json` by \
    `UPDATE_GOLDEN=1 cargo test -p umwelt-contract --test parameters`: do not edit it here.\n\n\
    A field that is not required may be left out; it then has its default. One that is \"identified\" comes from \
    motion, `method.md` says from which value on. A default that is \"derived\" follows from the \
    other fields of the robot (`docs/method.md` has the formulas); what it is for the robot of the thesis stands beside it. \
    `PATCH /v1/robots/{robot}` has the fields of PUT, null for each that is to be default again. \"null\" as a default means that the field is \
    not set, and the meaning says what counts then. Lengths are in m, angles in rad, times in s; a slot is 30 ms. The range \
    includes both ends. A contradiction between fields is answered with 409, a value outside its range with 400; both name \
    the field, the value and a remedy.\n";

/// The operation whose fields may follow from each other.
const ROBOT: &str = "PUT /v1/robots/{robot}";

/// A request body.
pub struct Body<'a> {
    /// Method and path of its operation.
    pub operation: String,
    /// What the operation does.
    summary: &'a str,
    schema: &'a Value,
}

/// The bodies of all operations that have one, those of robots first.
pub fn bodies(document: &Value) -> Vec<Body<'_>> {
    let paths = document["paths"].as_object().expect("paths");
    let mut bodies: Vec<_> = paths
        .iter()
        .flat_map(|(path, item)| {
            let item = item.as_object().expect("an item is an object");
            item.iter().map(move |(method, operation)| (path, method, operation))
        })
        .filter_map(|(path, method, operation)| {
            // A patch has the fields of what it changes, and null for each.
            let is_whole = method != "patch";
            let schema = operation.pointer("/requestBody/content/application~1json/schema");
            let schema = schema.filter(|_| is_whole)?;
            let summary = operation["summary"].as_str().unwrap_or_default();
            let operation = format!("{} {path}", method.to_uppercase());
            Some((!path.starts_with("/v1/robots"), path, Body { operation, summary, schema }))
        })
        .collect();
    bodies.sort_by_key(|(after_robots, path, _)| (*after_robots, *path));
    bodies.into_iter().map(|(_, _, body)| body).collect()
}

/// The whole page.
pub fn page(document: &Value) -> String {
    let mut page = Page { document, text: FRONT.to_owned(), described: BTreeMap::new() };
    for body in bodies(document) {
        page.section(&body);
    }
    page.text
}

/// The fields of the body of `operation` by their paths.
pub fn fields(document: &Value, operation: &str) -> BTreeSet<String> {
    let page = Page { document, text: String::new(), described: BTreeMap::new() };
    let mut found = BTreeSet::new();
    for body in bodies(document).iter().filter(|body| body.operation == operation) {
        let mut open = page.objects(body.schema, "");
        while let Some(Object { at, properties, .. }) = open.pop() {
            for (name, property) in properties {
                let path = join(&at, name);
                open.extend(page.objects(property, &path));
                found.insert(path);
            }
        }
    }
    found
}

/// Fields of a default that are written out in one cell.
const MOST_IN_A_CELL: usize = 4;

struct Page<'a> {
    document: &'a Value,
    text: String,
    /// Where the table of a schema stands: the heading of its section and its path.
    described: BTreeMap<String, String>,
}

/// An object in a body.
struct Object<'a> {
    /// Path of the field that has it; empty for the body itself.
    at: String,
    /// Its name among schemas; none where it is written out in place.
    reference: Option<String>,
    /// In words, and which variant it is where there are several.
    about: String,
    properties: &'a Map<String, Value>,
    required: BTreeSet<&'a str>,
}

impl<'a> Page<'a> {
    fn section(&mut self, body: &Body<'a>) {
        self.text.push_str(&format!("\n## `{}`\n\n{}.\n", body.operation, body.summary));
        let mut open = self.objects(body.schema, "");
        open.reverse();
        while let Some(object) = open.pop() {
            let mut inner = self.table(&body.operation, &object);
            inner.reverse();
            open.append(&mut inner);
        }
    }

    /// Writes the table of one object; the objects in it.
    fn table(&mut self, operation: &str, object: &Object<'a>) -> Vec<Object<'a>> {
        let Object { at, about, properties, required, reference } = object;
        if !at.is_empty() {
            writeln!(self.text, "\n### `{at}`").expect("a string");
        }
        if let Some(earlier) = reference.as_ref().and_then(|name| self.described.get(name)) {
            writeln!(self.text, "\n{about} Fields as in {earlier}.").expect("a string");
            return Vec::new();
        }
        if let Some(name) = reference {
            let place = if at.is_empty() { operation } else { at };
            self.described.insert(name.clone(), format!("`{place}`"));
        }
        self.text.push_str(&format!("\n{about}\n\n"));
        self.text.push_str(
            "| field | unit | default | range | meaning | effect |\n|---|---|---|---|---|---|\n",
        );
        let mut inner = Vec::new();
        for (name, property) in *properties {
            let path = join(at, name);
            let objects = self.objects(property, &path);
            let default =
                self.default(property, required.contains(name.as_str()), !objects.is_empty());
            let is_derived = operation == ROBOT && DERIVED.contains(&path.as_str());
            let default = match IDENTIFIED.contains(&path.as_str()) {
                true if operation == ROBOT => "identified".to_owned(),
                _ if is_derived => format!("derived ({default})"),
                _ => default,
            };
            let (range, meaning) = (self.range(property), self.meaning(property));
            let effect = effect(operation, &path);
            let row = [&format!("`{name}`"), unit(name), &default, &range, &meaning, effect];
            let row = row.map(|cell| cell.replace('|', "\\|").replace('\n', " "));
            writeln!(self.text, "| {} |", row.join(" | ")).expect("a string");
            inner.extend(objects);
        }
        inner
    }

    /// The schema that `value` is or refers to, with the name by which it is referred to.
    fn resolve(&self, value: &'a Value) -> (&'a Value, Option<String>) {
        match value["$ref"].as_str() {
            None => (value, None),
            Some(target) => {
                let at = target.strip_prefix('#').expect("a reference within the document");
                let schema = self.document.pointer(at).expect("a reference that leads somewhere");
                (schema, Some(target.to_owned()))
            }
        }
    }

    /// What a value may be: itself, or one of several; null is left out.
    fn variants(&self, value: &'a Value) -> Vec<(&'a Value, Option<String>)> {
        let (schema, name) = self.resolve(value);
        let several = ["oneOf", "anyOf"].iter().find_map(|key| schema[*key].as_array());
        match several {
            None => vec![(schema, name)],
            Some(variants) => variants
                .iter()
                .filter(|variant| variant["type"] != "null")
                .flat_map(|variant| self.variants(variant))
                .collect(),
        }
    }

    /// The objects that `value`, the field `at`, may be or hold.
    fn objects(&self, value: &'a Value, at: &str) -> Vec<Object<'a>> {
        let mut found = Vec::new();
        for (schema, reference) in self.variants(value) {
            if let Some(properties) = schema["properties"].as_object() {
                let required = schema["required"].as_array().into_iter().flatten();
                let kind = properties.get("kind").and_then(|kind| kind["enum"][0].as_str());
                let at = kind.map_or_else(|| at.to_owned(), |kind| format!("{at} ({kind})"));
                found.push(Object {
                    at,
                    reference,
                    about: schema["description"].as_str().unwrap_or_default().replace('\n', " "),
                    properties,
                    required: required.filter_map(Value::as_str).collect(),
                });
            } else if !schema["items"].is_null() {
                found.extend(self.objects(&schema["items"], &format!("{at}[]")));
            }
        }
        found
    }

    fn default(&self, property: &Value, required: bool, is_object: bool) -> String {
        match &property["default"] {
            _ if required => "required".to_owned(),
            Value::Object(fields) => {
                let is_below =
                    fields.len() > MOST_IN_A_CELL || fields.values().any(Value::is_object);
                if is_below { "below".to_owned() } else { plain(fields) }
            }
            Value::Null if property.get("default").is_some() => "null".to_owned(),
            Value::Null if is_object => "none".to_owned(),
            Value::Null => "not set".to_owned(),
            Value::Number(value) => number(&Value::Number(value.clone())),
            Value::String(name) => format!("`{name}`"),
            value => format!("`{value}`"),
        }
    }

    fn range(&self, property: &'a Value) -> String {
        let mut parts = Vec::new();
        for (schema, _) in self.variants(property) {
            if let (Some(low), Some(high)) = (schema.get("minimum"), schema.get("maximum")) {
                let is_whole = schema["type"].to_string().contains("integer");
                let whole = if is_whole { ", whole" } else { "" };
                parts.push(format!("{} to {}{whole}", number(low), number(high)));
            } else if let Some(names) = schema["enum"].as_array() {
                // A name with a number of slots is one of the names without.
                let names: Vec<_> = names.iter().filter_map(Value::as_str).collect();
                let is_slots = |name: &str| name.split_once('/').is_some();
                let names: Vec<_> = names.into_iter().filter(|name| !is_slots(name)).collect();
                parts.push(names.iter().map(|it| format!("`{it}`")).collect::<Vec<_>>().join(", "));
            } else if let Some(most) = schema.get("maxItems") {
                let least = schema["minItems"].as_u64().unwrap_or_default();
                let kind = self.range(&schema["items"]);
                let kind = if kind.is_empty() { kind } else { format!(", each {kind}") };
                parts.push(format!("{least} to {} entries{kind}", number(most)));
            } else if let Some(most) = schema.get("maxLength") {
                parts.push(format!("up to {} characters", number(most)));
            } else if schema.get("pattern").is_some() {
                parts.push("a name".to_owned());
            } else if schema["properties"].is_object() {
                parts.push("an object".to_owned());
            } else if schema["type"] == "boolean" {
                parts.push("`true`, `false`".to_owned());
            }
        }
        parts.dedup();
        parts.join(", or ")
    }

    fn meaning(&self, property: &'a Value) -> String {
        let own = [&property["description"], &property["oneOf"][0]["description"]];
        let own = own.into_iter().find_map(Value::as_str);
        let text = own.or_else(|| self.resolve(property).0["description"].as_str());
        let is_kind = property["enum"].as_array().is_some_and(|names| names.len() == 1);
        text.unwrap_or(if is_kind { "Which variant it is." } else { "" }).to_owned()
    }
}

/// An object as a default, in one cell.
fn plain(fields: &Map<String, Value>) -> String {
    let fields = fields.iter().map(|(name, value)| {
        let value = value.as_str().map_or_else(|| number(value), |name| format!("`{name}`"));
        format!("`{name}` {value}")
    });
    fields.collect::<Vec<_>>().join(", ")
}

fn join(at: &str, name: &str) -> String {
    if at.is_empty() { name.to_owned() } else { format!("{at}.{name}") }
}

/// A limit as people write it.
fn number(value: &Value) -> String {
    match value.as_f64() {
        Some(it) if it.abs() == 9_007_199_254_740_991.0 => {
            if it < 0.0 {
                "-(2^53 - 1)".to_owned()
            } else {
                "2^53 - 1".to_owned()
            }
        }
        Some(it) if (it - std::f64::consts::PI).abs() < 1e-12 => "π".to_owned(),
        Some(it) if it != 0.0 && (it.abs() >= 1e6 || it.abs() < 1e-4) => format!("{it:e}"),
        Some(it) if it.fract() != 0.0 => {
            let short = format!("{it:.4}");
            short.trim_end_matches('0').to_owned()
        }
        Some(it) => format!("{it}"),
        None => value.to_string(),
    }
}
