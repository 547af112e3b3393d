//! Figures of a comparison, read back.

use super::super::comparison::svg;
use super::super::{FigureError, UNIT};
use super::reading::{nothing_overlaps_within, number, of_class, rectangle, texts};
use crate::comparison::{ComparisonSettings, Distribution, Trial};
use roxmltree::{Document, Node};
use umwelt_api::comparison::Figure;

fn settings() -> ComparisonSettings {
    ComparisonSettings::scenario("thesis").unwrap()
}

/// `count` trials of everybody: deviations of 1, 2, 3.. mm and times of 10.1, 10.2.. s, both times the place of the
/// contender from 1.
fn distributions(settings: &ComparisonSettings, count: usize) -> Vec<Distribution> {
    let mut all = Vec::new();
    for environment in &settings.environments {
        for (place, contender) in settings.contenders.iter().enumerate() {
            let factor = 1.0 + place as f64;
            let trial = |index: usize| Trial {
                arrived: true,
                time: factor * (10.0 + 0.1 * (index + 1) as f64),
                deviation: factor * 0.001 * (index + 1) as f64,
                ..Trial::default()
            };
            all.push(Distribution {
                environment: environment.name.clone(),
                contender: contender.label(),
                trials: (0..count).map(trial).collect(),
            });
        }
    }
    all
}

fn draw(figure: Figure, count: usize) -> String {
    let settings = settings();
    svg(figure, "comparison-3", &settings, &distributions(&settings, count)).unwrap()
}

/// What a place on a logarithmic axis means, from its first and last tick label.
fn logarithmic_ruler(panel: Node<'_, '_>) -> impl Fn(f64) -> f64 {
    let is_label = |it: &Node<'_, '_>| {
        it.attribute("text-anchor") == Some("end") && it.attribute("dy") == Some("0.5ex")
    };
    let ticks: Vec<(f64, f64)> = panel
        .descendants()
        .filter(is_label)
        .map(|it| (number(it, "y"), it.text().unwrap().trim().parse::<f64>().unwrap()))
        .collect();
    let (from, to) = (ticks[0], ticks[ticks.len() - 1]);
    move |place| from.1 * (to.1 / from.1).powf((place - from.0) / (to.0 - from.0))
}

/// Guards against a curve that says how often a value is smaller, or shifted by one trial.
#[test]
fn a_curve_says_how_often_more_is_seen() {
    let svg = draw(Figure::Deviation, 10);
    let document = Document::parse(&svg).unwrap();
    let panels = of_class(&document, "panel");
    assert_eq!(panels.len(), 4, "two environments, two horizons");
    let x = super::reading::ruler(panels[0], false);
    let y = logarithmic_ruler(panels[0]);
    // The bayesian contender of one slot stands at place 7 of the contenders: 7, 14, .. 70 mm.
    let place = settings().contenders.iter().position(|it| it.label() == "bayesian/1").unwrap();
    let factor = 1.0 + place as f64;
    let [line] = &super::reading::lines(panels[0], super::super::LEADING)[..] else { panic!() };
    for (index, corner) in line[1..].chunks_exact(2).enumerate() {
        let value = factor * (index + 1) as f64;
        assert!((x(corner[0].0) / value - 1.0).abs() < 0.02, "{} is not {value}", x(corner[0].0));
        let before = (10 - index) as f64 / 10.0;
        assert!((y(corner[0].1) / before - 1.0).abs() < 0.02, "{} is not {before}", y(corner[0].1));
        let after = f64::max(before - 0.1, 0.1);
        assert!((y(corner[1].1) / after - 1.0).abs() < 0.02, "{} is not {after}", y(corner[1].1));
    }
    assert_eq!(line.len(), 21);
}

