//! The schemas of request bodies and the checks of the server say the same: what a schema allows is never answered with
//! 400, and what it does not allow always is. Bodies are drawn from `openapi.json` and then spoiled, with a fixed seed.

use serde_json::{Map, Value, json};
use umwelt_api::{Problems, prior, robot, step, task, training};
use umwelt_lab::wire;

/// Bodies of each kind.
const CASES: usize = 1500;

/// SplitMix64: nothing depends on it but which cases are drawn.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn pick<'a, T>(&mut self, items: &'a [T]) -> &'a T {
        &items[self.below(items.len())]
    }
}

struct Contract(Value);

impl Contract {
    fn resolved<'a>(&'a self, schema: &'a Value) -> &'a Value {
        match schema["$ref"].as_str() {
            Some(target) => self.resolved(self.0.pointer(&target[1..]).expect(target)),
            None => schema,
        }
    }

    fn body(&self, path: &str, method: &str) -> &Value {
        let content = &self.0["paths"][path][method]["requestBody"]["content"]["application/json"];
        self.resolved(&content["schema"])
    }

    fn draw(&self, schema: &Value, draws: &mut Draws) -> Value {
        let schema = self.resolved(schema);
        if let Some(values) = schema["enum"].as_array() {
            return draws.pick(values).clone();
        }
        for choice in ["oneOf", "anyOf"] {
            if let Some(choices) = schema[choice].as_array() {
                return self.draw(draws.pick(choices), draws);
            }
        }
        if let Some(parts) = schema["allOf"].as_array() {
            let mut whole = Map::new();
            for part in parts {
                whole.extend(self.draw(part, draws).as_object().cloned().unwrap_or_default());
            }
            return whole.into();
        }
        match *draws.pick(&kinds(schema)) {
            "null" => Value::Null,
            "boolean" => draws.one_in(2).into(),
            "string" => text(schema, draws),
            "integer" => integer(schema, draws),
            "number" => number(schema, draws),
            "array" => {
                let least = schema["minItems"].as_u64().unwrap_or(0) as usize;
                let most = schema["maxItems"].as_u64().unwrap_or(5) as usize;
                let count = (least + draws.below(3)).min(most);
                let mut items: Vec<Value> =
                    (0..count).map(|_| self.draw(&schema["items"], draws)).collect();
                if schema["uniqueItems"] == true {
                    let mut seen = Vec::new();
                    items.retain(|item| {
                        !seen.contains(item) && {
                            seen.push(item.clone());
                            true
                        }
                    });
                }
                items.into()
            }
            "object" => {
                let mut fields = Map::new();
                for (name, property) in schema["properties"].as_object().into_iter().flatten() {
                    if required(schema, name) || draws.one_in(2) {
                        fields.insert(name.clone(), self.draw(property, draws));
                    }
                }
                fields.into()
            }
            other => panic!("{other} is not drawn"),
        }
    }

    fn allows(&self, schema: &Value, value: &Value) -> bool {
        let schema = self.resolved(schema);
        let any = |choices: &Value| {
            choices.as_array().is_none_or(|it| it.iter().any(|it| self.allows(it, value)))
        };
        let all = |parts: &Value| {
            parts.as_array().is_none_or(|it| it.iter().all(|it| self.allows(it, value)))
        };
        if !(any(&schema["oneOf"]) && any(&schema["anyOf"]) && all(&schema["allOf"])) {
            return false;
        }
        if schema["enum"].as_array().is_some_and(|known| !known.contains(value)) {
            return false;
        }
        if !schema["type"].is_null() && !kinds(schema).iter().any(|kind| is(kind, value)) {
            return false;
        }
        let within = |number: f64| {
            schema["minimum"].as_f64().is_none_or(|min| min <= number)
                && schema["maximum"].as_f64().is_none_or(|max| number <= max)
        };
        let counted = |count: usize, min: &str, max: &str| {
            schema[min].as_u64().is_none_or(|min| min as usize <= count)
                && schema[max].as_u64().is_none_or(|max| count <= max as usize)
        };
        match value {
            Value::Number(number) => within(number.as_f64().expect("a number")),
            Value::String(text) => {
                counted(text.chars().count(), "minLength", "maxLength")
                    && schema["pattern"].as_str().is_none_or(|pattern| matches(pattern, text))
            }
            Value::Array(items) => {
                let again = |(place, item): (usize, &Value)| items[..place].contains(item);
                counted(items.len(), "minItems", "maxItems")
                    && items.iter().all(|item| self.allows(&schema["items"], item))
                    && !(schema["uniqueItems"] == true && items.iter().enumerate().any(again))
            }
            Value::Object(fields) => {
                let known = schema["properties"].as_object().cloned().unwrap_or_default();
                let all_there =
                    known.keys().all(|name| fields.contains_key(name) || !required(schema, name));
                let is_open = schema["additionalProperties"] != false;
                let fits = |(name, value): (&String, &Value)| match known.get(name) {
                    Some(schema) => self.allows(schema, value),
                    None => is_open,
                };
                all_there && fields.iter().all(fits)
            }
            Value::Null | Value::Bool(_) => true,
        }
    }
}

