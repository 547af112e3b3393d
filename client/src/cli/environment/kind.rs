//! What kind of robot it moves as, in words.

use crate::cli::quantity::or_unknown;
use std::fmt::Write;
use umwelt_api::environment::{Estimate, Interval, Kind};

/// Another kind of robot than it is described as, and how it is to be described.
pub(super) fn kind(kind: &Kind, level: &str) -> String {
    let within = |it: &Estimate, unit: &str| {
        let mean = or_unknown(it.mean, |mean| format!("{mean:.3}"));
        it.interval.map_or_else(
            || format!("{mean} {unit}"),
            |Interval { low, high }| {
                format!("{mean} {unit}, with {level} within {low:.3} .. {high:.3}")
            },
        )
    };
    let (sideways, by_speed) = (&kind.sideways_m_per_rad, &kind.turn_by_speed_s_per_m);
    let evidence = or_unknown(kind.ln_evidence, |ln| format!("{ln:.1}"));
    let mut text = format!(
        "kind     turns like skid steer (ln evidence {evidence}): sideways {}; turns change with speed by {}; describe with --kind skid-steer",
        within(sideways, "m per rad"),
        within(by_speed, "per m/s"),
    );
    if let Some(mean) = sideways.mean {
        let _ = write!(text, " --sideways {mean:.3}");
    }
    // What may as well be nothing is not to be described.
    if let (Some(mean), Some(Interval { low, high })) = (by_speed.mean, by_speed.interval)
        && low * high > 0.0
    {
        let _ = write!(text, " --turn-by-speed {mean:.2}");
    }
    text.push('\n');
    if let Some(note) = &kind.note {
        let _ = writeln!(text, "         {note}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(mean: f64, low: f64, high: f64) -> Estimate {
        Estimate { mean: Some(mean), sd: Some(0.01), interval: Some(Interval { low, high }) }
    }

    /// Guards against: a proposal that does not say how to take it, or names a number that may as well be zero.
    #[test]
    fn a_proposed_kind_is_shown_with_the_flags_that_describe_it() {
        let proposed = Kind {
            described: Default::default(),
            proposed: Some(umwelt_api::robot::Kind::SkidSteer),
            ln_evidence: Some(18.53),
            sideways_m_per_rad: estimate(0.021, 0.0205, 0.0215),
            turn_by_speed_s_per_m: estimate(-0.2, -0.9, 0.5),
            note: Some("as a marker does".to_owned()),
        };
        let text = "kind     turns like skid steer (ln evidence 18.5): sideways 0.021 m per rad, with 90 % within 0.021 .. 0.021; \
            turns change with speed by -0.200 per m/s, with 90 % within -0.900 .. 0.500; \
            describe with --kind skid-steer --sideways 0.021\n         as a marker does\n";
        assert_eq!(kind(&proposed, "90 %"), text);
        let turn_by_speed_s_per_m = estimate(-0.8, -1.1, -0.5);
        let text = kind(&Kind { turn_by_speed_s_per_m, ..proposed }, "90 %");
        assert!(text.contains("--sideways 0.021 --turn-by-speed -0.80\n"), "{text}");
    }
}
