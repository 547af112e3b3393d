//! `openapi.json` is what the code says, and hangs together: utoipa drops and overwrites things silently.

use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../openapi.json");

fn document() -> Value {
    serde_json::to_value(umwelt_api::document()).expect("it is JSON")
}

fn object<'a>(value: &'a Value, pointer: &str) -> &'a Map<String, Value> {
    value.pointer(pointer).and_then(Value::as_object).unwrap_or_else(|| panic!("no {pointer}"))
}

/// `(path, method, operation)` of every operation.
fn operations(document: &Value) -> Vec<(&str, &str, &Value)> {
    let paths = object(document, "/paths").iter();
    paths
        .flat_map(|(path, item)| {
            let item = item.as_object().expect("an item is an object").iter();
            item.map(|(method, operation)| (path.as_str(), method.as_str(), operation))
        })
        .collect()
}

fn references(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                match value.as_str() {
                    Some(target) if name == "$ref" => drop(found.insert(target.to_owned())),
                    _ => references(value, found),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| references(item, found)),
        _ => {}
    }
}

#[test]
fn the_golden_file_is_what_the_code_says() {
    let now = umwelt_api::document().to_pretty_json().unwrap() + "\n";
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(GOLDEN, &now).unwrap();
    }
    let golden = std::fs::read_to_string(GOLDEN).unwrap_or_default();
    assert!(golden == now, "openapi.json is stale: UPDATE_GOLDEN=1 cargo test -p umwelt-contract");
}

#[test]
fn it_is_openapi_3_1() {
    assert_eq!(document()["openapi"], "3.1.0");
}

#[test]
fn every_reference_resolves_and_no_schema_is_an_orphan() {
    let document = document();
    let mut targets = BTreeSet::new();
    references(&document, &mut targets);
    for target in &targets {
        let pointer = target.strip_prefix('#').unwrap_or_else(|| panic!("{target} is not local"));
        assert!(document.pointer(pointer).is_some(), "{target} leads nowhere");
    }
    // Reachable from the operations, not merely from another orphan.
    let mut reached = BTreeSet::new();
    references(&document["paths"], &mut reached);
    let mut open: Vec<_> = reached.iter().cloned().collect();
    while let Some(target) = open.pop() {
        let mut next = BTreeSet::new();
        references(document.pointer(&target[1..]).unwrap(), &mut next);
        open.extend(next.into_iter().filter(|target| reached.insert(target.clone())));
    }
    for name in object(&document, "/components/schemas").keys() {
        assert!(reached.contains(&format!("#/components/schemas/{name}")), "{name} is an orphan");
    }
}

#[test]
fn path_templates_and_path_parameters_agree() {
    let document = document();
    for (path, method, operation) in operations(&document) {
        let template: BTreeSet<_> =
            path.split('/').filter_map(|part| part.strip_prefix('{')?.strip_suffix('}')).collect();
        let parameters = operation["parameters"].as_array().into_iter().flatten();
        let declared: BTreeSet<_> = parameters
            .filter(|parameter| parameter["in"] == "path")
            .inspect(|parameter| assert_eq!(parameter["required"], true, "{method} {path}"))
            .inspect(|parameter| assert!(!parameter["schema"].is_null(), "{method} {path}"))
            .filter_map(|parameter| parameter["name"].as_str())
            .collect();
        assert_eq!(template, declared, "{method} {path}");
    }
}

