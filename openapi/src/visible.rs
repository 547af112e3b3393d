//! Text that shows as what it is: nothing in it moves a cursor, hides a part or turns the order of what is read.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether `character` changes how the text around it shows rather than showing itself: the control characters C0
/// (tab and newline among them), DEL and C1, the separators of lines and paragraphs, and what turns the direction of
/// writing.
pub fn is_hidden(character: char) -> bool {
    character.is_control()
        || matches!(character,
            '\u{2028}' | '\u{2029}'
            | '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// What a text without hidden characters matches, as ECMAScript has it.
pub const PATTERN: &str =
    concat!(r"^[^\u0000-\u001f\u007f-\u009f\u061c\u200e\u200f", r"\u2028-\u202e\u2066-\u2069]*$");

/// The first hidden character of `text`, and how many characters stand before it.
pub fn first_hidden(text: &str) -> Option<(usize, char)> {
    // Most texts are short and ASCII: bytes are looked at first.
    if text.bytes().all(|byte| matches!(byte, b' '..=b'~')) {
        return None;
    }
    text.chars().enumerate().find(|(_, character)| is_hidden(*character))
}

/// `text` on one line: each hidden character as `\u{1b}`.
///
/// ```
/// assert_eq!(umwelt_api::visible::line("a\x1b[2J\nb"), "a\\u{1b}[2J\\u{a}b");
/// ```
pub fn line(text: &str) -> Cow<'_, str> {
    escaped(text, is_hidden, |escaped, character| {
        // Writing to a String cannot fail.
        let _ = write!(escaped, "\\u{{{:x}}}", u32::from(character));
    })
}

/// `text` with its lines and tabs; every other hidden character as `\u{1b}`.
pub fn lines(text: &str) -> Cow<'_, str> {
    let is_meant = |character| is_hidden(character) && !matches!(character, '\n' | '\t');
    escaped(text, is_meant, |escaped, character| {
        let _ = write!(escaped, "\\u{{{:x}}}", u32::from(character));
    })
}

/// JSON that says the same: hidden characters stand in its texts alone, and JSON has a form for each of them.
pub fn json(text: &str) -> Cow<'_, str> {
    let is_meant = |character| is_hidden(character) && character != '\n';
    escaped(text, is_meant, |escaped, character| {
        // All of them lie in the plane that one escape reaches.
        let _ = write!(escaped, "\\u{:04x}", u32::from(character));
    })
}

fn escaped(
    text: &str,
    is_meant: impl Fn(char) -> bool,
    write: impl Fn(&mut String, char),
) -> Cow<'_, str> {
    if !text.chars().any(&is_meant) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_meant(character) {
            write(&mut escaped, character);
        } else {
            escaped.push(character);
        }
    }
    Cow::Owned(escaped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HIDDEN: [char; 14] = [
        '\0', '\t', '\n', '\r', '\x1b', '\x7f', '\u{80}', '\u{9b}', '\u{2028}', '\u{2029}',
        '\u{202e}', '\u{2066}', '\u{200f}', '\u{61c}',
    ];

    #[test]
    fn what_hides_is_found_where_it_stands() {
        for character in HIDDEN {
            assert_eq!(first_hidden(&format!("aä{character}b{character}")), Some((2, character)));
        }
        for shown in ["", "the wet hall", "größer als 5 µm", "床が滑る", "👩\u{200d}🔧 \u{a0}"]
        {
            assert_eq!((first_hidden(shown), line(shown)), (None, shown.into()));
        }
    }

    proptest! {
        #[test]
        fn what_is_escaped_hides_nothing_and_json_says_the_same(text in "(\\PC|[\0-\x1f\x7f-\u{9f}\u{2028}\u{202e}])*") {
            prop_assert_eq!(first_hidden(&line(&text)), None);
            let kept = lines(&text);
            prop_assert!(kept.chars().all(|it| !is_hidden(it) || it == '\n' || it == '\t'));
            let said = serde_json::to_string_pretty(&[&text]).unwrap();
            let shown = json(&said);
            prop_assert_eq!(serde_json::from_str::<[String; 1]>(&shown).unwrap(), [text]);
            prop_assert!(shown.chars().all(|it| !is_hidden(it) || it == '\n'));
        }
    }
}
