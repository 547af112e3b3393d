//! Comparisons: what a request means, and how results are shown.

use super::pace::Pace;
use super::verdict::judged;
use crate::comparison::{
    self as lab, BASELINE, CHAMPION, ComparisonSettings, Contender, PROMISED_DEVIATION,
    PROMISED_TIME, method_names,
};
use crate::evolution;
use umwelt_api::comparison::{
    Claim, DEFAULT_PRIOR, Difference, Entry, EnvironmentReport, Estimate, MAX_EPISODES, Progress,
    Quantities, Recognition, Reductions, Report, Request, Scenario, Spec, Stage, TRIALS,
};
use umwelt_api::problem::reason;
use umwelt_api::{Check, Checked, Known, Problems, Validate, body};
use umwelt_core::settings::Prior;

/// Reads the body of a POST where the priors are known: the request, and what is to be run. `known` says what a
/// name stands for, as [`built_in`](umwelt_api::prior::built_in) does.
///
/// # Errors
/// Every problem as [`Request::read`] and [`settings`] have it, all at once.
pub fn read(
    json: &[u8],
    known: impl Fn(&str) -> Known<Prior>,
) -> Result<(Checked<Request>, ComparisonSettings), Problems> {
    body::read_resolved(json, |request, check| resolve(request, known, check))
}

/// What is to be run for `request`, all filled in.
///
/// # Errors
/// Every value out of its range, every unknown method and prior, and what contradicts the rest.
pub fn settings(
    request: &Request,
    known: impl Fn(&str) -> Known<Prior>,
) -> Result<ComparisonSettings, Problems> {
    let mut check = Check::default();
    request.check(&mut check);
    let settings = resolve(request, known, &mut check);
    check.finish()?;
    Ok(settings)
}

/// The scenario with what was said in its place; `check` knows what is wrong with it.
fn resolve(
    request: &Request,
    known: impl Fn(&str) -> Known<Prior>,
    check: &mut Check,
) -> ComparisonSettings {
    let mut settings = scenario(request.scenario.unwrap_or_default());
    if let Some(trials) = request.trials {
        settings.trials = usize::try_from(trials).unwrap_or(usize::MAX);
    }
    settings.seed = request.seed.unwrap_or(settings.seed);
    let prior = request.prior.as_ref().and_then(|name| {
        let prior = check.known("prior", name, reason::UNKNOWN_PRIOR, known)?;
        Some((name, prior))
    });
    match contenders(request, &settings.contenders, check) {
        Some(contenders) => settings.contenders = contenders,
        // What else there is to say depends on who is compared.
        None => return settings,
    }
    if let Some((name, prior)) = prior {
        let mut bayesian: Vec<_> =
            settings.contenders.iter_mut().filter(|it| it.name == CHAMPION).collect();
        // By itself it comes in two, by slots.
        if name != DEFAULT_PRIOR {
            bayesian.iter_mut().for_each(|it| it.prior = prior);
        }
        let remedy = format!("it is that of {CHAMPION}: compare that too, or leave it out");
        check.agrees("prior", !bayesian.is_empty(), name.as_str(), &remedy);
    }
    agree(&settings, check);
    check.ok("", settings.check());
    settings
}

/// Those of `all` that are asked for, in the order of `all`; none where one of them is unknown.
fn contenders(request: &Request, all: &[Contender], check: &mut Check) -> Option<Vec<Contender>> {
    let Some(methods) = &request.methods else { return Some(all.to_vec()) };
    let mut asked = vec![false; all.len()];
    let mut all_known = true;
    for (index, method) in methods.iter().enumerate() {
        let is_meant = |it: &Contender| it.name == *method || it.label() == *method;
        let meant: Vec<_> = (0..all.len()).filter(|&place| is_meant(&all[place])).collect();
        let field = format!("methods[{index}]");
        if meant.is_empty() {
            let remedy = known_methods(method, all);
            check.report(reason::UNKNOWN_METHOD, &field, method.as_str(), remedy);
            all_known = false;
        // The same text twice is reported by the check of the field.
        } else if meant.iter().any(|&place| asked[place]) && !methods[..index].contains(method) {
            let remedy = "it stands under another name already: name it once";
            check.report(reason::INCONSISTENT, &field, method.as_str(), remedy);
        }
        meant.into_iter().for_each(|place| asked[place] = true);
    }
    let chosen = all.iter().zip(asked).filter(|(_, asked)| *asked);
    all_known.then(|| chosen.map(|(contender, _)| contender.clone()).collect())
}

/// What only the whole can say.
fn agree(settings: &ComparisonSettings, check: &mut Check) {
    let ComparisonSettings { contenders, environments, trials, .. } = settings;
    let (episodes, most) = (settings.compared_episodes(), MAX_EPISODES);
    let cells = contenders.len() as u64 * environments.len() as u64;
    // A number of trials that is none is reported by the check of the field.
    if episodes <= most || cells == 0 || !TRIALS.contains(&(*trials as u64)) {
        return;
    }
    let remedy = format!(
        "{} contenders x {} environments x {trials} trials are {episodes} episodes, at most {most}: use at most \
         {} trials, or fewer methods",
        contenders.len(),
        environments.len(),
        most / cells
    );
    check.agrees("trials", false, *trials as u64, &remedy);
}

