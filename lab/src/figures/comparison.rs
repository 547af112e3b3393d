//! How methods compare: thesis figures 8 to 11, and time against deviation of everybody.

use super::axis::Axis;
use super::{
    Curve, FigureError, Heading, INK, LEADING, Marker, Panel, Point, SECOND, Stroke, page,
};
use crate::comparison::{ComparisonSettings, Contender, Distribution, Trial};
use plotters::prelude::RGBColor;
use umwelt_api::comparison::Figure;

/// Curves of one panel at most: more can no longer be told apart.
const MOST_CURVES: usize = 6;

/// Whose curves come first: the methods of the thesis.
const THESIS: [&str; 4] = ["bayesian", "statistic", "fixed-normal", "fixed-bad"];

const GREEN: RGBColor = RGBColor(0x00, 0x9e, 0x73);
const PURPLE: RGBColor = RGBColor(0xcc, 0x79, 0xa7);
const SKY: RGBColor = RGBColor(0x56, 0xb4, 0xe9);
const ORANGE: RGBColor = RGBColor(0xe6, 0x9f, 0x00);

/// A line without markers.
const fn line(colour: RGBColor, width: u32, dash: Option<&'static str>) -> Stroke {
    Stroke { colour, width, dash, marker: Marker::None }
}

/// Strokes of the curves of a panel, in their order: they differ in dash and weight besides colour.
const CURVES: [Stroke; MOST_CURVES] = [
    line(LEADING.colour, 18, None),
    line(SECOND.colour, 13, Some("45 25")),
    line(GREEN, 13, Some("80 25 12 25")),
    line(PURPLE, 18, Some("14 22")),
    line(INK, 7, None),
    line(ORANGE, 9, Some("90 40")),
];

/// A marker without a line.
const fn marker(colour: RGBColor, marker: Marker) -> Stroke {
    Stroke { colour, width: 0, dash: None, marker }
}

/// How each method is marked: those of one family alike in colour, each by a shape of its own within it.
const MARKERS: [(&str, Stroke); 14] = [
    ("bayesian", marker(LEADING.colour, Marker::Disc)),
    ("bayesian-default", marker(LEADING.colour, Marker::Diamond)),
    ("bayesian-flat", marker(LEADING.colour, Marker::Triangle)),
    ("bayesian-empirical", marker(LEADING.colour, Marker::Inverted)),
    ("statistic", marker(SECOND.colour, Marker::Square)),
    ("fixed-normal", marker(SECOND.colour, Marker::Triangle)),
    ("fixed-bad", marker(SECOND.colour, Marker::Inverted)),
    ("oracle", marker(INK, Marker::Plus)),
    ("ekf-packet", marker(GREEN, Marker::Diamond)),
    ("sliding-mode", marker(GREEN, Marker::Square)),
    ("gp-mpc", marker(GREEN, Marker::Disc)),
    ("stop-when-stale", marker(PURPLE, Marker::Cross)),
    ("no-compensation", marker(ORANGE, Marker::Cross)),
    ("", marker(SKY, Marker::Disc)),
];

/// The figure as an SVG document. `comparison` is its name; the distributions are those of its end.
///
/// The curves say how often a quantity is larger than what stands below, on a logarithmic axis, so that rare trials show
/// as plainly as common ones; a panel for each environment and number of slots, with the thesis's four methods or, where
/// those did not drive, the first six. The points of the last figure are medians, on logarithmic axes.
///
/// # Errors
/// Where there is nothing to draw.
pub fn svg(
    figure: Figure,
    comparison: &str,
    settings: &ComparisonSettings,
    distributions: &[Distribution],
) -> Result<String, FigureError> {
    if distributions.iter().all(|it| it.trials.is_empty()) {
        return Err(FigureError::NoTrials);
    }
    match figure {
        Figure::Deviation => exceedance(
            &Quantity {
                title: "Largest deviation",
                x: "largest deviation (mm)",
                y: "share of trials that deviate farther",
                of: |trial| 1e3 * trial.deviation,
            },
            comparison,
            settings,
            distributions,
        ),
        Figure::Time => exceedance(
            &Quantity {
                title: "Completion time",
                x: "completion time (s)",
                y: "share of trials that take longer",
                of: |trial| trial.time,
            },
            comparison,
            settings,
            distributions,
        ),
        Figure::Pareto => pareto(comparison, settings, distributions),
    }
}

/// What curves are of.
struct Quantity {
    title: &'static str,
    x: &'static str,
    y: &'static str,
    of: fn(&Trial) -> f64,
}

/// Numbers of slots in the order in which they come.
fn horizons(settings: &ComparisonSettings) -> Vec<usize> {
    let mut slots: Vec<_> = settings.contenders.iter().map(|it| it.slots).collect();
    slots.sort_unstable();
    slots.dedup();
    slots
}

/// The names of those whose curves are drawn, those of the thesis first.
fn drawn(settings: &ComparisonSettings) -> Vec<&str> {
    let names = || settings.contenders.iter().map(|it| it.name.as_str());
    let of_thesis: Vec<_> =
        THESIS.into_iter().filter(|name| names().any(|it| it == *name)).collect();
    if of_thesis.len() > 1 {
        return of_thesis;
    }
    let mut first: Vec<&str> = Vec::new();
    for name in names() {
        if first.len() < MOST_CURVES && !first.contains(&name) {
            first.push(name);
        }
    }
    first
}

fn find<'a>(
    distributions: &'a [Distribution],
    environment: &str,
    contender: &Contender,
) -> Option<&'a Distribution> {
    let label = contender.label();
    distributions.iter().find(|it| it.environment == environment && it.contender == label)
}