#[test]
fn figures_say_what_they_show() {
    for (figure, wanted) in [
        (
            Figure::Deviation,
            &[
                "largest deviation (mm)",
                "share of trials that deviate farther",
                "bad-link, 20 slots",
            ][..],
        ),
        (
            Figure::Time,
            &["completion time (s)", "share of trials that take longer", "normal, 1 slot"],
        ),
        (
            Figure::Pareto,
            &[
                "median completion time (s)",
                "median largest deviation (mm)",
                "oracle",
                "no-compensation",
                "bad-link",
            ],
        ),
    ] {
        let svg = draw(figure, 30);
        let document = Document::parse(&svg).unwrap();
        let all = texts(document.root()).join("\n");
        for wanted in wanted.iter().chain(&[
            "comparison-3",
            "Scenario thesis, 30 trials",
            "seed 1",
            "bayesian",
        ]) {
            assert!(all.contains(wanted), "{figure:?} lacks {wanted}: {all}");
        }
        assert_eq!(Figure::named(figure.name()), Some(figure));
    }
    assert_eq!(Figure::named("colour"), None);
}

/// Everybody is there: a marker for each, hollow with one slot, and one in the legend for each name.
#[test]
fn every_contender_is_a_point() {
    let settings = settings();
    let document = draw(Figure::Pareto, 5);
    let document = Document::parse(&document).unwrap();
    let names = settings.contenders.iter().map(|it| it.name.as_str());
    let names: std::collections::BTreeSet<_> = names.collect();
    assert_eq!(of_class(&document, "legend").len(), names.len());
    let panels = of_class(&document, "panel");
    assert_eq!(panels.len(), 2);
    let discs = |panel: Node<'_, '_>, is_hollow: bool| {
        let of_fill = |it: &Node<'_, '_>| (it.attribute("fill") == Some("none")) == is_hollow;
        panel.descendants().filter(|it| it.has_tag_name("circle") && of_fill(it)).count()
    };
    for panel in panels {
        let of_discs = |slots: fn(usize) -> bool| {
            let is_disc = |name: &str| ["bayesian", "gp-mpc"].contains(&name);
            settings.contenders.iter().filter(|it| is_disc(&it.name) && slots(it.slots)).count()
        };
        assert_eq!(discs(panel, true), of_discs(|slots| slots == 1));
        assert_eq!(discs(panel, false), of_discs(|slots| slots > 1));
    }
}

#[test]
fn nothing_overlaps_and_everything_is_on_the_page() {
    for figure in Figure::ALL {
        for count in [1, 2, 15, 1000] {
            let svg = draw(figure, count);
            let document = Document::parse(&svg).unwrap();
            let root = document.root_element();
            let page = ["width", "height"].map(|name| number(root, name) * f64::from(UNIT));
            let panels = of_class(&document, "panel");
            let all: Vec<_> = panels
                .iter()
                .copied()
                .chain(of_class(&document, "legend"))
                .map(rectangle)
                .collect();
            for (place, one) in all.iter().enumerate() {
                assert!(one[0] >= 0.0 && one[1] >= 0.0 && one[2] <= page[0] && one[3] <= page[1]);
                for other in &all[..place] {
                    let apart = one[0] >= other[2]
                        || one[2] <= other[0]
                        || one[1] >= other[3]
                        || one[3] <= other[1];
                    assert!(apart, "{figure:?} {count}");
                }
            }
            panels.into_iter().for_each(nothing_overlaps_within);
        }
    }
}

#[test]
fn others_than_those_of_the_thesis_are_drawn_where_those_did_not_drive() {
    let mut settings = settings();
    settings.contenders.retain(|it| ["oracle", "stop-when-stale"].contains(&it.name.as_str()));
    let svg = svg(Figure::Time, "c", &settings, &distributions(&settings, 4)).unwrap();
    let document = Document::parse(&svg).unwrap();
    assert_eq!(of_class(&document, "legend").len(), 2);
    let nothing = svg_of_nothing(&settings);
    assert_eq!(nothing, Err(FigureError::NoTrials));
}

fn svg_of_nothing(settings: &ComparisonSettings) -> Result<String, FigureError> {
    svg(Figure::Pareto, "c", settings, &distributions(settings, 0))
}
