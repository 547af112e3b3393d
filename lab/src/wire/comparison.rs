//! Between the wire and core: what a request means, and what came of it.

use super::{
    Claim, Difference, Entry, EnvironmentReport, Progress, Quantities, Recognition, Reductions,
    Report, Request, Scenario, Spec, Stage, spec,
};
use crate::body;
use crate::check::{Check, Checked};
use crate::estimate::Estimate;
use crate::named::Known;
use crate::number::known as finite;
use crate::problem::{Problems, reason};
use umwelt_core::comparison::{
    self, BASELINE, CHAMPION, ComparisonSettings, Contender, PROMISED_DEVIATION, PROMISED_TIME,
    method_names,
};
use umwelt_core::evolution;
use umwelt_core::settings::Prior;

impl Request {
    /// Reads the body of a POST where the priors are known: the request, and what is to be run. `known` says what a
    /// name stands for, as [`crate::prior::built_in`] does.
    ///
    /// # Errors
    /// Every problem as [`Request::read`] and [`Request::to_core`] have it, all at once.
    pub fn read_known(
        json: &[u8],
        known: impl Fn(&str) -> Known<Prior>,
    ) -> Result<(Self, ComparisonSettings), Problems> {
        body::read_resolved(json, |request: &Self, check| request.resolve(known, check))
    }

    /// What is to be run, all filled in.
    ///
    /// # Errors
    /// Every value out of its range, every method and prior that nobody knows, and what contradicts the rest.
    pub fn to_core(
        &self,
        known: impl Fn(&str) -> Known<Prior>,
    ) -> Result<ComparisonSettings, Problems> {
        let mut check = Check::default();
        self.check(&mut check);
        let settings = self.resolve(known, &mut check);
        check.finish()?;
        Ok(settings)
    }

    /// The scenario with what was said in its place; `check` knows what is wrong with it.
    fn resolve(
        &self,
        known: impl Fn(&str) -> Known<Prior>,
        check: &mut Check,
    ) -> ComparisonSettings {
        let mut settings = self.scenario.unwrap_or_default().settings();
        if let Some(trials) = self.trials {
            settings.trials = usize::try_from(trials).unwrap_or(usize::MAX);
        }
        settings.seed = self.seed.unwrap_or(settings.seed);
        let prior = self.prior.as_ref().and_then(|name| {
            let prior = check.known("prior", name, reason::UNKNOWN_PRIOR, known)?;
            Some((name, prior))
        });
        match self.contenders(&settings.contenders, check) {
            Some(contenders) => settings.contenders = contenders,
            // What else there is to say depends on who is compared.
            None => return settings,
        }
        if let Some((name, prior)) = prior {
            let mut bayesian: Vec<_> =
                settings.contenders.iter_mut().filter(|it| it.name == CHAMPION).collect();
            // By itself it comes in two, by slots.
            if name != spec::DEFAULT_PRIOR {
                bayesian.iter_mut().for_each(|it| it.prior = prior);
            }
            let remedy = format!("it is that of {CHAMPION}: compare that too, or leave it out");
            check.agrees("prior", !bayesian.is_empty(), name.as_str(), &remedy);
        }
        self.agree(&settings, check);
        check.ok("", settings.check());
        settings
    }

