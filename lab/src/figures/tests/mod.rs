//! Figures read back as a reader would: from their text, their ticks and their lines.

mod comparison;
mod reading;

use super::evolution::{Figure, svg};
use super::{FigureError, LEADING, SECOND, Stroke, UNIT};
use crate::evolution::{EvolutionSettings, Generation, GenerationEnvironment, Optimizer, Spread};
use proptest::prelude::*;
use reading::{lines, nothing_overlaps_within, number, of_class, rectangle, ruler, texts, tops};
use roxmltree::{Document, Node};
use umwelt_core::settings::Prior;

fn settings() -> EvolutionSettings {
    EvolutionSettings::preset("quick").unwrap()
}

/// Generations whose values are `of(generation, environment)`: the mean deviation in m, from which the rest follows.
fn generations(
    count: usize,
    names: &[String],
    of: impl Fn(usize, usize) -> f64,
) -> Vec<Generation> {
    let environment = |index: usize, place: usize| {
        let mean = of(index, place);
        GenerationEnvironment {
            name: names[place].clone(),
            deviation: Spread { best: 0.5 * mean, mean },
            time: Spread { best: 200.0 * mean, mean: 300.0 * mean },
            arrived: 1.0,
        }
    };
    let generation = |index: usize| Generation {
        index,
        fitness: Spread { best: 40.0 * of(index, 0), mean: 20.0 * of(index, 0) },
        prior: Prior::default(),
        environments: (0..names.len()).map(|place| environment(index, place)).collect(),
    };
    (0..count).map(generation).collect()
}

fn named(count: usize) -> Vec<String> {
    (0..count).map(|place| format!("environment-{place}")).collect()
}

/// Falls from 50 mm to 20 mm, a little more in each environment.
fn falling(index: usize, place: usize) -> f64 {
    (0.020 + 0.030 / (1.0 + index as f64)) * (1.0 + 0.01 * place as f64)
}

fn draw(figure: Figure, generations: &[Generation]) -> String {
    svg(figure, "evolution-12", &settings(), generations).unwrap()
}

#[test]
fn a_ruler_on_the_page_reads_the_data_back() {
    let generations = generations(12, &named(3), falling);
    for (figure, factor, best) in [
        (Figure::Deviation, 1000.0, 0.5),
        (Figure::Time, 300.0, 2.0 / 3.0),
        (Figure::Fitness, 20.0, 2.0),
    ] {
        let svg = draw(figure, &generations);
        let document = Document::parse(&svg).unwrap();
        for (place, panel) in of_class(&document, "panel").into_iter().enumerate() {
            let (x, y) = (ruler(panel, false), ruler(panel, true));
            for (stroke, factor) in [(LEADING, factor), (SECOND, factor * best)] {
                let [line] = &lines(panel, stroke)[..] else { panic!("one line in {figure:?}") };
                assert_eq!(line.len(), 12);
                for (index, point) in line.iter().enumerate() {
                    let value = factor * falling(index, place);
                    // A tenth of a pixel either way, on an axis of at least 150.
                    assert!(
                        (x(point.0) - index as f64).abs() < 0.02,
                        "{figure:?}: {point:?} is not generation {index}"
                    );
                    assert!(
                        (y(point.1) / value - 1.0).abs() < 0.01,
                        "{figure:?}: {} is not {value}",
                        y(point.1)
                    );
                }
                assert!(line.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 < pair[1].1));
            }
        }
    }
}

#[test]
fn a_figure_says_what_it_shows_in_searchable_text() {
    let settings =
        EvolutionSettings { optimizer: Optimizer::CmaEs, seed: 4711, population: 37, ..settings() };
    let generations = generations(5, &named(2), falling);
    for (figure, axis) in [
        (Figure::Deviation, "largest deviation (mm)"),
        (Figure::Time, "completion time (s)"),
        (Figure::Fitness, "fitness (fixed-normal = 1)"),
    ] {
        let svg = svg(figure, "evolution-12", &settings, &generations).unwrap();
        let document = Document::parse(&svg).unwrap();
        let all = texts(document.root()).join("\n");
        for wanted in [
            "evolution-12",
            "CMA-ES",
            "seed 4711",
            "population 37",
            "5 of 12 generations",
            "environment-0",
            "environment-1",
            "mean over all individuals",
            axis,
            "generation\n",
        ] {
            assert!(format!("{all}\n").contains(wanted), "{figure:?} lacks {wanted}: {all}");
        }
        let legends = if figure == Figure::Fitness { 3 } else { 2 };
        assert_eq!(of_class(&document, "legend").len(), legends);
        for node in document.descendants() {
            let family = node.attribute("font-family");
            assert!(family.is_none_or(|it| it == "sans-serif"), "{family:?}");
            let refers =
                |it: &str| it.contains("://") || it.contains("url(") || it.contains("@import");
            assert!(!node.attributes().any(|it| it.name() == "href" || refers(it.value())));
            assert!(!["image", "style", "script", "use"].contains(&node.tag_name().name()));
        }
        assert_eq!(Figure::named(figure.name()), Some(figure));
    }
    assert_eq!(Figure::named("colour"), None);
}

