//! What the caller gives: files, standard input, values of flags.

use super::failure::Failure;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use umwelt_api::task::Waypoint;

/// Longest file: a task of 1000 waypoints has 50 KB; a device that never ends is no task.
const MAX_FILE: u64 = 1 << 20;

/// The name of standard input in place of a file.
const STANDARD_INPUT: &str = "-";

/// Reads a whole file, or standard input for `-`.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let name = name(path);
    let wrong = |error: &io::Error| Failure::Wrong(format!("cannot read {name}: {error}"));
    let mut bytes = Vec::new();
    let read = if is_standard(path) {
        io::stdin().lock().take(MAX_FILE + 1).read_to_end(&mut bytes)
    } else {
        File::open(path).and_then(|file| file.take(MAX_FILE + 1).read_to_end(&mut bytes))
    };
    read.map_err(|error| wrong(&error))?;
    if bytes.len() as u64 > MAX_FILE {
        return Err(Failure::Wrong(format!("{name} is longer than {} KiB", MAX_FILE >> 10)));
    }
    Ok(bytes)
}

/// A body in JSON without the fields that are the server's to say: what `show` prints can be put again.
pub(super) fn without(json: Vec<u8>, given_by_server: &[&str]) -> Vec<u8> {
    let Ok(Value::Object(mut fields)) = serde_json::from_slice(&json) else {
        // Reading it says what is wrong with it.
        return json;
    };
    fields.retain(|name, _| !given_by_server.contains(&name.as_str()));
    Value::Object(fields).to_string().into_bytes()
}

/// Whether it stands for standard input.
pub(super) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == STANDARD_INPUT
}

/// What to call a file in messages.
pub(super) fn name(path: &Path) -> String {
    if is_standard(path) { "standard input".to_owned() } else { path.display().to_string() }
}

/// Reads a place, as `0.2,-0.1`.
pub(super) fn waypoint(text: &str) -> Result<Waypoint, String> {
    let number = |text: &str| {
        let value = text.trim().parse::<f64>().ok()?;
        value.is_finite().then_some(value)
    };
    let pair = text.split_once(',').and_then(|(x, y)| Some((number(x)?, number(y)?)));
    let (x_m, y_m) = pair.ok_or("use X,Y in metres, as 0.2,-0.1")?;
    Ok(Waypoint { x_m, y_m })
}

/// Reads one of the names that a wire type has.
pub(super) fn named<T>(names: &'static [&'static str]) -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(|name| serde_json::from_value(Value::String(name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waypoints_are_two_numbers() {
        for (text, x_m, y_m) in
            [("0.2,-0.1", 0.2, -0.1), ("-1, 2", -1.0, 2.0), ("-.5,1e-1", -0.5, 0.1)]
        {
            assert_eq!(waypoint(text), Ok(Waypoint { x_m, y_m }));
        }
        for text in ["", "1", "1;2", "1,2,3", "a,b", "1,", "nan,0", "0,inf"] {
            assert!(waypoint(text).unwrap_err().contains("as 0.2,-0.1"), "{text}");
        }
    }

    #[test]
    fn only_what_the_server_says_is_left_out() {
        let json =
            br#"{"etag": "1", "note": "x", "prior": {"etag": 0.30000000000000004}}"#.to_vec();
        let left: Value = serde_json::from_slice(&without(json, &["etag"])).unwrap();
        assert_eq!(left, serde_json::json!({"note": "x", "prior": {"etag": 0.30000000000000004}}));
        assert_eq!(without(b"nonsense".to_vec(), &["etag"]), b"nonsense");
    }

    #[test]
    fn an_endless_file_is_refused() {
        let Err(Failure::Wrong(text)) = read(Path::new("/dev/zero")) else { panic!("it is wrong") };
        assert_eq!(text, "/dev/zero is longer than 1024 KiB");
    }
}
