//! How a figure is read: its text, its ticks, its lines, and what lies where.

use super::super::{Stroke, text};
use roxmltree::{Document, Node};

pub(super) fn number(node: Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

/// All text, a line of it for each element.
pub(super) fn texts(node: Node<'_, '_>) -> Vec<String> {
    let texts = node.descendants().filter(|it| it.has_tag_name("text"));
    texts.map(|it| it.text().unwrap_or("").trim().to_owned()).collect()
}

pub(super) fn of_class<'a, 'b: 'a>(document: &'a Document<'b>, class: &str) -> Vec<Node<'a, 'b>> {
    document.descendants().filter(|it| it.attribute("class") == Some(class)).collect()
}

/// Left, top, right, bottom of a group in units of the page.
pub(super) fn rectangle(group: Node<'_, '_>) -> [f64; 4] {
    let transform = group.attribute("transform").unwrap();
    let numbers = transform.trim_start_matches("translate(").trim_end_matches(')');
    let (x, y) = numbers.split_once(' ').unwrap();
    let (x, y): (f64, f64) = (x.parse().unwrap(), y.parse().unwrap());
    let nested = group.descendants().find(|it| it.has_tag_name("svg")).unwrap();
    [x, y, x + number(nested, "width"), y + number(nested, "height")]
}

/// The lines of a stroke in a panel.
pub(super) fn lines(panel: Node<'_, '_>, stroke: Stroke) -> Vec<Vec<(f64, f64)>> {
    let (red, green, blue) = (stroke.colour.0, stroke.colour.1, stroke.colour.2);
    let colour = format!("#{red:02X}{green:02X}{blue:02X}");
    let point = |pair: &str| {
        let (x, y) = pair.split_once(',').unwrap();
        (x.parse().unwrap(), y.parse().unwrap())
    };
    let is_line =
        |it: &Node<'_, '_>| it.has_tag_name("polyline") && it.attribute("stroke") == Some(&colour);
    let points =
        |it: Node<'_, '_>| it.attribute("points").unwrap().split_whitespace().map(point).collect();
    panel.descendants().filter(is_line).map(points).collect()
}

/// What a place on an axis means, from its first and last tick label. Horizontal labels hang from their ticks, those
/// of the vertical axis end at them.
pub(super) fn ruler(panel: Node<'_, '_>, is_vertical: bool) -> impl Fn(f64) -> f64 {
    let (axis, anchor, dy) =
        if is_vertical { ("y", "end", "0.5ex") } else { ("x", "middle", "0.76em") };
    let is_label = |it: &Node<'_, '_>| {
        it.attribute("text-anchor") == Some(anchor) && it.attribute("dy") == Some(dy)
    };
    let labels = panel.descendants().filter(is_label);
    let ticks: Vec<(f64, f64)> =
        labels.filter_map(|it| Some((number(it, axis), it.text()?.trim().parse().ok()?))).collect();
    let (from, to) = (ticks[0], ticks[ticks.len() - 1]);
    move |place| from.1 + (place - from.0) / (to.0 - from.0) * (to.1 - from.1)
}

/// The text of the highest tick of each panel.
pub(super) fn tops(svg: &str) -> Vec<f64> {
    let document = Document::parse(svg).unwrap();
    let top = |panel: Node<'_, '_>| {
        let is_label = |it: &Node<'_, '_>| it.attribute("text-anchor") == Some("end");
        let labels = panel.descendants().filter(is_label);
        labels.map(|it| it.text().unwrap().trim().parse().unwrap()).fold(0.0, f64::max)
    };
    of_class(&document, "panel").into_iter().map(top).collect()
}

/// Horizontal texts of a panel keep apart and within it, as far as their width is known.
pub(super) fn nothing_overlaps_within(panel: Node<'_, '_>) {
    let [left, top, right, bottom] = rectangle(panel);
    let is_text =
        |it: &Node<'_, '_>| it.has_tag_name("text") && it.attribute("transform").is_none();
    let extent = |it: Node<'_, '_>| {
        let content = it.text().unwrap().trim().to_owned();
        let (size, x, y) = (number(it, "font-size"), number(it, "x"), number(it, "y"));
        let is_bold = it.attribute("font-weight") == Some("bold");
        let of = if is_bold { text::bold_width } else { text::width };
        let width = of(&content, 1) * size;
        let x = x - match it.attribute("text-anchor").unwrap() {
            "start" => 0.0,
            "middle" => 0.5,
            _ => 1.0,
        } * width;
        // Capitals reach about 0.75 em above the base line.
        let base = y + match it.attribute("dy").unwrap() {
            "0.76em" => 0.76,
            "0.5ex" => 0.26,
            _ => -0.26,
        } * size;
        (content, [x, base - 0.75 * size, x + width, base])
    };
    let extents: Vec<_> = panel.descendants().filter(is_text).map(extent).collect();
    assert!(extents.len() > 3, "{extents:?}");
    for (place, (content, [x0, y0, x1, y1])) in extents.iter().enumerate() {
        let is_in = *x0 >= 0.0 && *y0 >= 0.0 && *x1 <= right - left && *y1 <= bottom - top;
        assert!(
            is_in,
            "{content} at {x0} {y0} {x1} {y1} leaves its panel of {} x {}",
            right - left,
            bottom - top
        );
        for (other, [other_x0, other_y0, other_x1, other_y1]) in &extents[..place] {
            let apart = x0 >= other_x1 || x1 <= other_x0 || y0 >= other_y1 || y1 <= other_y0;
            assert!(apart, "{content} lies over {other}");
        }
    }
}