#[test]
fn names_of_users_are_escaped_and_whole() {
    let awkward =
        ["a<b & \"c\" 'd' ]]>", "--><script>", "&amp;&#0;", "wide ümläut 試験", &"W".repeat(63)];
    let names: Vec<String> = awkward.map(str::to_owned).to_vec();
    let svg = draw(Figure::Time, &generations(3, &names, falling));
    let document = Document::parse(&svg).unwrap();
    let panels = of_class(&document, "panel");
    assert_eq!(panels.len(), names.len());
    for (panel, name) in panels.into_iter().zip(&names) {
        let is_bold = |it: &Node<'_, '_>| it.attribute("font-weight") == Some("bold");
        let mut titles: Vec<_> = panel.descendants().filter(is_bold).collect();
        titles.sort_by(|a, b| number(*a, "y").total_cmp(&number(*b, "y")));
        let title: String = titles.into_iter().map(|it| it.text().unwrap().trim()).collect();
        assert_eq!(title.replace(' ', ""), name.replace(' ', ""));
    }
}

#[test]
fn nothing_to_draw_is_said() {
    let no_environments = generations(2, &[], falling);
    for figure in Figure::ALL {
        assert_eq!(svg(figure, "e", &settings(), &[]), Err(FigureError::NoGenerations));
        assert_eq!(
            svg(figure, "e", &settings(), &no_environments),
            Err(FigureError::NoEnvironments)
        );
    }
    assert!(FigureError::NoGenerations.to_string().contains("no generation has ended"));
}

#[test]
fn what_is_not_finite_leaves_a_gap() {
    let mut generations = generations(9, &named(2), falling);
    for (index, value) in [(2, f64::NAN), (4, f64::INFINITY), (8, f64::NEG_INFINITY)] {
        generations[index].environments[0].deviation.mean = value;
        generations[index].fitness.mean = value;
    }
    generations
        .iter_mut()
        .for_each(|it| it.environments[1].deviation = Spread { best: f64::NAN, mean: f64::NAN });
    for figure in [Figure::Deviation, Figure::Fitness] {
        let svg = draw(figure, &generations);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let document = Document::parse(&svg).unwrap();
        let panels = of_class(&document, "panel");
        // 0 1 | 3 | 5 6 7: the 3 stands alone, as a marker.
        let found: Vec<usize> = lines(panels[0], LEADING).iter().map(Vec::len).collect();
        assert_eq!(found, [2, 3], "{figure:?}");
        let discs = panels[0].descendants().filter(|it| it.has_tag_name("circle"));
        assert_eq!(discs.count(), 6);
        let [second] = &lines(panels[0], SECOND)[..] else { panic!("the other line has no gap") };
        assert_eq!(second.len(), 9);
        if let Some(empty) = panels.get(1) {
            assert!(texts(*empty).contains(&"no finite value".to_owned()));
            assert!(lines(*empty, LEADING).is_empty());
        }
    }
}

#[test]
fn any_number_of_generations_is_drawn() {
    for count in [1, 2, 31, 32, 100, 200, 201, 1000] {
        let svg = draw(Figure::Deviation, &generations(count, &named(2), falling));
        let document = Document::parse(&svg).unwrap();
        for panel in of_class(&document, "panel") {
            let discs = panel.descendants().filter(|it| it.has_tag_name("circle")).count();
            assert_eq!(discs, if count <= 31 { count } else { 0 });
            let found: Vec<usize> = lines(panel, LEADING).iter().map(Vec::len).collect();
            let pale: Vec<usize> = lines(panel, LEADING.pale()).iter().map(Vec::len).collect();
            assert_eq!(found, if count > 1 { vec![count] } else { vec![] });
            assert_eq!(pale, if count > 200 { vec![count] } else { vec![] });
        }
        let has_note = svg.contains("running mean over");
        assert_eq!(has_note, count > 200, "{count}");
    }
}

#[test]
fn panels_share_a_scale_unless_it_would_press_one_flat() {
    let note = "The vertical scale differs";
    let alike = draw(Figure::Time, &generations(9, &named(3), falling));
    assert_eq!(tops(&alike), [20.0; 3]);
    assert!(!alike.contains(note));
    let far_apart = |index, place: usize| falling(index, 0) * [1.0, 0.1, 0.7][place];
    let apart = draw(Figure::Time, &generations(9, &named(3), far_apart));
    assert_eq!(tops(&apart), [15.0, 1.5, 15.0]);
    assert!(apart.contains(note));
    let one_is_empty = |index, place| if place == 1 { f64::NAN } else { falling(index, 0) };
    let empty = draw(Figure::Time, &generations(9, &named(3), one_is_empty));
    assert_eq!(tops(&empty), [15.0; 3]);
    assert!(!empty.contains(note));
}

