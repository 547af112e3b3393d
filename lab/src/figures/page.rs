//! The page: heading, legend, and panels in rows and columns. It grows with them; panels never shrink below a size
//! that reads well.

use super::panel::{self, Layout};
use super::text::{self, LABEL, SMALL, TITLE};
use super::{Area, Curve, FigureError, Heading, INK, Marker, Panel, QUIET, Stroke, UNIT, layer};
use plotters::element::PathElement;
use plotters::prelude::Color;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::fmt::Write;

/// Around everything, in pixels.
const MARGIN: i32 = 16;
/// Between two rows of panels.
const ROW_GAP: i32 = 12;
/// Length of a sample of a stroke in the legend.
const SAMPLE: i32 = 34;

/// Columns for so many panels, and the size of what lies within a panel's axes.
fn arrangement(panels: usize) -> (usize, (i32, i32)) {
    match panels {
        ..=1 => (1, (500, 270)),
        2 | 4 => (2, (290, 190)),
        3 | 5 | 6 | 9 => (3, (205, 150)),
        _ => (4, (190, 140)),
    }
}

/// A panel's place on the page and its layout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) corner: (i32, i32),
    pub(super) layout: Layout,
}

/// Where panels go below `top`, and the size of the page.
pub(super) fn places(panels: &[Panel], top: i32) -> (Vec<Place>, (i32, i32)) {
    let (columns, plot) = arrangement(panels.len());
    let mut places: Vec<Place> = Vec::with_capacity(panels.len());
    let labels = panels.iter().map(panel::label_room).max().unwrap_or(0);
    let last_row = panels.len().saturating_sub(1) / columns;
    let (mut y, mut size) = (top, (0, 0));
    for (row, in_row) in panels.chunks(columns).enumerate() {
        let lines = in_row.iter().map(|panel| panel::title_lines(panel, plot.0).len());
        let title_lines = lines.max().unwrap_or(0);
        let (mut x, mut bottom) = (MARGIN, y);
        for column in 0..in_row.len() {
            let has_none_below = row * columns + column + columns >= panels.len();
            let layout = Layout { plot, labels, title_lines, names: (has_none_below, column == 0) };
            places.push(Place { corner: (x, y), layout });
            let width = layout.size().0;
            // A name over an empty place in the last row reaches down into it.
            let names = (layout.names.0 && row == last_row, layout.names.1);
            let in_row = Layout { names, ..layout }.size().1;
            (x, bottom) = (x + width, bottom.max(y + in_row));
        }
        size = (size.0.max(x + MARGIN), bottom + MARGIN);
        y = bottom + ROW_GAP;
    }
    (places, size)
}

/// The document of a figure.
pub(super) fn document(heading: &Heading, panels: &[Panel]) -> Result<String, FigureError> {
    let (_, (width, _)) = places(panels, 0);
    let room = width - 2 * MARGIN;
    let titles = text::lines(&heading.title, TITLE, room, 3);
    let paragraphs = [&heading.subtitle].into_iter().chain(&heading.notes);
    let subtitles: Vec<_> = paragraphs.flat_map(|it| text::lines(it, SMALL, room, 3)).collect();
    let is_marked = |stroke: Stroke| {
        let is_curve = |curve: &Curve| curve.stroke == stroke && curve.marked().next().is_some();
        panels.iter().any(|panel| {
            panel.curves.iter().any(is_curve)
                || panel.points.iter().any(|point| point.stroke == stroke)
        })
    };
    let sample = |(stroke, label): &Entry| {
        let marker = if is_marked(*stroke) { stroke.marker } else { Marker::None };
        (Stroke { marker, ..*stroke }, label.clone())
    };
    let rows = legend_rows(heading.legend.iter().map(sample), room);
    let top = MARGIN
        + titles.len() as i32 * text::leading(TITLE)
        + subtitles.len() as i32 * text::leading(SMALL)
        + rows.len() as i32 * 20
        + 16;
    let (places, (width, height)) = places(panels, top);

    let mut document = String::new();
    let _ = write!(
        document,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" stroke-linejoin=\"round\" role=\"img\">\n\
         <title>{}</title>\n<desc>{}</desc>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n",
        width * UNIT,
        height * UNIT,
        text::escaped(&heading.title),
        text::escaped(&heading.subtitle),
    );
    head(&mut document, (width, top), &titles, &subtitles)?;
    let first_row = top - 16 - rows.len() as i32 * 20;
    legend(&mut document, &rows, first_row)?;
    for (panel, place) in panels.iter().zip(places) {
        group(&mut document, "panel", place.corner, |document| {
            panel::draw(document, panel, place.layout)
        })?;
    }
    document.push_str("</svg>\n");
    Ok(document)
}

