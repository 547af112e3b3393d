//! What came of it: counters, of which some must be 0, as a table and as JSON.

use super::facts::Kept;
use super::judge::Counts;
use super::schedule::Kind;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// How robots went on after a fault.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Recoveries {
    /// Times in s from the end of the fault until the robot had moved again, where nothing else came in between.
    #[serde(skip)]
    pub times: Vec<f64>,
    /// How many these are.
    pub count: usize,
    /// Their quantiles in s.
    pub median_s: Option<f64>,
    /// 90 % are shorter.
    pub p90_s: Option<f64>,
    /// The longest.
    pub max_s: Option<f64>,
    /// Those that needed a resume that no one had asked for.
    pub resumed: u64,
    /// Those during which another fault came: no one knows what they took.
    pub interrupted: u64,
    /// Robots that did not move again.
    pub missing: u64,
}

impl Recoveries {
    /// Works out the quantiles.
    fn summed_up(mut self) -> Self {
        self.times.sort_by(f64::total_cmp);
        self.count = self.times.len();
        let quantile = |share: f64| {
            let last = self.times.len().checked_sub(1)?;
            self.times.get((last as f64 * share).round() as usize).copied()
        };
        (self.median_s, self.p90_s, self.max_s) = (quantile(0.5), quantile(0.9), quantile(1.0));
        self
    }
}

/// What is counted beside the robots' judges.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Injections made.
    pub injected: BTreeMap<Kind, u64>,
    /// Injections that this machine does not allow.
    pub skipped: BTreeMap<Kind, u64>,
    /// How robots went on.
    pub recoveries: BTreeMap<Kind, Recoveries>,
    /// Stops that were acknowledged as not kept: they act, and need not outlive the server.
    pub stops_not_kept: u64,
    /// Agents, and servers, that ended though no one told them to.
    pub agents_ended: u64,
    /// See above.
    pub servers_ended: u64,
    /// Servers that did not end in time when told to.
    pub servers_hung: u64,
    /// Tasks that began anew though no one told them to.
    pub resets: u64,
    /// Names of alarms that were shown, and how often.
    pub alarms: BTreeMap<String, u64>,
    /// How often the harness itself stood still, and for how long at most in s.
    pub stalls: u64,
    /// See above.
    pub longest_stall: f64,
    /// What went wrong in words.
    pub told: Vec<String>,
}

/// The whole of it.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Seed of the schedule.
    pub seed: u64,
    /// How many robots drove.
    pub robots: usize,
    /// How long it took in s.
    pub wall_time_s: f64,
    /// Injections made, per kind.
    pub injections: BTreeMap<Kind, u64>,
    /// Injections that this machine does not allow, per kind.
    pub skipped: BTreeMap<Kind, u64>,
    /// Facts that were acknowledged.
    pub facts: Kept,
    /// What the robots did.
    pub motion: Counts,
    /// Stops that were acknowledged as not kept.
    pub stops_not_kept: u64,
    /// Agents that ended by themselves.
    pub agents_ended: u64,
    /// Servers that ended by themselves.
    pub servers_ended: u64,
    /// Servers that did not end in time when told to.
    pub servers_hung: u64,
    /// Tasks that began anew though no one told them to.
    pub resets: u64,
    /// Robots that did not move again after a fault.
    pub not_recovered: u64,
    /// How robots went on, per kind.
    pub recoveries: BTreeMap<Kind, Recoveries>,
    /// Alarms that were shown, per name.
    pub alarms: BTreeMap<String, u64>,
    /// How often the harness itself stood still.
    pub stalls: u64,
    /// The longest of it in s.
    pub longest_stall_s: f64,
    /// What went wrong in words.
    pub told: Vec<String>,
}

impl Report {
    /// Sums up.
    pub fn new(
        seed: u64,
        robots: usize,
        wall_time: f64,
        tally: Tally,
        all: (Kept, Counts),
    ) -> Self {
        let (facts, mut motion) = all;
        let recoveries: BTreeMap<Kind, Recoveries> =
            tally.recoveries.into_iter().map(|(kind, it)| (kind, it.summed_up())).collect();
        let told = [std::mem::take(&mut motion.told), facts.told.clone(), tally.told].concat();
        Self {
            seed,
            robots,
            wall_time_s: wall_time,
            injections: tally.injected,
            skipped: tally.skipped,
            facts,
            motion,
            stops_not_kept: tally.stops_not_kept,
            agents_ended: tally.agents_ended,
            servers_ended: tally.servers_ended,
            servers_hung: tally.servers_hung,
            resets: tally.resets,
            not_recovered: recoveries.values().map(|it| it.missing).sum(),
            recoveries,
            alarms: tally.alarms,
            stalls: tally.stalls,
            longest_stall_s: tally.longest_stall,
            told,
        }
    }

