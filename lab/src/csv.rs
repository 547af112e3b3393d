//! Every trial of a comparison as lines of text.

use crate::comparison::{Coverage, Distribution, Trial};
use std::fmt::Write;
use umwelt_api::comparison::TRIALS_COLUMNS;

/// The first line.
pub fn header() -> String {
    TRIALS_COLUMNS.join(",") + "\n"
}

/// One line for each trial. Names are core's own, so none needs quotes.
pub fn rows(Distribution { environment, contender, trials }: &Distribution) -> String {
    let mut text = String::new();
    for (index, trial) in trials.iter().enumerate() {
        let Trial { arrived, time, deviation, recognised, coverage } = trial;
        let number = |number: Option<u64>| number.map(|it| it.to_string()).unwrap_or_default();
        let recognised = number(*recognised);
        let covered = |of: fn(&Coverage) -> u32| number(coverage.as_ref().map(of).map(u64::from));
        let (within, samples) = (covered(|it| it.within), covered(|it| it.samples));
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{environment},{contender},{index},{arrived},{time},{deviation},{recognised},{within},{samples}"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_trial_has_its_line_and_every_line_its_columns() {
        let coverage = Some(Coverage { within: 18, samples: 20 });
        let known =
            Trial { arrived: true, time: 7.25, deviation: 0.5, recognised: Some(3), coverage };
        let unknown = Trial { recognised: None, coverage: None, arrived: false, ..known };
        let (environment, contender) = ("bad-link".to_owned(), "bayesian/20".to_owned());
        let rows = rows(&Distribution { environment, contender, trials: vec![known, unknown] });
        assert_eq!(
            rows,
            "bad-link,bayesian/20,0,true,7.25,0.5,3,18,20\nbad-link,bayesian/20,1,false,7.25,0.5,,,\n"
        );
        let columns = |line: &str| line.matches(',').count();
        assert!(rows.lines().all(|line| columns(line) == columns(&header())), "{}", header());
    }
}
