//! What the thesis's claims come to, in plain words.

use umwelt_api::comparison::{Claim, Estimate, Finding, FindingResult, FindingSubject};

/// The claim with its findings and the verdict that they make.
pub(crate) fn judged(claim: Claim) -> Claim {
    let findings = findings(&claim);
    let words: Vec<_> = findings.iter().map(|finding| finding.words.as_str()).collect();
    Claim { verdict: words.join("; "), findings, ..claim }
}

/// What the means say.
fn findings(claim: &Claim) -> Vec<Finding> {
    if let Some(finding) = without_arrival(claim) {
        return vec![finding];
    }
    let deviation = Promise {
        of: "deviation",
        less: "smaller",
        more: "larger",
        about: FindingSubject::Deviation,
    };
    let time = Promise { of: "time", less: "shorter", more: "longer", about: FindingSubject::Time };
    let mut findings = vec![
        deviation.kept(claim.deviation_reduction.mean, claim.promised_deviation),
        time.kept(claim.time_reduction.mean, claim.promised_time),
    ];
    findings.extend(arrivals(claim));
    findings
}

/// The finding where one of the two never arrived: its time is the limit, and its deviation that of standing still.
fn without_arrival(claim: &Claim) -> Option<Finding> {
    let both = [(&claim.contender, claim.arrived), (&claim.against, claim.against_arrived)];
    let never: Vec<_> =
        both.iter().filter(|(_, arrived)| *arrived <= 0.0).map(|(name, _)| name.as_str()).collect();
    (!never.is_empty()).then(|| Finding {
        about: FindingSubject::Arrival,
        result: FindingResult::NoneArrived,
        words: format!(
            "{} arrived in no trial, so neither deviation nor time says anything; use an environment that can be \
             driven",
            never.join(" and ")
        ),
    })
}

/// Which of the two did not always arrive: such a trial takes the time limit, and a robot that does not get far does not
/// stray far.
fn arrivals(claim: &Claim) -> Option<Finding> {
    let Claim { contender, against, arrived, against_arrived, .. } = claim;
    if *arrived >= 1.0 && *against_arrived >= 1.0 {
        return None;
    }
    let share = |arrived: f64| match percent(arrived, 1) {
        // One in ten thousand is not none.
        all if all == "100.0" && arrived < 1.0 => "more than 99.9".to_owned(),
        share => share,
    };
    let words = format!(
        "not all arrived: {contender} in {} % of the trials, {against} in {} %, the others count with the time limit and \
         as far as they got",
        share(*arrived),
        share(*against_arrived)
    );
    let (about, result) = (FindingSubject::Arrival, FindingResult::NotAllArrived);
    Some(Finding { about, result, words })
}

/// The words for one of the two quantities.
struct Promise {
    of: &'static str,
    less: &'static str,
    more: &'static str,
    about: FindingSubject,
}

impl Promise {
    /// How far `reduction` keeps what was `promised`.
    fn kept(&self, reduction: Option<Estimate>, promised: f64) -> Finding {
        let (result, words) = self.judge(reduction, promised);
        Finding { about: self.about, result, words }
    }

    fn judge(&self, reduction: Option<Estimate>, promised: f64) -> (FindingResult, String) {
        let Self { of, less, more, .. } = self;
        let promised_percent = percent(promised, 0);
        let Some(estimate) = reduction else {
            let words = format!("{of} cannot be said as a part of the other's, which is zero");
            return (FindingResult::Undefined, words);
        };
        let Estimate { mean, low, high } = estimate;
        let size = |value: f64| {
            // Above 100 % a decimal says nothing any more.
            let rounded = percent(value, 1);
            if rounded.len() < "100.0".len() { rounded } else { percent(value, 0) }
        };
        let direction = |value: f64| if value < 0.0 { more } else { less };
        let (by, way) = (size(mean), direction(mean));
        if estimate.includes_zero() {
            let ends = [low, high].map(|end| format!("{} % {}", size(end), direction(end)));
            let words = format!(
                "{of} {by} % {way} (95 %: {}): the interval includes zero, no difference is shown, none of the \
                 thesis's {promised_percent} % {less}",
                ends.join(" to ")
            );
            return (FindingResult::NoDifference, words);
        }
        if mean < 0.0 {
            // Much longer: the end of the interval that is nearer to zero comes first here too.
            let (low, high) = (size(high), size(low));
            let words = format!(
                "{of} {by} % {more} (95 %: {low} to {high}): the opposite of the thesis's {promised_percent} % \
                 {less}, none of it is reached"
            );
            return (FindingResult::Opposite, words);
        }
        let share = match percent(mean / promised, 0) {
            none if none == "0" => "less than 1".to_owned(),
            share => share,
        };
        let words = format!(
            "{of} {by} % {less} (95 %: {} to {}): {share} % of the thesis's {promised_percent} %",
            size(low),
            size(high)
        );
        (if mean >= promised { FindingResult::Reached } else { FindingResult::Partly }, words)
    }
}