    /// Those of `all` that are asked for, in the order of `all`; none where nobody knows one of them.
    fn contenders(&self, all: &[Contender], check: &mut Check) -> Option<Vec<Contender>> {
        let Some(methods) = &self.methods else { return Some(all.to_vec()) };
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
            } else if meant.iter().any(|&place| asked[place]) && !methods[..index].contains(method)
            {
                let remedy = "it stands under another name already: name it once";
                check.report(reason::INCONSISTENT, &field, method.as_str(), remedy);
            }
            meant.into_iter().for_each(|place| asked[place] = true);
        }
        let chosen = all.iter().zip(asked).filter(|(_, asked)| *asked);
        all_known.then(|| chosen.map(|(contender, _)| contender.clone()).collect())
    }

    /// What only the whole can say.
    fn agree(&self, settings: &ComparisonSettings, check: &mut Check) {
        let ComparisonSettings { contenders, environments, trials, .. } = settings;
        let (episodes, most) = (settings.compared_episodes(), spec::MAX_EPISODES);
        let cells = contenders.len() as u64 * environments.len() as u64;
        // A number of trials that is none is reported by the check of the field.
        if episodes <= most || cells == 0 || !spec::TRIALS.contains(&(*trials as u64)) {
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

impl Scenario {
    /// What is run where nothing else is said.
    pub fn settings(self) -> ComparisonSettings {
        ComparisonSettings::scenario(self.name()).expect("a test asks for each of them")
    }
}

impl Spec {
    /// What was asked for, all filled in; `prior` is the name of the prior of the contender `bayesian`
    /// ([`Request::prior_name`]).
    pub fn from_core(core: &ComparisonSettings, prior: &str) -> Self {
        let has_prior = core.contenders.iter().any(|it| it.name == CHAMPION);
        Self {
            scenario: core.scenario.clone(),
            methods: core.contenders.iter().map(Contender::label).collect(),
            environments: core.environments.iter().map(|it| it.name.clone()).collect(),
            trials: core.trials as u64,
            seed: core.seed,
            time_limit_s: core.time_limit,
            prior: has_prior.then(|| prior.to_owned()),
        }
    }
}

impl Progress {
    /// Of a comparison that waits for its turn: of core's, not begun.
    pub fn queued(core: &comparison::Comparison) -> Self {
        Self { stage: Stage::Queued, ..Self::of(core, 0.0, None) }
    }

    /// Of a comparison after `elapsed_s` and with `remaining_s` to go.
    pub fn of(core: &comparison::Comparison, elapsed_s: f64, remaining_s: Option<f64>) -> Self {
        let trials = core.settings().trials as u64;
        let (stage, trials_done) = match core.stage() {
            comparison::Stage::Reference => (Stage::Reference, 0),
            comparison::Stage::Trials { done } => (Stage::Trials, done as u64),
            comparison::Stage::Done => (Stage::Done, trials),
        };
        Self {
            stage,
            trials_done,
            trials,
            episodes: core.episodes(),
            total_episodes: core.total_episodes(),
            elapsed_s,
            remaining_s: remaining_s.and_then(finite),
        }
    }
}

type CoreQuantities = comparison::Quantities<evolution::Estimate>;

impl From<CoreQuantities> for Quantities {
    fn from(core: CoreQuantities) -> Self {
        Self { mean: core.mean.into(), median: core.median.into(), p90: core.p90.into() }
    }
}

impl From<CoreQuantities> for Reductions {
    fn from(core: CoreQuantities) -> Self {
        let comparison::Quantities { mean, median, p90 } = core.map(Estimate::known);
        Self { mean, median, p90 }
    }
}

impl From<&comparison::Difference> for Difference {
    fn from(core: &comparison::Difference) -> Self {
        Self {
            against: core.against.clone(),
            time_s: core.absolute.time.into(),
            deviation_m: core.absolute.deviation.into(),
            time_reduction: core.reduction.time.into(),
            deviation_reduction: core.reduction.deviation.into(),
        }
    }
}

impl From<comparison::Recognition> for Recognition {
    fn from(core: comparison::Recognition) -> Self {
        Self { share: core.share, median_samples: core.median, p90_samples: core.p90 }
    }
}

impl From<&comparison::Entry> for Entry {
    fn from(core: &comparison::Entry) -> Self {
        Self {
            contender: core.contender.clone(),
            arrived: core.arrived.into(),
            time_s: core.summary.time.into(),
            deviation_m: core.summary.deviation.into(),
            recognition: core.recognition.map(Recognition::from),
            coverage: core.coverage.map(Estimate::from),
            difference: core.difference.as_ref().map(Difference::from),
        }
    }
}

/// A claim, with who arrived in its environment as `report` has it.
fn claim(core: &comparison::Claim, report: &comparison::Report) -> Claim {
    let label = |name: &str| format!("{name}/{}", core.slots);
    let (contender, against) = (label(CHAMPION), label(BASELINE));
    let here = report.environments.iter().find(|it| it.environment == core.environment);
    let arrived = |label: &str| {
        let mut entries = here.iter().flat_map(|here| &here.entries);
        // Whoever is claimed for has driven there.
        entries.find(|it| it.contender == label).map_or(0.0, |it| it.arrived.mean)
    };
    let claim = Claim {
        environment: core.environment.clone(),
        slots: core.slots as u64,
        arrived: arrived(&contender),
        against_arrived: arrived(&against),
        contender,
        against,
        deviation_reduction: core.deviation.into(),
        time_reduction: core.time.into(),
        promised_deviation: PROMISED_DEVIATION,
        promised_time: PROMISED_TIME,
        verdict: String::new(),
    };
    Claim { verdict: claim.in_words(), ..claim }
}

impl From<&comparison::Report> for Report {
    fn from(core: &comparison::Report) -> Self {
        let environments = core.environments.iter().map(|it| EnvironmentReport {
            environment: it.environment.clone(),
            entries: it.entries.iter().map(Entry::from).collect(),
        });
        Self {
            trials: core.trials as u64,
            environments: environments.collect(),
            claims: core.claims.iter().map(|it| claim(it, core)).collect(),
        }
    }
}
