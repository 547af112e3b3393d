//! One panel: title, axes, curves.

use super::text::{self, LABEL, SMALL};
use super::{Area, Axis, FigureError, GRID, INK, Marker, Panel, Point, QUIET, Stroke, UNIT, layer};
use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::coord::cartesian::Cartesian2d;
use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::prelude::{Color, SVGBackend, TRANSPARENT, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Room for the tick labels of a horizontal axis, in pixels.
const TICK_LABELS: i32 = 21;
/// Room for the name of an axis.
const AXIS_NAME: i32 = 17;
/// Room right of the axes: half a tick label.
const RIGHT: i32 = 16;
/// Width of the line around a hollow marker, in units.
const OUTLINE: u32 = 9;
/// Length of a tick.
const TICK: i32 = 3;

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

/// How a panel is laid out, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    /// What lies within the axes.
    pub(super) plot: (i32, i32),
    /// Room for the tick labels of the vertical axes: the same for all of a page.
    pub(super) labels: i32,
    /// Lines of the longest title in its row.
    pub(super) title_lines: usize,
    /// Whether the axes are named.
    pub(super) names: (bool, bool),
}

impl Layout {
    fn left(self) -> i32 {
        self.labels + if self.names.1 { AXIS_NAME } else { 0 }
    }

    fn bottom(self) -> i32 {
        TICK_LABELS + if self.names.0 { AXIS_NAME } else { 0 }
    }

    fn top(self) -> i32 {
        self.title_lines as i32 * text::leading(LABEL) + 8
    }

    /// The whole panel.
    pub(super) fn size(self) -> (i32, i32) {
        (self.left() + self.plot.0 + RIGHT, self.top() + self.plot.1 + self.bottom())
    }
}

/// Most lines of a panel's title.
const TITLE_LINES: usize = 4;

/// Room for tick labels left of a panel.
pub(super) fn label_room(panel: &Panel) -> i32 {
    let widths = panel.y.labels().map(|label| text::width(&label, SMALL).ceil() as i32);
    widths.max().unwrap_or(0) + 2 * TICK + 4
}

/// The lines of a panel's title over a plot of that width.
pub(super) fn title_lines(panel: &Panel, width: i32) -> Vec<String> {
    text::lines(&panel.title, LABEL, width + RIGHT, TITLE_LINES)
}

/// Draws the panel at the origin of what `document` is in.
pub(super) fn draw(
    document: &mut String,
    panel: &Panel,
    layout: Layout,
) -> Result<(), FigureError> {
    let (width, height) = layout.size();
    let size = (width * UNIT, height * UNIT);
    layer(document, size, None, |root| {
        let lines = title_lines(panel, layout.plot.0);
        for (index, line) in lines.iter().rev().enumerate() {
            let y = layout.top() - 8 - index as i32 * text::leading(LABEL);
            let style = text::bold(LABEL, INK).pos(Pos::new(HPos::Left, VPos::Bottom));
            root.draw_text(line, &style, (layout.left() * UNIT, y * UNIT))?;
        }
        frame(&mut chart(root, panel, layout)?, panel, layout)?;
        let has_curve = panel.curves.iter().any(|curve| curve.runs().next().is_some());
        if !has_curve && !panel.points.iter().any(Point::is_drawable) {
            let (x, y) = (layout.left() + layout.plot.0 / 2, layout.top() + layout.plot.1 / 2);
            let (x, y, half) = (x * UNIT, y * UNIT, (60 * UNIT, 9 * UNIT));
            let corners = [(x - half.0, y - half.1), (x + half.0, y + half.1)];
            root.draw(&Rectangle::new(corners, WHITE.filled()))?;
            let style = text::style(SMALL, QUIET).pos(Pos::new(HPos::Center, VPos::Center));
            root.draw_text("no finite value", &style, (x, y))?;
        }
        Ok(())
    })?;
    for curve in &panel.curves {
        layer(document, size, curve.stroke.dash, |root| {
            let chart = chart(root, panel, layout)?;
            let style = curve.stroke.colour.stroke_width(curve.stroke.width);
            for run in curve.runs().filter(|run| run.len() > 1) {
                chart.plotting_area().draw(&PathElement::new(run.to_vec(), style))?;
            }
            Ok(())
        })?;
    }
    layer(document, size, None, |root| {
        let chart = chart(root, panel, layout)?;
        for curve in &panel.curves {
            for point in curve.marked() {
                mark(root, curve.stroke, false, chart.backend_coord(point))?;
            }
        }
        for point in panel.points.iter().filter(|point| point.is_drawable()) {
            mark(root, point.stroke, point.is_hollow, chart.backend_coord(&point.at))?;
        }
        Ok(())
    })
}