fn kinds(schema: &Value) -> Vec<&str> {
    match &schema["type"] {
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).collect(),
        kind => vec![kind.as_str().unwrap_or_else(|| panic!("of no type: {schema}"))],
    }
}

fn is(kind: &str, value: &Value) -> bool {
    match kind {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        "number" => value.is_number(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("{other} is no type"),
    }
}

fn required(schema: &Value, name: &str) -> bool {
    schema["required"].as_array().is_some_and(|names| names.iter().any(|it| it == name))
}

const ID: &str = "^[A-Za-z0-9][A-Za-z0-9._-]{0,62}$";

/// The patterns that there are, each as a rule of its own.
fn matches(pattern: &str, text: &str) -> bool {
    if pattern == ID {
        let allowed = |it: char| it.is_ascii_alphanumeric() || "._-".contains(it);
        let begins = text.starts_with(|it: char| it.is_ascii_alphanumeric());
        (1..64).contains(&text.len()) && text.chars().all(allowed) && begins
    } else if pattern == umwelt_api::visible::PATTERN {
        umwelt_api::visible::first_hidden(text).is_none()
    } else {
        panic!("a pattern that this test does not know: {pattern}")
    }
}

fn text(schema: &Value, draws: &mut Draws) -> Value {
    let most = schema["maxLength"].as_u64().unwrap_or(63) as usize;
    let letters: Vec<char> = if schema["pattern"] == ID {
        "abz019".chars().collect()
    } else {
        "a Z9-_.ä床👩\u{a0}\u{feff}".chars().collect()
    };
    let least = if schema["pattern"] == ID { 1 } else { 0 };
    let length = if draws.one_in(8) { most } else { (least + draws.below(9)).min(most) };
    (0..length).map(|_| *draws.pick(&letters)).collect::<String>().into()
}

fn integer(schema: &Value, draws: &mut Draws) -> Value {
    let bound = |name: &str| schema[name].as_f64().unwrap_or_else(|| panic!("no {name}: {schema}"));
    let (min, max) = (bound("minimum"), bound("maximum"));
    let drawn = match draws.below(4) {
        0 => min,
        1 => max,
        2 => (min + draws.below(20) as f64).min(max),
        _ => (min + draws.unit() * (max - min)).floor(),
    };
    // As JSON writes it, and as programs do that know one kind of number alone.
    if draws.one_in(3) { json!(drawn) } else { json!(drawn as u64) }
}

fn number(schema: &Value, draws: &mut Draws) -> Value {
    let (min, max) = (schema["minimum"].as_f64(), schema["maximum"].as_f64());
    let (min, max) = (min.expect("a minimum"), max.expect("a maximum"));
    json!(match draws.below(5) {
        0 => min,
        1 => max,
        2 => min + 0.01 * draws.unit() * (max - min),
        _ => min + draws.unit() * (max - min),
    })
}

/// Every place of a value, as JSON pointers.
fn places(value: &Value, at: &str, found: &mut Vec<String>) {
    found.push(at.to_owned());
    for (name, value) in value.as_object().into_iter().flatten() {
        places(value, &format!("{at}/{name}"), found);
    }
    for (index, value) in value.as_array().into_iter().flatten().enumerate() {
        places(value, &format!("{at}/{index}"), found);
    }
}

/// Changes one thing about `body`, which may be allowed all the same.
fn spoil(body: &mut Value, draws: &mut Draws) {
    let mut found = Vec::new();
    places(body, "", &mut found);
    let place = body.pointer_mut(draws.pick::<String>(&found)).expect("it is there");
    *place = match (place.clone(), draws.below(6)) {
        (Value::Object(fields), 0 | 1) => fields.into_iter().map(|(_, value)| value).collect(),
        (Value::Object(mut fields), 2) => {
            fields.insert("surprise".to_owned(), 1.into());
            fields.into()
        }
        (Value::Object(mut fields), 3) if !fields.is_empty() => {
            let name = fields.keys().nth(draws.below(fields.len())).cloned().expect("one of them");
            fields.remove(&name);
            fields.into()
        }
        (Value::Array(mut items), 0..=2) if !items.is_empty() => {
            items.push(items[0].clone());
            items.into()
        }
        (Value::Number(number), 0..=2) => {
            let number = number.as_f64().expect("a number");
            json!([number + 0.5, -number - 1.0, 1e300, 1e15][draws.below(4)])
        }
        (Value::String(text), 0..=2) => {
            let hidden = ["\u{1b}", "\n", "\u{9b}", "\u{202e}", "-", "x"][draws.below(6)];
            json!([format!("{hidden}{text}"), text.repeat(300), "Ä ".to_owned()][draws.below(3)])
        }
        _ => draws
            .pick(&[
                json!(null),
                json!(true),
                json!("text"),
                json!(7),
                json!(0.5),
                json!([]),
                json!({}),
            ])
            .clone(),
    };
}

/// The answer to a body of this kind, as far as that depends on the body: 200, 400 or 409.
type Read = fn(&[u8]) -> Result<(), Problems>;

#[test]
fn what_the_schemas_allow_and_what_is_refused_as_bad_are_each_others_rest() {
    let document: Value = serde_json::from_str(umwelt_api::DOCUMENT).expect("it is JSON");
    let contract = Contract(document);
    let kinds: [(&str, &str, Read); 7] = [
        ("/v1/robots/{robot}", "put", |json| {
            robot::Description::read_known(json, prior::built_in).map(drop)
        }),
        ("/v1/robots/{robot}/task", "put", |json| task::Spec::read(json).map(drop)),
        ("/v1/robots/{robot}/step", "post", |json| step::Request::read(json).map(drop)),
        ("/v1/priors/{prior}", "put", |json| prior::Spec::read(json).map(drop)),
        ("/v1/environments/{environment}", "put", |json| training::Spec::read(json).map(drop)),
        ("/v1/evolutions", "post", |json| {
            wire::evolution::read(json, wire::training::built_in).map(drop)
        }),
        ("/v1/comparisons", "post", |json| wire::comparison::read(json, prior::built_in).map(drop)),
    ];
    for (path, method, read) in kinds {
        let schema = contract.body(path, method);
        let mut draws = Draws(7);
        let (mut taken, mut at_odds, mut bad) = (0, 0, 0);
        for case in 0..CASES {
            let mut body = contract.draw(schema, &mut draws);
            assert!(contract.allows(schema, &body), "{path}: drawn wrong: {body}");
            if case % 2 == 1 {
                spoil(&mut body, &mut draws);
            }
            let code = match read(body.to_string().as_bytes()) {
                Ok(()) => 200,
                Err(problems) => {
                    let allowed = contract.allows(schema, &body);
                    assert_eq!(
                        problems.http_status() == 409,
                        allowed,
                        "{path}: {problems}: {body}"
                    );
                    problems.http_status()
                }
            };
            assert!(code == 400 || contract.allows(schema, &body), "{path} took {body}");
            *match code {
                200 => &mut taken,
                409 => &mut at_odds,
                _ => &mut bad,
            } += 1;
        }
        // A test that draws only one kind of them shows nothing.
        assert!(bad > CASES / 6 && taken + at_odds > CASES / 2, "{path}: {taken} {at_odds} {bad}");
    }
}