    /// The counters that must be 0.
    pub fn must_be_zero(&self) -> [(&'static str, u64); 8] {
        [
            ("acknowledged facts lost", self.facts.lost),
            ("stops undone", self.motion.stops_undone),
            ("limits broken", self.motion.limits_broken),
            ("blind for more than 2 s", self.motion.blind.values().sum()),
            ("agents that ended by themselves", self.agents_ended),
            ("servers that ended by themselves", self.servers_ended),
            ("servers that did not end when told to", self.servers_hung),
            ("robots that did not go on", self.not_recovered),
        ]
    }

    /// Whether they are.
    pub fn is_clean(&self) -> bool {
        self.must_be_zero().iter().all(|(_, count)| *count == 0)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = |time: Option<f64>| time.map_or("-".into(), |time| format!("{time:.2}"));
        writeln!(
            f,
            "{:<16} {:>8} {:>7} {:>9} {:>8} {:>8} {:>8} {:>7}",
            "injected", "count", "skipped", "recovered", "median s", "90 % s", "max s", "resumed"
        )?;
        for kind in Kind::ALL {
            let count = |counts: &BTreeMap<Kind, u64>| counts.get(&kind).copied().unwrap_or(0);
            let it = self.recoveries.get(&kind).cloned().unwrap_or_default();
            writeln!(
                f,
                "{:<16} {:>8} {:>7} {:>9} {:>8} {:>8} {:>8} {:>7}",
                name(kind),
                count(&self.injections),
                count(&self.skipped),
                it.count,
                seconds(it.median_s),
                seconds(it.p90_s),
                seconds(it.max_s),
                it.resumed
            )?;
        }
        let (facts, motion) = (&self.facts, &self.motion);
        writeln!(f)?;
        for (what, count) in [
            ("injections", self.injections.values().sum()),
            ("facts acknowledged", facts.acknowledged),
            ("facts looked up", facts.checked),
            ("facts in doubt", facts.in_doubt),
            ("facts refused", facts.refused),
            ("stops acknowledged", motion.stops),
            ("stops not kept", self.stops_not_kept),
            ("lines of wheel speeds", motion.lines),
            ("tasks begun anew", self.resets),
            ("judgements voided", motion.voided),
            ("stalls of the harness", self.stalls),
        ] {
            writeln!(f, "{what:<38} {count:>9}")?;
        }
        writeln!(f, "{:<38} {:>9.2}", "longest time blind, s", motion.blind_s)?;
        for (alarm, count) in &self.alarms {
            writeln!(f, "{:<38} {count:>9}", format!("alarm {alarm}"))?;
        }
        writeln!(f)?;
        for (what, count) in self.must_be_zero() {
            let wrong = if count == 0 { "" } else { "  must be 0" };
            writeln!(f, "{what:<38} {count:>9}{wrong}")?;
        }
        for violation in &self.told {
            writeln!(f, "  {violation}")?;
        }
        write!(f, "{:.0} s, {} robots, seed {}", self.wall_time_s, self.robots, self.seed)
    }
}

/// The name of a kind, as JSON has it.
fn name(kind: Kind) -> String {
    serde_json::to_value(kind)
        .ok()
        .and_then(|it| it.as_str().map(str::to_owned))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(tally: Tally, facts: Kept, motion: Counts) -> Report {
        Report::new(1, 20, 60.0, tally, (facts, motion))
    }

    #[test]
    fn one_of_anything_that_must_not_be_is_not_clean_and_is_shown() {
        let clean = report(Tally::default(), Kept::default(), Counts::default());
        assert!(clean.is_clean());
        assert!(!clean.to_string().contains("must be 0"));
        let missing = Recoveries { missing: 1, ..Recoveries::default() };
        let blind = [(super::super::judge::Blindness::NoLink, 1)].into();
        for report in [
            report(Tally::default(), Kept { lost: 1, ..Kept::default() }, Counts::default()),
            report(
                Tally::default(),
                Kept::default(),
                Counts { stops_undone: 1, ..Counts::default() },
            ),
            report(
                Tally::default(),
                Kept::default(),
                Counts { limits_broken: 1, ..Counts::default() },
            ),
            report(Tally::default(), Kept::default(), Counts { blind, ..Counts::default() }),
            report(
                Tally { agents_ended: 1, ..Tally::default() },
                Kept::default(),
                Counts::default(),
            ),
            report(
                Tally { servers_ended: 1, ..Tally::default() },
                Kept::default(),
                Counts::default(),
            ),
            report(
                Tally { servers_hung: 1, ..Tally::default() },
                Kept::default(),
                Counts::default(),
            ),
            report(
                Tally { recoveries: [(Kind::LinkCut, missing)].into(), ..Tally::default() },
                Kept::default(),
                Counts::default(),
            ),
        ] {
            assert!(!report.is_clean(), "{report}");
            assert_eq!(report.to_string().matches("must be 0").count(), 1, "{report}");
        }
    }

    #[test]
    fn recoveries_have_quantiles() {
        let it =
            Recoveries { times: (1..=11).rev().map(f64::from).collect(), ..Default::default() };
        let it = it.summed_up();
        assert_eq!(
            (it.count, it.median_s, it.p90_s, it.max_s),
            (11, Some(6.0), Some(10.0), Some(11.0))
        );
    }
}