fn exceedance(
    quantity: &Quantity,
    comparison: &str,
    settings: &ComparisonSettings,
    distributions: &[Distribution],
) -> Result<String, FigureError> {
    let names = drawn(settings);
    let trials = distributions.iter().map(|it| it.trials.len()).max().unwrap_or(1);
    let rarest = 1.0 / trials as f64;
    let y = Axis::logarithmic(quantity.y, [rarest, 1.0].into_iter(), 4);
    let mut panels = Vec::new();
    for environment in &settings.environments {
        for slots in horizons(settings) {
            let sorted: Vec<(usize, Vec<f64>)> = names
                .iter()
                .enumerate()
                .filter_map(|(place, name)| {
                    let is_it = |it: &&Contender| it.slots == slots && it.name == **name;
                    let contender = settings.contenders.iter().find(is_it)?;
                    let found = find(distributions, &environment.name, contender)?;
                    let mut values: Vec<f64> = found.trials.iter().map(quantity.of).collect();
                    values.sort_by(f64::total_cmp);
                    Some((place, values))
                })
                .collect();
            if sorted.is_empty() {
                continue;
            }
            let all = sorted.iter().flat_map(|(_, values)| values.iter().copied());
            let x = Axis::from_zero(quantity.x, all, 5);
            let curves = sorted
                .iter()
                .map(|(place, values)| Curve {
                    stroke: CURVES[*place],
                    points: steps(values, x.bottom(), y.bottom()),
                })
                .collect();
            let title = format!("{}, {}", environment.name, of_slots(slots));
            panels.push(Panel { title, x, y: y.clone(), curves, points: Vec::new() });
        }
    }
    let legend = names.iter().zip(CURVES).map(|(name, stroke)| (stroke, (*name).to_owned()));
    let heading = Heading {
        title: format!("{} in {comparison}", quantity.title),
        subtitle: subtitle(settings, trials),
        notes: vec![
            "A curve farther to the left is better. The horizontal scale differs from panel to panel."
                .to_owned(),
        ],
        legend: legend.collect(),
    };
    page::document(&heading, &panels)
}

/// The steps of a complementary cumulative distribution of sorted values: from all, at the left edge, to the rarest, and
/// down to the edge where no value is larger.
fn steps(sorted: &[f64], left: f64, bottom: f64) -> Vec<(f64, f64)> {
    let all = sorted.len() as f64;
    let mut points = vec![(left, 1.0)];
    let mut share = 1.0;
    for (index, value) in sorted.iter().enumerate() {
        let is_last_of_its_kind = sorted.get(index + 1).is_none_or(|next| next > value);
        if is_last_of_its_kind {
            let next = ((all - index as f64 - 1.0) / all).max(bottom);
            points.extend([(*value, share), (*value, next)]);
            share = next;
        }
    }
    points
}

fn of_slots(slots: usize) -> String {
    if slots == 1 { "1 slot".to_owned() } else { format!("{slots} slots") }
}

fn subtitle(settings: &ComparisonSettings, trials: usize) -> String {
    let ComparisonSettings { scenario, seed, .. } = settings;
    format!("Scenario {scenario}, {trials} trials each on the same seeds, seed {seed}")
}

fn median(trials: &[Trial], of: impl Fn(&Trial) -> f64) -> f64 {
    let mut values: Vec<f64> = trials.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().div_ceil(2).saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

fn marker_of(name: &str) -> Stroke {
    let found = MARKERS.iter().find(|(known, _)| *known == name);
    found.unwrap_or(&MARKERS[MARKERS.len() - 1]).1
}

fn pareto(
    comparison: &str,
    settings: &ComparisonSettings,
    distributions: &[Distribution],
) -> Result<String, FigureError> {
    let of_environment = |name: &str| -> Vec<Point> {
        let point = |contender: &Contender| {
            let found = find(distributions, name, contender)?;
            let time = median(&found.trials, |trial| trial.time);
            let deviation = median(&found.trials, |trial| 1e3 * trial.deviation);
            let stroke = marker_of(&contender.name);
            Some(Point { stroke, is_hollow: contender.slots == 1, at: (time, deviation) })
        };
        settings.contenders.iter().filter_map(point).collect()
    };
    let points: Vec<_> = settings.environments.iter().map(|it| of_environment(&it.name)).collect();
    let all = || points.iter().flatten();
    let x = Axis::logarithmic("median completion time (s)", all().map(|it| it.at.0), 5);
    let y = Axis::logarithmic("median largest deviation (mm)", all().map(|it| it.at.1), 7);
    let panel = |(environment, points): (&str, &Vec<Point>)| Panel {
        title: environment.to_owned(),
        x: x.clone(),
        y: y.clone(),
        curves: Vec::new(),
        points: points.clone(),
    };
    let names = settings.environments.iter().map(|it| it.name.as_str());
    let panels: Vec<_> = names.zip(&points).map(panel).collect();
    let mut legend: Vec<(Stroke, String)> = Vec::new();
    for contender in &settings.contenders {
        if legend.iter().all(|(_, name)| *name != contender.name) {
            legend.push((marker_of(&contender.name), contender.name.clone()));
        }
    }
    let trials = distributions.iter().map(|it| it.trials.len()).max().unwrap_or(0);
    let slots: Vec<String> =
        horizons(settings).into_iter().filter(|it| *it > 1).map(of_slots).collect();
    let heading = Heading {
        title: format!("Time against deviation in {comparison}"),
        subtitle: subtitle(settings, trials),
        notes: vec![format!(
            "Lower and farther to the left is better. Hollow or thin: 1 slot per horizon; filled or thick: {}.",
            if slots.is_empty() { "more".to_owned() } else { slots.join(", ") }
        )],
        legend,
    };
    page::document(&heading, &panels)
}
