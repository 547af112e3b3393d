//! How an evolution went: thesis figures 6 and 7, and fitness.

use super::axis::{Axis, is_drawable};
use super::{Curve, FigureError, Heading, LEADING, Panel, REFERENCE, SECOND, Stroke, page};
use crate::evolution::{EvolutionSettings, Generation, GenerationEnvironment, Optimizer, Spread};

/// Panels share their vertical scale where the lowest of them still takes this share of the height.
const SHARED_SCALE: f64 = 0.4;

/// More generations than this are seen through their running mean: single ones no longer can be.
const LONG: usize = 200;

/// What a figure shows of each generation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Figure {
    /// Largest deviation, a panel for each environment (thesis figure 6).
    Deviation,
    /// Completion time, a panel for each environment (thesis figure 7).
    Time,
    /// Fitness over all environments.
    Fitness,
}

impl Figure {
    /// Each of them.
    pub const ALL: [Self; 3] = [Self::Deviation, Self::Time, Self::Fitness];

    /// Its name on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::Deviation => "deviation",
            Self::Time => "time",
            Self::Fitness => "fitness",
        }
    }

    /// The figure of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|figure| figure.name() == name)
    }

    fn title(self) -> &'static str {
        match self {
            Self::Deviation => "Largest deviation",
            Self::Time => "Completion time",
            Self::Fitness => "Fitness",
        }
    }

    fn axis_name(self) -> &'static str {
        match self {
            Self::Deviation => "largest deviation (mm)",
            Self::Time => "completion time (s)",
            Self::Fitness => "fitness (fixed-normal = 1)",
        }
    }

    /// What everything is measured by; always in sight.
    fn reference(self) -> Option<f64> {
        (self == Self::Fitness).then_some(1.0)
    }

    fn legend(self) -> Vec<(Stroke, String)> {
        let best = match self {
            Self::Deviation => "smallest of any individual",
            Self::Time => "shortest of any individual",
            Self::Fitness => "highest of any individual",
        };
        let mut legend = vec![(LEADING, "mean over all individuals"), (SECOND, best)];
        if self.reference().is_some() {
            legend.push((REFERENCE, "fixed-normal"));
        }
        legend.into_iter().map(|(stroke, label)| (stroke, label.to_owned())).collect()
    }
}

/// The figure as an SVG document: x is the generation from 0, one line for the mean of its individuals, one for the
/// best of them. What is not finite is left out. Axes are linear and from 0, so that a height is an amount and half
/// the height half the deviation: within an environment values stay within a decade, and a deviation may be 0, which
/// a logarithm cannot show. `evolution` is its name; the generations may be those of one that is still running.
///
/// # Errors
/// Where there is nothing to draw.
pub fn svg(
    figure: Figure,
    evolution: &str,
    settings: &EvolutionSettings,
    generations: &[Generation],
) -> Result<String, FigureError> {
    let first = generations.first().ok_or(FigureError::NoGenerations)?;
    if first.environments.is_empty() {
        return Err(FigureError::NoEnvironments);
    }
    let millimetres = |it: Spread| Spread { best: it.best * 1e3, mean: it.mean * 1e3 };
    let multiples = match figure {
        Figure::Deviation => multiples(generations, |it| millimetres(it.deviation)),
        Figure::Time => multiples(generations, |it| it.time),
        Figure::Fitness => {
            let spreads = generations.iter().map(|it| (it.index as f64, it.fitness)).collect();
            vec![Multiple { title: fitness_title(first), spreads }]
        }
    };
    let scale = Scale::of(figure, &multiples);
    let mut notes = Vec::new();
    if matches!(scale, Scale::Own(_)) {
        notes.push("The vertical scale differs from panel to panel.".to_owned());
    }
    if settings.optimizer == Optimizer::EmpiricalBayes {
        notes.push(
            "One individual in each generation has the trials of all: the mean is the best."
                .to_owned(),
        );
    }
    if let Some(reach) = reach(generations.len()) {
        let window = 2 * reach + 1;
        notes.push(format!(
            "Pale: each generation. Strong: running mean over {window} generations."
        ));
    }
    let heading = Heading {
        title: format!("{} over the generations of {evolution}", figure.title()),
        subtitle: subtitle(settings, generations.len()),
        notes,
        legend: figure.legend(),
    };
    let last = generations.iter().map(|it| it.index).max().unwrap_or(0);
    let x = Axis::counting("generation", last, 5);
    let panel = |(place, multiple): (usize, Multiple)| Panel {
        curves: curves(figure, &multiple, &x),
        title: multiple.title,
        x: x.clone(),
        y: scale.at(place).clone(),
        points: Vec::new(),
    };
    let panels: Vec<Panel> = multiples.into_iter().enumerate().map(panel).collect();
    page::document(&heading, &panels)
}