/// What to use instead of `method`: its numbers of slots where they are what is wrong, else every method.
fn known_methods(method: &str, all: &[Contender]) -> String {
    let name = method.split('/').next().unwrap_or_default();
    let labels: Vec<_> = all.iter().filter(|it| it.name == name).map(Contender::label).collect();
    if labels.is_empty() {
        let names: Vec<_> = method_names().collect();
        format!("known: {}; with slots as {CHAMPION}/20", names.join(", "))
    } else {
        format!("known: {name}, {}", labels.join(", "))
    }
}

/// What is run where nothing but the scenario is said.
pub fn scenario(scenario: Scenario) -> ComparisonSettings {
    ComparisonSettings::scenario(scenario.name()).expect("a test asks for each of them")
}

/// What was asked for, all filled in; `prior` is the name of the prior of the contender `bayesian`
/// ([`Request::prior_name`]).
pub fn spec(settings: &ComparisonSettings, prior: &str) -> Spec {
    let has_prior = settings.contenders.iter().any(|it| it.name == CHAMPION);
    Spec {
        scenario: settings.scenario.clone(),
        methods: settings.contenders.iter().map(Contender::label).collect(),
        environments: settings.environments.iter().map(|it| it.name.clone()).collect(),
        trials: settings.trials as u64,
        seed: settings.seed,
        time_limit_s: settings.time_limit,
        prior: has_prior.then(|| prior.to_owned()),
    }
}

/// How far a comparison has got that is in this stage; without a stage it has not begun.
pub fn progress(
    settings: &ComparisonSettings,
    reached: Option<lab::Stage>,
    pace: Pace,
) -> Progress {
    let trials = settings.trials as u64;
    let (stage, trials_done) = match reached {
        None => (Stage::Queued, 0),
        Some(lab::Stage::Reference) => (Stage::Reference, 0),
        Some(lab::Stage::Trials { done }) => (Stage::Trials, done as u64),
        Some(lab::Stage::Done) => (Stage::Done, trials),
    };
    let Pace { episodes, total_episodes, elapsed_s, remaining_s } = pace;
    let remaining_s = remaining_s.filter(|it| it.is_finite());
    Progress { stage, trials_done, trials, episodes, total_episodes, elapsed_s, remaining_s }
}

type Estimated = lab::Quantities<evolution::Estimate>;

impl From<Estimated> for Quantities {
    fn from(lab: Estimated) -> Self {
        Self { mean: lab.mean.into(), median: lab.median.into(), p90: lab.p90.into() }
    }
}

impl From<Estimated> for Reductions {
    fn from(lab: Estimated) -> Self {
        let lab::Quantities { mean, median, p90 } = lab.map(finite);
        Self { mean, median, p90 }
    }
}

impl From<&lab::Difference> for Difference {
    fn from(lab: &lab::Difference) -> Self {
        Self {
            against: lab.against.clone(),
            time_s: lab.absolute.time.into(),
            deviation_m: lab.absolute.deviation.into(),
            time_reduction: lab.reduction.time.into(),
            deviation_reduction: lab.reduction.deviation.into(),
        }
    }
}

impl From<lab::Recognition> for Recognition {
    fn from(lab: lab::Recognition) -> Self {
        Self { share: lab.share, median_samples: lab.median, p90_samples: lab.p90 }
    }
}

impl From<&lab::Entry> for Entry {
    fn from(lab: &lab::Entry) -> Self {
        Self {
            contender: lab.contender.clone(),
            arrived: lab.arrived.into(),
            time_s: lab.summary.time.into(),
            deviation_m: lab.summary.deviation.into(),
            recognition: lab.recognition.map(Recognition::from),
            coverage: lab.coverage.map(Estimate::from),
            difference: lab.difference.as_ref().map(Difference::from),
        }
    }
}

/// The estimate where all of it is finite; `null` on the wire otherwise.
fn finite(estimate: evolution::Estimate) -> Option<Estimate> {
    let is_finite = [estimate.mean, estimate.low, estimate.high].iter().all(|it| it.is_finite());
    is_finite.then(|| estimate.into())
}

/// A claim, with who arrived in its environment as `report` has it.
fn claim(lab: &lab::Claim, report: &lab::Report) -> Claim {
    let label = |name: &str| format!("{name}/{}", lab.slots);
    let (contender, against) = (label(CHAMPION), label(BASELINE));
    let here = report.environments.iter().find(|it| it.environment == lab.environment);
    let arrived = |label: &str| {
        let mut entries = here.iter().flat_map(|here| &here.entries);
        // The contender of a claim has driven there.
        entries.find(|it| it.contender == label).map_or(0.0, |it| it.arrived.mean)
    };
    let claim = Claim {
        environment: lab.environment.clone(),
        slots: lab.slots as u64,
        arrived: arrived(&contender),
        against_arrived: arrived(&against),
        contender,
        against,
        deviation_reduction: lab.deviation.into(),
        time_reduction: lab.time.into(),
        promised_deviation: PROMISED_DEVIATION,
        promised_time: PROMISED_TIME,
        verdict: String::new(),
        findings: Vec::new(),
    };
    judged(claim)
}

impl From<&lab::Report> for Report {
    fn from(lab: &lab::Report) -> Self {
        let environments = lab.environments.iter().map(|it| EnvironmentReport {
            environment: it.environment.clone(),
            entries: it.entries.iter().map(Entry::from).collect(),
        });
        Self {
            trials: lab.trials as u64,
            environments: environments.collect(),
            claims: lab.claims.iter().map(|it| claim(it, lab)).collect(),
        }
    }
}
