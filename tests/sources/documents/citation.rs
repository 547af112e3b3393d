//! What a text cites of the thesis: equations, tables, figures.

use std::fmt;

/// A numbered part of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Citation {
    pub kind: &'static str,
    pub number: u32,
}

impl fmt::Display for Citation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} {}", self.kind, self.number)
    }
}

/// Words that come before a number, longer ones first, and what they mean.
const WORDS: [(&str, &str); 5] = [
    ("eq. ", "eq."),
    ("figures ", "figure"),
    ("figure ", "figure"),
    ("tables ", "table"),
    ("table ", "table"),
];

/// What stands between two numbers, and whether those between are meant too.
const BETWEEN: [(&str, bool); 4] = [("-", true), (" to ", true), (" and ", false), (", ", false)];

/// Everything that `text`, in small letters, cites: `eq. 35-38`, `figures 6 and 7`, `table 1`.
pub fn citations(text: &str) -> Vec<Citation> {
    let mut found = Vec::new();
    for (word, kind) in WORDS {
        for (at, _) in text.match_indices(word) {
            // Not the end of another word, such as the table of `timetable 1`.
            let is_whole = !text[..at].ends_with(|before: char| before.is_alphanumeric());
            let numbers = if is_whole { numbers(&text[at + word.len()..]) } else { Vec::new() };
            found.extend(numbers.into_iter().map(|number| Citation { kind, number }));
        }
    }
    found
}

/// The numbers at the beginning of `text`.
fn numbers(text: &str) -> Vec<u32> {
    let Some((first, mut rest)) = number(text) else { return Vec::new() };
    let mut found = vec![first];
    while let Some((next, is_range, after)) = BETWEEN.iter().find_map(|(between, is_range)| {
        let (next, after) = number(rest.strip_prefix(between)?)?;
        Some((next, *is_range, after))
    }) {
        let last = found.last().copied().unwrap_or_default();
        found.extend(if is_range { last + 1..=next } else { next..=next });
        rest = after;
    }
    found
}

fn number(text: &str) -> Option<(u32, &str)> {
    let end = text.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(text.len());
    Some((text[..end].parse().ok()?, &text[end..]))
}

/// `source` with comments that go on over several lines in one.
pub fn in_one_line(source: &str) -> String {
    source
        .lines()
        .map(|line| line.trim_start().trim_start_matches(['/', '!']).trim())
        .collect::<Vec<_>>()
        .join(" ")
}

#[test]
fn ranges_and_lists_are_all_of_their_numbers() {
    let of = |text| citations(text).iter().map(Citation::to_string).collect::<Vec<_>>().join(" ");
    assert_eq!(
        of("thesis eq. 35-37, corrected; eq. 52 and 53"),
        "eq. 35 eq. 36 eq. 37 eq. 52 eq. 53"
    );
    assert_eq!(
        of("figures 8 to 10, table 1; a vegetable 2"),
        "figure 8 figure 9 figure 10 table 1"
    );
    assert_eq!(of(&in_one_line("/// thesis eq.\n    /// 20.")), "eq. 20");
}