fn chart<'a, 'b>(
    root: &'a Area<'b>,
    panel: &Panel,
    layout: Layout,
) -> Result<Chart<'a, 'b>, FigureError> {
    let chart = ChartBuilder::on(root)
        .margin_top(layout.top() * UNIT)
        .margin_right(RIGHT * UNIT)
        .set_label_area_size(LabelAreaPosition::Left, layout.left() * UNIT)
        .set_label_area_size(LabelAreaPosition::Bottom, layout.bottom() * UNIT)
        .build_cartesian_2d(panel.x.clone(), panel.y.clone())?;
    Ok(chart)
}

fn frame(chart: &mut Chart<'_, '_>, panel: &Panel, layout: Layout) -> Result<(), FigureError> {
    let mut mesh = chart.configure_mesh();
    mesh.disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(8))
        .axis_style(INK.stroke_width(8))
        .set_all_tick_mark_size(TICK * UNIT)
        .label_style(text::style(SMALL, INK))
        .axis_desc_style(text::style(LABEL, INK));
    if layout.names.0 {
        mesh.x_desc(panel.x.name);
    }
    if layout.names.1 {
        mesh.y_desc(panel.y.name);
    }
    Ok(mesh.draw()?)
}

/// Draws a marker at units of `root`.
pub(super) fn mark(
    root: &Area<'_>,
    stroke: Stroke,
    is_hollow: bool,
    at: (i32, i32),
) -> Result<(), FigureError> {
    let moved = |points: &[(i32, i32)]| -> Vec<_> {
        points.iter().map(|(x, y)| (at.0 + x, at.1 + y)).collect()
    };
    let outline = stroke.colour.stroke_width(OUTLINE);
    let corners: &[(i32, i32)] = match stroke.marker {
        Marker::None => return Ok(()),
        Marker::Disc if is_hollow => return Ok(root.draw(&Circle::new(at, 30, outline))?),
        Marker::Disc => return Ok(root.draw(&Circle::new(at, 24, stroke.colour.filled()))?),
        Marker::Cross | Marker::Plus => {
            let bars = match stroke.marker {
                Marker::Cross => [[(-28, -28), (28, 28)], [(-28, 28), (28, -28)]],
                _ => [[(-38, 0), (38, 0)], [(0, -38), (0, 38)]],
            };
            let width = if is_hollow { OUTLINE } else { 2 * OUTLINE };
            for bar in bars {
                root.draw(&PathElement::new(moved(&bar), stroke.colour.stroke_width(width)))?;
            }
            return Ok(());
        }
        Marker::Diamond => &[(0, -30), (30, 0), (0, 30), (-30, 0)],
        Marker::Square => &[(-27, -27), (27, -27), (27, 27), (-27, 27)],
        Marker::Triangle => &[(0, -36), (33, 24), (-33, 24)],
        Marker::Inverted => &[(0, 36), (33, -24), (-33, -24)],
    };
    if is_hollow {
        let mut way = moved(corners);
        way.push(way[0]);
        root.draw(&PathElement::new(way, outline))?;
    } else {
        root.draw(&Polygon::new(moved(corners), stroke.colour.filled()))?;
    }
    Ok(())
}