#[test]
fn lines_are_told_apart_without_colour() {
    let svg = draw(Figure::Time, &generations(40, &named(2), falling));
    let document = Document::parse(&svg).unwrap();
    let dash_of = |stroke: Stroke| {
        let points = |it: &Node<'_, '_>| {
            it.has_tag_name("polyline")
                && it.attribute("stroke-width") == Some(&stroke.width.to_string())
        };
        let all = document.descendants().filter(points);
        let dash = |it: Node<'_, '_>| {
            it.ancestors().find_map(|it| it.attribute("stroke-dasharray").map(str::to_owned))
        };
        let mut dashes: Vec<_> = all.map(dash).collect();
        dashes.dedup();
        dashes
    };
    assert_eq!(dash_of(LEADING), [None]);
    assert_eq!(dash_of(SECOND), [Some("45 25".to_owned())]);
}

#[test]
fn the_running_mean_is_that_of_its_neighbours() {
    let values = [1.0, 5.0, 3.0, f64::NAN, 8.0, 2.0];
    let points = values.iter().enumerate().map(|(x, y)| (x as f64, *y)).collect();
    let mean = super::Curve { stroke: LEADING, points }.running_mean(1);
    let finite: Vec<_> = mean.iter().filter(|(x, _)| x.is_finite()).copied().collect();
    assert_eq!(finite, [(0.0, 3.0), (1.0, 3.0), (2.0, 4.0), (4.0, 5.0), (5.0, 5.0)]);
    assert!(mean[3].0.is_nan(), "the gap stays: {mean:?}");
}

#[test]
fn nothing_overlaps_in_any_number_of_environments() {
    for count in 1..=32 {
        let long = |place: usize| format!("{place}-{}", "Wide-and-long-name".repeat(3));
        for names in [named(count), (0..count).map(long).collect()] {
            let svg = draw(Figure::Time, &generations(1 + count * 9, &names, falling));
            let document = Document::parse(&svg).unwrap();
            let panels = of_class(&document, "panel");
            assert_eq!(panels.len(), count);
            let view: Vec<f64> = document
                .root_element()
                .attribute("viewBox")
                .unwrap()
                .split(' ')
                .map(|it| it.parse().unwrap())
                .collect();
            let legend = of_class(&document, "legend").into_iter().map(rectangle);
            let all: Vec<_> = panels.iter().map(|it| rectangle(*it)).chain(legend).collect();
            for (place, [left, top, right, bottom]) in all.iter().enumerate() {
                assert!(
                    *left >= 0.0 && *top >= 0.0 && *right <= view[2] && *bottom <= view[3],
                    "{count}: {all:?}"
                );
                for [other_left, other_top, other_right, other_bottom] in &all[..place] {
                    let apart = left >= other_right
                        || right <= other_left
                        || top >= other_bottom
                        || bottom <= other_top;
                    assert!(apart, "{count} environments: {all:?}");
                }
            }
            panels.into_iter().for_each(nothing_overlaps_within);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_the_numbers_and_names_the_figure_is_a_document(
        names in prop::collection::vec(prop::collection::vec(any::<char>(), 0..70).prop_map(String::from_iter), 1..8),
        values in prop::collection::vec(prop::num::f64::ANY, 1..40),
        first in prop_oneof![Just(0), any::<usize>()],
    ) {
        let mut generations = generations(values.len(), &names, |index, place| values[(index + place) % values.len()]);
        generations.iter_mut().for_each(|it| it.index = it.index.saturating_add(first));
        for figure in Figure::ALL {
            let svg = svg(figure, &names[0], &settings(), &generations).unwrap();
            let document = Document::parse(&svg).unwrap();
            for panel in of_class(&document, "panel") {
                let [left, top, right, bottom] = rectangle(panel);
                let within = |(x, y): &(f64, f64)| *x >= 0.0 && *x <= right - left && *y >= 0.0 && *y <= bottom - top;
                let lines = [LEADING, SECOND].map(|stroke| lines(panel, stroke).concat()).concat();
                prop_assert!(lines.iter().all(within), "{lines:?}");
            }
        }
    }
}

#[test]
fn a_page_is_a_page_of_pixels() {
    let svg = draw(Figure::Time, &generations(3, &named(6), falling));
    let document = Document::parse(&svg).unwrap();
    let root = document.root_element();
    let (width, height) = (number(root, "width"), number(root, "height"));
    let unit = f64::from(UNIT);
    assert_eq!(
        root.attribute("viewBox"),
        Some(&*format!("0 0 {} {}", width * unit, height * unit))
    );
    assert!(
        (600.0..1000.0).contains(&width) && (400.0..700.0).contains(&height),
        "{width} x {height}"
    );
}