/// The size of a part in percent, without its sign.
fn percent(part: f64, decimals: usize) -> String {
    format!("{:.decimals$}", 1e2 * part.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_api::comparison::Reductions;

    type Interval = (f64, f64, f64);

    fn words(deviation: Option<Interval>, time: Option<Interval>) -> String {
        judged(claim(deviation, time)).verdict
    }

    fn claim(deviation: Option<Interval>, time: Option<Interval>) -> Claim {
        let reductions = |mean: Option<Interval>| Reductions {
            mean: mean.map(|(mean, low, high)| Estimate { mean, low, high }),
            // Neither says anything in the verdict.
            median: Some(Estimate { mean: 0.9, low: 0.8, high: 1.0 }),
            p90: None,
        };
        Claim {
            environment: "bad-link".to_owned(),
            slots: 20,
            contender: "bayesian/20".to_owned(),
            against: "statistic/20".to_owned(),
            deviation_reduction: reductions(deviation),
            time_reduction: reductions(time),
            promised_deviation: 0.75,
            promised_time: 0.35,
            arrived: 1.0,
            against_arrived: 1.0,
            verdict: String::new(),
            findings: Vec::new(),
        }
    }

    #[test]
    fn a_share_of_the_promise_is_named_and_so_is_its_opposite() {
        assert_eq!(
            words(Some((0.123, 0.081, 0.16)), Some((-1.04, -1.08, -1.0))),
            "deviation 12.3 % smaller (95 %: 8.1 to 16.0): 16 % of the thesis's 75 %; \
             time 104 % longer (95 %: 100 to 108): the opposite of the thesis's 35 % shorter, none of it is reached"
        );
        assert_eq!(
            words(Some((-0.2, -0.31, -0.1)), Some((0.42, 0.4, 0.44))),
            "deviation 20.0 % larger (95 %: 10.0 to 31.0): the opposite of the thesis's 75 % smaller, none of it is \
             reached; time 42.0 % shorter (95 %: 40.0 to 44.0): 120 % of the thesis's 35 %"
        );
    }

    /// Guards against noise that is read as an improvement.
    #[test]
    fn an_interval_with_zero_shows_no_difference() {
        assert_eq!(
            words(Some((0.012, -0.03, 0.051)), Some((-0.01, -0.02, 0.0))),
            "deviation 1.2 % smaller (95 %: 3.0 % larger to 5.1 % smaller): the interval includes zero, no \
             difference is shown, none of the thesis's 75 % smaller; \
             time 1.0 % longer (95 %: 2.0 % longer to 0.0 % shorter): the interval includes zero, no difference is \
             shown, none of the thesis's 35 % shorter"
        );
        for interval in [(0.1, 0.0, 0.2), (-0.1, -0.2, 0.0), (0.0, 0.0, 0.0)] {
            let words = words(Some(interval), Some(interval));
            assert_eq!(words.matches("no difference is shown").count(), 2, "{words}");
            assert!(!words.contains("of the thesis's 75 %;"), "{words}");
        }
    }

    #[test]
    fn what_is_next_to_nothing_and_what_does_not_exist_is_named() {
        let little = words(Some((0.002, 0.001, 0.003)), None);
        assert!(little.contains("): less than 1 % of the thesis's 75 %;"), "{little}");
        assert!(little.ends_with("time cannot be said as a part of the other's, which is zero"));
    }

    #[test]
    fn decimals_end_at_a_hundred() {
        let at = |mean| words(Some((mean, mean - 1e-3, mean + 1e-3)), None);
        assert!(at(-0.999_4).starts_with("deviation 99.9 % larger (95 %: 99.8 to 100)"));
        assert!(at(-0.999_6).starts_with("deviation 100 % larger"));
        assert!(at(-12.5).starts_with("deviation 1250 % larger"));
    }

    /// Guards against a robot that stands still and is praised for how little it deviates.
    #[test]
    fn robots_that_did_not_arrive_are_named() {
        let less = Some((0.75, 0.7, 0.8));
        let of = |arrived, against_arrived| {
            let claim = Claim { arrived, against_arrived, ..claim(less, less) };
            judged(claim).verdict
        };
        assert!(!of(1.0, 1.0).contains("arrived"));
        let words = "; not all arrived: bayesian/20 in 12.5 % of the trials, statistic/20 in 100.0 %, the others count \
                    with the time limit and as far as they got";
        assert!(of(0.125, 1.0).ends_with(words), "{}", of(0.125, 1.0));
        assert!(of(1.0, 0.9999).contains("statistic/20 in more than 99.9 %"));
        let nothing =
            "statistic/20 arrived in no trial, so neither deviation nor time says anything";
        assert!(of(1.0, 0.0).starts_with(nothing), "{}", of(1.0, 0.0));
        assert!(of(0.0, 0.0).starts_with("bayesian/20 and statistic/20 arrived in no trial"));
    }

    #[test]
    fn findings_say_what_the_verdict_says() {
        use FindingResult::{
            NoDifference, NoneArrived, NotAllArrived, Opposite, Partly, Reached, Undefined,
        };
        let results = |claim: Claim| {
            let judged = judged(claim);
            let words: Vec<_> = judged.findings.iter().map(|it| it.words.as_str()).collect();
            assert_eq!(words.join("; "), judged.verdict);
            judged.findings.iter().map(|it| it.result).collect::<Vec<_>>()
        };
        let (whole, part) = (Some((0.8, 0.7, 0.9)), Some((0.1, 0.05, 0.2)));
        let (none, worse) = (Some((0.1, 0.0, 0.2)), Some((-0.1, -0.2, -0.05)));
        assert_eq!(results(claim(whole, part)), [Reached, Partly]);
        assert_eq!(results(claim(none, worse)), [NoDifference, Opposite]);
        let some = Claim { arrived: 0.5, ..claim(None, part) };
        assert_eq!(results(some), [Undefined, Partly, NotAllArrived]);
        assert_eq!(results(Claim { arrived: 0.0, ..claim(whole, part) }), [NoneArrived]);
    }
}