/// What `draw` adds, moved to `corner` in pixels.
fn group(
    document: &mut String,
    class: &str,
    (x, y): (i32, i32),
    draw: impl FnOnce(&mut String) -> Result<(), FigureError>,
) -> Result<(), FigureError> {
    let (x, y) = (x * UNIT, y * UNIT);
    let _ = writeln!(document, "<g class=\"{class}\" transform=\"translate({x} {y})\">");
    draw(document)?;
    document.push_str("</g>\n");
    Ok(())
}

fn head(
    document: &mut String,
    (width, height): (i32, i32),
    titles: &[String],
    subtitles: &[String],
) -> Result<(), FigureError> {
    layer(document, (width * UNIT, height * UNIT), None, |root| {
        let mut y = MARGIN;
        let titles = titles.iter().map(|line| (line, TITLE, text::bold(TITLE, INK)));
        let subtitles = subtitles.iter().map(|line| (line, SMALL, text::style(SMALL, QUIET)));
        for (line, size, style) in titles.chain(subtitles) {
            let style = style.pos(Pos::new(HPos::Left, VPos::Top));
            root.draw_text(line, &style, (MARGIN * UNIT, y * UNIT))?;
            y += text::leading(size);
        }
        Ok(())
    })
}

type Entry = (Stroke, String);

fn entry_width((_, label): &Entry) -> i32 {
    SAMPLE + 6 + text::width(label, LABEL) as i32 + 14
}

/// Legend entries in rows no wider than `room`.
fn legend_rows(entries: impl Iterator<Item = Entry>, room: i32) -> Vec<Vec<Entry>> {
    let mut rows: Vec<Vec<Entry>> = Vec::new();
    let mut width = 0;
    for entry in entries {
        let entry_width = entry_width(&entry);
        match rows.last_mut() {
            Some(row) if width + entry_width <= room => row.push(entry),
            _ => {
                rows.push(vec![entry]);
                width = 0;
            }
        }
        width += entry_width;
    }
    rows
}

fn legend(document: &mut String, rows: &[Vec<Entry>], top: i32) -> Result<(), FigureError> {
    for (index, row) in rows.iter().enumerate() {
        let mut corner = (MARGIN, top + index as i32 * 20 + 4);
        for entry in row {
            group(document, "legend", corner, |document| legend_entry(document, entry))?;
            corner.0 += entry_width(entry);
        }
    }
    Ok(())
}

fn legend_entry(document: &mut String, entry: &Entry) -> Result<(), FigureError> {
    let (stroke, label) = entry;
    let (size, middle) = ((entry_width(entry) * UNIT, 20 * UNIT), 10 * UNIT);
    layer(document, size, stroke.dash, |root| {
        let style = stroke.colour.stroke_width(stroke.width);
        if stroke.width == 0 {
            return Ok(());
        }
        Ok(root.draw(&PathElement::new([(0, middle), (SAMPLE * UNIT, middle)], style))?)
    })?;
    layer(document, size, None, |root: &Area<'_>| {
        panel::mark(root, *stroke, false, (SAMPLE * UNIT / 2, middle))?;
        let style = text::style(LABEL, INK).pos(Pos::new(HPos::Left, VPos::Center));
        Ok(root.draw_text(label, &style, ((SAMPLE + 6) * UNIT, middle))?)
    })
}