#[test]
fn every_operation_says_what_it_is_and_how_it_fails() {
    let document = document();
    let tags: BTreeSet<_> = document["tags"]
        .as_array()
        .unwrap()
        .iter()
        .map(|tag| &tag["name"])
        .map(Value::to_string)
        .collect();
    let mut ids = BTreeMap::new();
    for (path, method, operation) in operations(&document) {
        let at = format!("{method} {path}");
        let id =
            operation["operationId"].as_str().unwrap_or_else(|| panic!("{at}: no operationId"));
        assert_eq!(ids.insert(id, at.clone()), None, "{at}: operationId {id} is taken");
        assert!(operation["summary"].as_str().is_some_and(|summary| !summary.is_empty()), "{at}");
        let own = operation["tags"].as_array().into_iter().flatten().map(Value::to_string);
        assert!(
            own.clone().count() == 1 && own.clone().all(|tag| tags.contains(&tag)),
            "{at}: tags"
        );
        assert_eq!(
            matches!(
                (method, path),
                ("put" | "patch", _) | ("post", "/v1/evolutions" | "/v1/comparisons")
            ),
            operation["requestBody"].is_object() && !path.ends_with("/step"),
            "{at}: body"
        );
        let responses = operation["responses"].as_object().unwrap();
        assert!(responses.keys().any(|code| code.starts_with('2')), "{at}: no success");
        assert!(responses.contains_key("default"), "{at}: no error");
        // What has not changed (304) is no error.
        let is_error = |code: &str| !code.starts_with('2') && code != "304";
        for (code, response) in responses.iter().filter(|(code, _)| is_error(code)) {
            let shared = response["$ref"].as_str().and_then(|target| target.strip_prefix('#'));
            let response = shared.and_then(|target| document.pointer(target));
            let content = &response.unwrap_or_else(|| panic!("{at}: {code}"))["content"];
            let schema = &content["application/json"]["schema"]["$ref"];
            assert_eq!(schema, "#/components/schemas/ErrorBody", "{at}: {code}");
        }
    }
}

/// Two types of one name would overwrite each other: as many names as types, and every kind of what comes in kinds, the
/// closed forms for requests aside.
#[test]
fn no_schema_overwrites_another() {
    fn sources(directory: &std::path::Path, text: &mut String) {
        for entry in std::fs::read_dir(directory).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                sources(&path, text);
            } else {
                text.push_str(&std::fs::read_to_string(path).unwrap());
            }
        }
    }
    let mut text = String::new();
    sources(concat!(env!("CARGO_MANIFEST_DIR"), "/../src").as_ref(), &mut text);
    let named: Vec<_> = text
        .lines()
        .filter_map(|line| line.trim().strip_prefix("#[schema(as = ")?.strip_suffix(")]"))
        .collect();
    assert_eq!(named.iter().collect::<BTreeSet<_>>().len(), named.len(), "one name twice");
    let document = document();
    let schemas = object(&document, "/components/schemas");
    for (name, schema) in schemas {
        let kinds = schema["discriminator"]["mapping"].as_object();
        for target in kinds.into_iter().flat_map(Map::values).filter_map(Value::as_str) {
            assert!(!named.iter().any(|named| target.ends_with(&format!("/{named}"))), "{name}");
        }
        assert!(!name.contains('.'), "{name} is no name of a type in most languages");
    }
}

/// Every property of a number that the server takes in says its limits, and every field is described.
#[test]
fn numbers_have_limits_and_fields_have_words() {
    let document = document();
    let incoming = [
        "Drive",
        "Noise",
        "RobotSpec",
        "VarianceLimits",
        "Steering",
        "ChannelPrior",
        "Waypoint",
        "Calibration",
        "StepRequest",
        "Observation",
        "Delivery",
        "Playing",
        "Horizon",
        "WheelSpeeds",
        "PriorSpec",
        "TrainingSpec",
        "SlipChannel",
        "LinkModel",
        "LatePackets",
        "Outage",
        "Silences",
        "TraceRow",
        "EvolutionRequest",
        "ComparisonRequest",
    ];
    for name in incoming {
        for (field, property) in
            object(&document, &format!("/components/schemas/{name}/properties"))
        {
            let is = |kind: &str| {
                let kinds = property["type"].as_array().map(Vec::as_slice);
                kinds.unwrap_or(std::slice::from_ref(&property["type"])).contains(&kind.into())
            };
            // What the robot works out by itself is not checked.
            let derived = (name, field.as_str()) == ("Horizon", "valid_until_s");
            let numeric = !derived && (is("number") || is("integer"));
            let limited = !property["minimum"].is_null() && !property["maximum"].is_null();
            assert!(!numeric || limited, "{name}.{field}: {property}");
        }
    }
    for (name, schema) in object(&document, "/components/schemas") {
        let words = schema["description"].as_str();
        assert!(words.is_some_and(|words| !words.contains("```")), "{name}: {schema}");
        let properties = schema["properties"].as_object();
        for (field, property) in properties.into_iter().flatten() {
            let described = [property, &property["oneOf"][0]];
            let described = described.iter().any(|part| part["description"].is_string());
            assert!(described, "{name}.{field}: {property}");
        }
    }
}
