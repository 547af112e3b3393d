//! `openapi.json` is what the code says, and hangs together: utoipa drops and overwrites things silently.

use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/openapi.json");

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
    assert!(golden == now, "openapi.json is stale: UPDATE_GOLDEN=1 cargo test -p umwelt-api");
}

#[test]
fn it_is_openapi_3_1() {
    assert_eq!(document()["openapi"], "3.1.0");
}

#[test]
fn it_has_the_routes_of_the_architecture() {
    let document = document();
    let routes: BTreeSet<_> =
        operations(&document).iter().map(|(path, method, _)| format!("{method} {path}")).collect();
    let expected = [
        "put /v1/robots/{robot}",
        "get /v1/robots/{robot}",
        "delete /v1/robots/{robot}",
        "get /v1/robots",
        "put /v1/robots/{robot}/task",
        "get /v1/robots/{robot}/task",
        "delete /v1/robots/{robot}/task",
        "post /v1/robots/{robot}/step",
        "get /v1/robots/{robot}/environment",
        "post /v1/robots/{robot}/environment/reset",
        "post /v1/robots/{robot}/stop",
        "post /v1/robots/{robot}/resume",
        "post /v1/stop",
        "post /v1/resume",
        "put /v1/priors/{prior}",
        "get /v1/priors/{prior}",
        "delete /v1/priors/{prior}",
        "get /v1/priors",
        "put /v1/environments/{environment}",
        "get /v1/environments/{environment}",
        "delete /v1/environments/{environment}",
        "get /v1/environments",
        "post /v1/evolutions",
        "get /v1/evolutions/{evolution}",
        "delete /v1/evolutions/{evolution}",
        "get /v1/evolutions",
        "post /v1/evolutions/{evolution}/cancel",
        "get /v1/evolutions/{evolution}/generations",
        "get /v1/evolutions/{evolution}/events",
        "get /v1/evolutions/{evolution}/figures/{figure}",
        "post /v1/comparisons",
        "get /v1/comparisons/{comparison}",
        "delete /v1/comparisons/{comparison}",
        "get /v1/comparisons",
        "post /v1/comparisons/{comparison}/cancel",
        "get /v1/comparisons/{comparison}/events",
        "get /v1/comparisons/{comparison}/figures/{figure}",
        "get /v1/comparisons/{comparison}/trials.csv",
        "get /v1/comparisons/{comparison}/report.md",
        "get /v1/robots/{robot}/events",
        "get /v1/events",
        "get /healthz",
        "get /readyz",
        "get /openapi.json",
    ];
    assert_eq!(routes, expected.into_iter().map(String::from).collect());
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
            matches!((method, path), ("put", _) | ("post", "/v1/evolutions" | "/v1/comparisons")),
            operation["requestBody"].is_object() && !path.ends_with("/step"),
            "{at}: body"
        );
        let responses = operation["responses"].as_object().unwrap();
        assert!(responses.keys().any(|code| code.starts_with('2')), "{at}: no success");
        assert!(responses.contains_key("default"), "{at}: no error");
        // What has not changed (304) is no error.
        let is_error = |code: &str| !code.starts_with('2') && code != "304";
        for (code, response) in responses.iter().filter(|(code, _)| is_error(code)) {
            let schema = &response["content"]["application/json"]["schema"]["$ref"];
            assert_eq!(schema, "#/components/schemas/problem.ErrorBody", "{at}: {code}");
        }
    }
}

/// Two types of one name would overwrite each other, so each names its module; as many schemas as derives.
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
    sources(concat!(env!("CARGO_MANIFEST_DIR"), "/src").as_ref(), &mut text);
    let derives = text
        .lines()
        .filter(|line| line.starts_with("#[derive(") && line.contains("ToSchema"))
        .count();
    let document = document();
    let schemas = object(&document, "/components/schemas");
    // Of those that go both ways there is a closed one for requests.
    let is_closed =
        |name: &str| name.strip_suffix("Request").is_some_and(|open| schemas.contains_key(open));
    let schemas: Map<String, Value> = schemas
        .iter()
        .filter(|(name, _)| !is_closed(name))
        .map(|(n, s)| (n.clone(), s.clone()))
        .collect();
    // Of each kind of job three more are put together by hand: job, page and event; its outcome is a part of the job's.
    let kinds = text.matches("impl JobKind for").count();
    assert_eq!(schemas.len(), derives + 2 * kinds, "{:?}", schemas.keys());
    let rust_only = ["RobotId", "PriorId", "EnvironmentId", "EvolutionId", "ComparisonId"];
    for name in schemas.keys().filter(|name| !rust_only.contains(&name.as_str())) {
        assert!(
            name.contains('.'),
            "{name} does not name its module: #[schema(as = module::Name)]"
        );
    }
}

/// Every property of a number that the server takes in says its limits, and every field is described.
#[test]
fn numbers_have_limits_and_fields_have_words() {
    let document = document();
    let incoming = [
        "robot.Drive",
        "robot.Noise",
        "robot.Spec",
        "robot.VarianceLimits",
        "robot.Steering",
        "robot.ChannelPrior",
        "task.Waypoint",
        "task.Calibration",
        "step.Request",
        "step.Observation",
        "step.Delivery",
        "step.Playing",
        "step.Horizon",
        "step.WheelSpeeds",
        "prior.Spec",
        "training.Spec",
        "training.SlipChannel",
        "training.LinkModel",
        "training.LatePackets",
        "training.Outage",
        "training.Silences",
        "training.TraceRow",
        "evolution.Request",
        "comparison.Request",
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
            let derived = (name, field.as_str()) == ("step.Horizon", "valid_until_s");
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
