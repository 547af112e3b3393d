//! Figures as SVG: the grammar that all of them share. A figure is a page with a heading, one legend and panels of
//! one size; a panel has two axes and curves.
//!
//! Made for print: strokes differ in dash, weight and marker besides colour (Okabe and Ito's, which colour-blind
//! readers tell apart), so that a grey copy loses nothing; horizontal grid lines only; axes are named, with units,
//! where a row or a column of panels begins. Text is text in whatever sans-serif the reader has, so nothing here
//! measures a font: room for text is estimated, generously.
//!
//! plotters draws whole units only, hence a grid of `UNIT` to the pixel; its SVG has no dashes, hence a nested
//! document for each layer, which inherits them from the group around it.
//!
//! Architecture invariants: a figure is a pure function, nothing is read or written; no figure styles anything by
//! itself; names come from users, so every text passes `text::printable` and is escaped.

mod axis;
pub mod comparison;
pub mod evolution;
mod page;
mod panel;
#[cfg(test)]
mod tests;
mod text;

use axis::Axis;
use plotters::coord::Shift;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::{DrawingArea, IntoDrawingArea, RGBColor, SVGBackend};
use std::fmt::Write;

/// Drawing units to a pixel of the page.
const UNIT: i32 = 10;

/// Text, axis lines.
const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Second-rank text.
const QUIET: RGBColor = RGBColor(0x55, 0x55, 0x55);
/// Grid lines.
const GRID: RGBColor = RGBColor(0xe2, 0xe2, 0xe2);

/// What leads the eye: a full line, round markers.
const LEADING: Stroke =
    Stroke { colour: RGBColor(0x00, 0x72, 0xb2), width: 18, dash: None, marker: Marker::Disc };
/// What goes beside it: dashed, diamonds.
const SECOND: Stroke = Stroke {
    colour: RGBColor(0xd5, 0x5e, 0x00),
    width: 13,
    dash: Some("45 25"),
    marker: Marker::Diamond,
};
/// What it is all measured by: thin, dotted, grey.
const REFERENCE: Stroke =
    Stroke { colour: QUIET, width: 10, dash: Some("10 25"), marker: Marker::None };

/// Up to this many points of a curve are marked one by one.
const MARKED_POINTS: usize = 31;

/// Why there is no figure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FigureError {
    /// Nothing has happened yet.
    #[error("no generation has ended yet, so there is nothing to draw: try again after the first")]
    NoGenerations,
    /// There are no trials.
    #[error(
        "there are no trials yet, so there is nothing to draw: try again when the comparison has ended"
    )]
    NoTrials,
    /// The generations say nothing of any environment.
    #[error("the generations name no environment, so there is no panel to draw")]
    NoEnvironments,
    /// plotters could not draw.
    #[error("the figure could not be drawn: {0}")]
    Drawing(String),
}

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for FigureError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self::Drawing(error.to_string())
    }
}

/// What marks a single point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Marker {
    None,
    Disc,
    Diamond,
    Square,
    Triangle,
    /// A triangle on its tip.
    Inverted,
    Cross,
    Plus,
}

/// How a curve looks.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stroke {
    colour: RGBColor,
    /// In units.
    width: u32,
    /// Dash and gap in units.
    dash: Option<&'static str>,
    marker: Marker,
}

impl Stroke {
    /// The same in the background: single values behind their running mean.
    fn pale(self) -> Self {
        let lighter = |part: u8| 255 - (255 - part) / 3;
        let RGBColor(red, green, blue) = self.colour;
        let colour = RGBColor(lighter(red), lighter(green), lighter(blue));
        Self { colour, width: 5, dash: None, marker: Marker::None }
    }
}

/// Points joined by a line. One that is not finite is left out, and the line has a gap there.
#[derive(Clone, Debug)]
struct Curve {
    stroke: Stroke,
    points: Vec<(f64, f64)>,
}

impl Curve {
    /// What single points of it are drawn with markers: all of a short curve, of a long one those that no line reaches.
    fn marked(&self) -> impl Iterator<Item = &(f64, f64)> {
        let is_short = self.points.len() <= MARKED_POINTS;
        let has_marker = self.stroke.marker != Marker::None;
        self.runs().filter(move |run| has_marker && (is_short || run.len() == 1)).flatten()
    }

    /// The runs of points without a gap.
    fn runs(&self) -> impl Iterator<Item = &[(f64, f64)]> {
        let is_drawable = |(x, y): &(f64, f64)| axis::is_drawable(*x) && axis::is_drawable(*y);
        self.points.split(move |point| !is_drawable(point)).filter(|run| !run.is_empty())
    }

    /// Each point with the mean of the `reach` points before it, itself and as many after it, or what there is of them
    /// in its run.
    fn running_mean(&self, reach: usize) -> Vec<(f64, f64)> {
        let of_run = |run: &[(f64, f64)]| {
            let mean = |index: usize| {
                let around = &run[index.saturating_sub(reach)..run.len().min(index + reach + 1)];
                let sum: f64 = around.iter().map(|(_, y)| y).sum();
                (run[index].0, sum / around.len() as f64)
            };
            let gap = [(f64::NAN, f64::NAN)];
            (0..run.len()).map(mean).chain(gap).collect::<Vec<_>>()
        };
        self.runs().flat_map(of_run).collect()
    }
}

/// A small multiple.
#[derive(Clone, Debug)]
struct Panel {
    title: String,
    x: Axis,
    y: Axis,
    curves: Vec<Curve>,
    points: Vec<Point>,
}

/// A single point.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// Of which colour and marker count.
    stroke: Stroke,
    /// Whether its marker is an outline.
    is_hollow: bool,
    at: (f64, f64),
}

impl Point {
    fn is_drawable(&self) -> bool {
        axis::is_drawable(self.at.0) && axis::is_drawable(self.at.1)
    }
}

/// What stands above the panels.
#[derive(Clone, Debug)]
struct Heading {
    title: String,
    /// What was run.
    subtitle: String,
    /// How to read it, where that is not plain.
    notes: Vec<String>,
    legend: Vec<(Stroke, String)>,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Adds a layer of `size` units to `document`, its lines dashed like that.
fn layer(
    document: &mut String,
    size: (i32, i32),
    dash: Option<&str>,
    draw: impl FnOnce(&Area<'_>) -> Result<(), FigureError>,
) -> Result<(), FigureError> {
    let mut nested = String::new();
    let root = SVGBackend::with_string(&mut nested, (size.0 as u32, size.1 as u32));
    let root = root.into_drawing_area();
    draw(&root)?;
    root.present()?;
    drop(root);
    let _ = match dash {
        Some(dash) => writeln!(document, "<g stroke-dasharray=\"{dash}\">\n{nested}</g>"),
        None => write!(document, "{nested}"),
    };
    Ok(())
}
