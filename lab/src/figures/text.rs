//! Text whose font no one has measured: what may stand in XML, how wide it may get, where it
//! is broken.

use super::UNIT;
use plotters::prelude::{Color, FontStyle, IntoFont, RGBColor, TextStyle};

/// Of a figure's title, in pixels.
pub(super) const TITLE: i32 = 15;
/// Of panel titles and axis names.
pub(super) const LABEL: i32 = 12;
/// Of tick labels and everything of second rank.
pub(super) const SMALL: i32 = 11;

/// From a line to the next, in pixels.
pub(super) fn leading(size: i32) -> i32 {
    size * 5 / 4
}

/// Text of that size in pixels.
pub(super) fn style(size: i32, colour: RGBColor) -> TextStyle<'static> {
    of_weight(FontStyle::Normal, size, colour)
}

/// The same, bold.
pub(super) fn bold(size: i32, colour: RGBColor) -> TextStyle<'static> {
    of_weight(FontStyle::Bold, size, colour)
}

fn of_weight(weight: FontStyle, size: i32, colour: RGBColor) -> TextStyle<'static> {
    // plotters' SVG divides font sizes by 1.24.
    let font = ("sans-serif", f64::from(size * UNIT) * 1.24).into_font().style(weight);
    TextStyle { color: colour.to_backend_color(), ..TextStyle::from(font) }
}

/// What XML can hold: control characters and non-characters become U+FFFD, white space becomes one kind of space.
pub(super) fn printable(text: &str) -> String {
    let printable = |c: char| match c {
        _ if c.is_whitespace() => ' ',
        '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        _ if c.is_control() => '\u{fffd}',
        _ => c,
    };
    text.chars().map(printable).collect()
}

/// Text as XML content.
pub(super) fn escaped(text: &str) -> String {
    printable(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// How wide text may get, in pixels: about that of the widest common sans-serifs (DejaVu Sans, Verdana).
pub(super) fn width(text: &str, size: i32) -> f64 {
    0.88 * bold_width(text, size)
}

/// The same, bold.
pub(super) fn bold_width(text: &str, size: i32) -> f64 {
    let of = |c: char| match c {
        ' ' | '.' | ',' | ':' | ';' | '\'' | '|' | 'i' | 'j' | 'l' | 't' | 'f' | 'r' | 'I'
        | '/' | '(' | ')' | '-' => 0.40,
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 1.05,
        'A'..='Z' | '&' | '_' | '=' | '+' | '<' | '>' | '~' | '#' => 0.80,
        ' '..='~' => 0.68,
        _ => 1.1,
    };
    text.chars().map(of).sum::<f64>() * f64::from(size)
}

/// Lines no wider than `room` pixels, broken at a space or after a hyphen where there is one, else anywhere. What does
/// not fit into `most` lines is cut, and the last one says so.
pub(super) fn lines(text: &str, size: i32, room: i32, most: usize) -> Vec<String> {
    let text = printable(text);
    let (room, mut rest) = (f64::from(room), text.trim());
    let mut lines = Vec::new();
    while !rest.is_empty() {
        let fitting = |text: &str, room: f64| {
            let ends = text.char_indices().map(|(at, c)| at + c.len_utf8());
            ends.take_while(|end| bold_width(&text[..*end], size) <= room).last().unwrap_or(0)
        };
        let one = rest.chars().next().map_or(0, char::len_utf8);
        let mut end = fitting(rest, room).max(one);
        if end < rest.len() && lines.len() + 1 == most {
            let end = fitting(rest, room - bold_width("\u{2026}", size)).max(one);
            lines.push(format!("{}\u{2026}", rest[..end].trim_end()));
            return lines;
        }
        if end < rest.len() && !rest[end..].starts_with(' ') {
            let breaks = rest[..end].rfind([' ', '-']).map(|at| at + 1);
            end = breaks.unwrap_or(end);
        }
        lines.push(rest[..end].trim_end().to_owned());
        rest = rest[end..].trim_start();
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_text_is_broken_where_it_reads_best_and_nothing_is_lost() {
        let text = "bad-link-and-slippery floor";
        let broken = lines(text, 10, 100, 9);
        assert_eq!(broken, ["bad-link-and-", "slippery floor"]);
        for room in [1, 8, 30, 75, 160, 400] {
            let broken = lines(text, 10, room, 99);
            let kept: String = broken.concat().split(' ').collect();
            assert_eq!(kept, text.replace(' ', ""), "{room}");
            let fits =
                |line: &String| width(line, 10) <= f64::from(room) || line.chars().count() == 1;
            assert!(broken.iter().all(fits), "{room}: {broken:?}");
        }
    }

    #[test]
    fn what_does_not_fit_is_cut_and_says_so() {
        let broken = lines(&"long ".repeat(100), 10, 100, 2);
        assert_eq!(broken.len(), 2);
        assert!(
            broken[1].ends_with('\u{2026}') && bold_width(&broken[1], 10) <= 100.0,
            "{broken:?}"
        );
        assert!(lines("", 10, 100, 2).is_empty());
        assert!(lines("\n \t", 10, 100, 2).is_empty());
    }

    #[test]
    fn what_xml_cannot_hold_is_replaced() {
        assert_eq!(printable("a\u{0}b\u{ffff}c\nd\u{1b}"), "a\u{fffd}b\u{fffd}c d\u{fffd}");
        assert_eq!(escaped("<a & b>"), "&lt;a &amp; b&gt;");
    }
}
