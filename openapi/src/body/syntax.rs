//! What is wrong with a text that is no JSON, in words that say what to do about it.

use serde_json::Value;

/// How deep lists and objects may lie within each other: that of the parser, far beyond what the contract has.
const MAX_DEPTH: usize = 127;

/// Longest piece of a text that is looked at around what cannot be read.
const MAX_TOKEN: usize = 40;

/// What is wrong: the piece of the text, where it is one, and what to do.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Finding {
    pub(super) value: Value,
    pub(super) remedy: String,
}

/// Looks for what the parser ran into.
pub(super) fn find(json: &[u8], error: &serde_json::Error) -> Finding {
    let say = |remedy: String| Finding { value: Value::Null, remedy };
    if let Some(words) = not_text(json) {
        return say(words);
    }
    let (line, column) = (error.line(), error.column());
    let place = format!("line {line} column {column}");
    if error.is_eof() {
        return say(format!("the text ends in the middle of a value, at {place}: send all of it"));
    }
    if depth(json) > MAX_DEPTH {
        return say(format!("lists and objects lie more than {MAX_DEPTH} deep within each other"));
    }
    let token = token(json, offset(json, line, column));
    let shown = |remedy: String| Finding { value: token.into(), remedy };
    match token.trim_start_matches(['-', '+']) {
        "NaN" | "nan" | "Infinity" | "inf" | "Inf" | "INF" => shown(format!(
            "{token} is no number in JSON ({place}): send a number, or leave the field out"
        )),
        "True" | "False" | "None" | "undefined" | "nil" => {
            shown(format!("{token} is no word of JSON ({place}): use true, false or null"))
        }
        number if number.parse().is_ok_and(f64::is_infinite) => {
            shown(format!("{token} is beyond every number that can be held, 1.8e308 ({place})"))
        }
        "" => say(format!("it is no JSON at {place}: send one JSON object and nothing else")),
        _ => shown(format!("it is no JSON from {token} on, at {place}: send one JSON object")),
    }
}

/// Why the bytes are no text of UTF-8 at all, or nothing.
fn not_text(json: &[u8]) -> Option<String> {
    if json.iter().all(u8::is_ascii_whitespace) {
        return Some("the body is empty: send a JSON object, {} at least".to_owned());
    }
    match json {
        [0x1f, 0x8b, ..] => {
            return Some("it is compressed (gzip): send it as it is".to_owned());
        }
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => {
            return Some("it begins with the byte-order mark of UTF-16: send UTF-8".to_owned());
        }
        [0, _, ..] | [_, 0, ..] => return Some("it is UTF-16 or UTF-32: send UTF-8".to_owned()),
        _ => {}
    }
    let invalid = std::str::from_utf8(json).err()?;
    let first = invalid.valid_up_to();
    Some(format!("byte {first} is no text of UTF-8: send UTF-8"))
}

/// How deep lists and objects lie within each other, texts aside.
fn depth(json: &[u8]) -> usize {
    let (mut depth, mut deepest) = (0_usize, 0);
    let (mut in_text, mut escaped) = (false, false);
    for byte in json {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_text => escaped = true,
            b'"' => in_text = !in_text,
            b'[' | b'{' if !in_text => {
                depth += 1;
                deepest = deepest.max(depth);
            }
            b']' | b'}' if !in_text => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    deepest
}

/// Where line and column are, counted from 1.
fn offset(json: &[u8], line: usize, column: usize) -> usize {
    let starts = json.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1);
    let start = std::iter::once(0).chain(starts).nth(line.saturating_sub(1)).unwrap_or(0);
    (start + column.saturating_sub(1)).min(json.len().saturating_sub(1))
}

/// The word or number around `at` or just before it; else the one character there, if it can be seen.
fn token(json: &[u8], at: usize) -> &str {
    let is_part =
        |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-' | b'.' | b'_');
    let at = if json.get(at).is_some_and(is_part) || at == 0 { at } else { at - 1 };
    let before = json[..at].iter().rev().take(MAX_TOKEN).take_while(|byte| is_part(byte)).count();
    let after = json[at..].iter().take(MAX_TOKEN).take_while(|byte| is_part(byte)).count();
    if after == 0 {
        return "";
    }
    std::str::from_utf8(&json[at - before..at + after]).unwrap_or_default()
}