/// What one panel shows: generations with their spreads.
struct Multiple {
    title: String,
    spreads: Vec<(f64, Spread)>,
}

/// One for each environment of the first generation; the others have the same ones.
fn multiples(
    generations: &[Generation],
    of: impl Fn(&GenerationEnvironment) -> Spread,
) -> Vec<Multiple> {
    let named = generations.first().map_or(&[][..], |first| &first.environments);
    let of_environment = |(place, named): (usize, &GenerationEnvironment)| {
        let spread = |it: &Generation| Some((it.index as f64, of(it.environments.get(place)?)));
        let spreads = generations.iter().filter_map(spread).collect();
        Multiple { title: named.name.clone(), spreads }
    };
    named.iter().enumerate().map(of_environment).collect()
}

/// The vertical axes: one for all panels, so that they compare at a glance, unless it would press one of them flat.
enum Scale {
    Shared(Axis),
    Own(Vec<Axis>),
}

impl Scale {
    fn of(figure: Figure, multiples: &[Multiple]) -> Self {
        let values = |multiple: &Multiple| -> Vec<f64> {
            let all = multiple.spreads.iter().flat_map(|(_, spread)| [spread.best, spread.mean]);
            all.chain(figure.reference()).filter(|value| is_drawable(*value)).collect()
        };
        let values: Vec<Vec<f64>> = multiples.iter().map(values).collect();
        let axis = |values: &[f64]| Axis::from_zero(figure.axis_name(), values.iter().copied(), 5);
        let shared = axis(&values.concat());
        let own: Vec<Axis> = values.iter().map(|values| axis(values)).collect();
        let mut shown = own.iter().zip(&values).filter(|(_, values)| !values.is_empty());
        if shown.all(|(own, _)| own.top() >= SHARED_SCALE * shared.top()) {
            Self::Shared(shared)
        } else {
            Self::Own(own)
        }
    }

    fn at(&self, place: usize) -> &Axis {
        match self {
            Self::Shared(axis) => axis,
            Self::Own(axes) => &axes[place],
        }
    }
}

fn curves(figure: Figure, multiple: &Multiple, x: &Axis) -> Vec<Curve> {
    let curve = |stroke, of: fn(&Spread) -> f64| {
        let points = multiple.spreads.iter().map(|(x, spread)| (*x, of(spread))).collect();
        Curve { stroke, points }
    };
    let level = |level: f64| {
        let points = vec![(x.bottom(), level), (x.top(), level)];
        Curve { stroke: REFERENCE, points }
    };
    let mut curves = vec![curve(LEADING, |it| it.mean), curve(SECOND, |it| it.best)];
    if let Some(reach) = reach(multiple.spreads.len()) {
        let strong = |curve: &Curve| Curve { points: curve.running_mean(reach), ..*curve };
        let strong: Vec<Curve> = curves.iter().map(strong).collect();
        curves.iter_mut().for_each(|curve| curve.stroke = curve.stroke.pale());
        curves.extend(strong);
    }
    figure.reference().map(level).into_iter().chain(curves).collect()
}

/// How far the running mean of so many generations reaches to either side; none where all can be told apart.
fn reach(generations: usize) -> Option<usize> {
    (generations > LONG).then_some(generations / 100)
}

fn fitness_title(first: &Generation) -> String {
    let names: Vec<&str> = first.environments.iter().map(|it| it.name.as_str()).collect();
    match &names[..] {
        [only] => (*only).to_owned(),
        more if more.len() > 6 => format!("weighted mean over {} environments", more.len()),
        _ => format!("weighted mean of {}", names.join(", ")),
    }
}

fn subtitle(settings: &EvolutionSettings, ended: usize) -> String {
    let optimizer = match settings.optimizer {
        Optimizer::Genetic => "Genetic algorithm",
        Optimizer::CmaEs => "CMA-ES",
        Optimizer::EmpiricalBayes => "Empirical Bayes",
    };
    let EvolutionSettings { seed, population, generations, trials, .. } = settings;
    let of = if ended < *generations { format!("{ended} of ") } else { String::new() };
    let [of_generations, of_trials] =
        [*generations, *trials].map(|it| if it == 1 { "" } else { "s" });
    format!(
        "{optimizer}, seed {seed}, population {population}, {of}{generations} generation{of_generations}, \
         {trials} trial{of_trials} per individual"
    )
}
