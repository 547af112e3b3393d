//! What is identified of a robot's environment, in words and a table.

use super::kind::kind;
use super::noise::noise;
use super::wheels::wheels;
use crate::cli::quantity::{UNKNOWN, milliseconds, or_unknown, percent};
use crate::cli::table::{Column, Table};
use std::fmt::Write;
use umwelt_api::RobotId;
use umwelt_api::environment::{
    Channel, DeadBand, Drive, Environment, Estimate, Interval, Link, Status,
};
use umwelt_api::robot::Method;
use umwelt_api::watch;

/// All of it.
pub(super) fn show(robot: &RobotId, environment: &Environment) -> String {
    let level = format!("{:.0} %", 1e2 * environment.level);
    let mut text = format!(
        "{robot}: method {}, intervals hold with probability {level}\n\n",
        method(environment.method)
    );
    let mut table = Table::new([
        Column::Text("CHANNEL"),
        Column::Text("UNIT"),
        Column::Number("MEAN"),
        Column::Number("SD"),
        Column::Number("MEAN WITHIN"),
        Column::Number("NEXT WITHIN"),
        Column::Number("SAMPLES"),
        Column::Number("WORTH"),
        Column::Number("LN EVIDENCE"),
        Column::Text("STATUS"),
    ]);
    let channels = &environment.channels;
    for (name, unit, channel) in [
        ("forward", "m/m", &channels.forward),
        ("lateral", "m/m", &channels.lateral),
        ("turn", "rad/rad", &channels.turn),
        ("drift", "rad/m", &channels.drift),
    ] {
        table.row(row(name, unit, channel));
    }
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{table}");
    if let Some(it) = &environment.drive {
        let _ = writeln!(text, "{}", drive(it, &level));
        if let Some(it) = it.scale.filter(|_| it.stretches > 0) {
            text.push_str(&wheels(&it));
        }
        if let Some(it) = it.kind.as_ref().filter(|it| it.proposed.is_some()) {
            text.push_str(&kind(it, &level));
        }
        let says = |it: &&DeadBand| it.status == Status::Given || it.judgements > 0;
        if let Some(it) = it.dead_band.as_ref().filter(says) {
            let _ = writeln!(text, "{}", motors(it, &level));
        }
    }
    if let Some(it) = &environment.noise {
        let _ = writeln!(text, "{}", noise(it, &level, &status(it.status, None, None)));
    }
    let _ = write!(text, "{}", link(&environment.link, &level));
    let prior = environment.prior.name.as_ref().map_or("the robot's own", |name| name.as_str());
    let _ = writeln!(text, "prior    {prior}: {}", environment.prior.why);
    let Environment { windows_rejected, poses_set_aside, .. } = environment;
    let _ = writeln!(
        text,
        "motion   {windows_rejected} windows without constant motion gave no sample, {poses_set_aside} poses set aside"
    );
    text
}

fn row(name: &str, unit: &str, channel: &Channel) -> [String; 10] {
    let unused = if channel.used { "" } else { " (not used)" };
    let ratio = |value: f64| format!("{value:.4}");
    let within = |interval: Interval| format!("{:.4} .. {:.4}", interval.low, interval.high);
    [
        format!("{name}{unused}"),
        unit.to_owned(),
        or_unknown(channel.mean, ratio),
        or_unknown(channel.sd, ratio),
        or_unknown(channel.mean_interval, within),
        or_unknown(channel.predictive_interval, within),
        channel.samples.to_string(),
        or_unknown(channel.effective_samples, |samples| format!("{samples:.1}")),
        or_unknown(channel.ln_evidence, |ln| format!("{ln:.1}")),
        status(channel.status, channel.estimated_fraction, channel.rejected_for),
    ]
}

/// How far an estimate has got, in a word or two.
fn status(status: Status, fraction: Option<f64>, rejected: Option<watch::State>) -> String {
    match (status, fraction, rejected) {
        (Status::Estimating, Some(fraction), _) => format!("estimating, {:.0} %", 1e2 * fraction),
        (Status::Rejected, _, Some(reason)) => format!("rejected: {}", reason.name()),
        (Status::Other, ..) => UNKNOWN.to_owned(),
        _ => status.name().to_owned(),
    }
}

/// How late the drive follows.
fn drive(drive: &Drive, level: &str) -> String {
    let time = |it: &Estimate| or_unknown(it.mean, milliseconds);
    let (sum, lag, dead) = (time(&drive.delay_s), time(&drive.lag_s), time(&drive.dead_time_s));
    let mut text = format!("drive    follows a command in {sum} (lag {lag}, dead time {dead})");
    if let Some(Interval { low, high }) = drive.delay_s.interval {
        let (low, high) = (milliseconds(low), milliseconds(high));
        let _ = write!(text, ", with {level} within {low} .. {high}");
    }
    let _ = write!(text, "; {}", status(drive.status, drive.estimated_fraction, None));
    if drive.status != Status::Given {
        let _ = write!(text, " from {} stretches of motion", drive.stretches);
    }
    if drive.stretches_not_understood > 0 {
        let _ = write!(text, ", {} more not understood", drive.stretches_not_understood);
    }
    text
}

/// Up to which speed its motors do not turn.
fn motors(band: &DeadBand, level: &str) -> String {
    let speed = |speed: f64| format!("{speed:.2} rad/s");
    let DeadBand { status: got, estimated_fraction, speed_rad_per_s: it, judgements } = band;
    let mut text = match it.interval {
        Some(Interval { low, high }) if low <= 0.0 => {
            format!("motors   turn from {} of the wheels at the latest, with {level}", speed(high))
        }
        Some(Interval { low, high }) => {
            let mean = or_unknown(it.mean, speed);
            let (low, high) = (speed(low), speed(high));
            format!(
                "motors   stand below {mean} of the wheels, with {level} within {low} .. {high}"
            )
        }
        None => format!("motors   stand below {} of the wheels", or_unknown(it.mean, speed)),
    };
    let _ = write!(text, "; {}", status(*got, *estimated_fraction, None));
    if *got != Status::Given {
        let _ = write!(text, " from {judgements} steady motions");
    }
    text
}

fn link(link: &Link, level: &str) -> String {
    let Link { samples, late, .. } = link;
    let mut text = match (link.median_s, link.p99_s) {
        (None, _) => "link     no reply delivered yet\n".to_owned(),
        (Some(median), p99) => format!(
            "link     loop delay: median {}, 99 % of those not late within {} ({})\n",
            milliseconds(median),
            or_unknown(p99, milliseconds),
            status(link.delay_status, link.delay_estimated_fraction, None)
        ),
    };
    let probability = or_unknown(link.late_probability, percent);
    let within = link.late_interval.map_or_else(
        || UNKNOWN.to_owned(),
        |interval| format!("{} .. {}", percent(interval.low), percent(interval.high)),
    );
    let _ = writeln!(
        text,
        "late     {late} of {samples} deliveries: probability {probability}, with {level} within {within} ({})",
        status(link.late_status, link.late_estimated_fraction, None)
    );
    if let Some(note) = &link.note {
        let _ = writeln!(text, "note     {note}");
    }
    text
}

fn method(method: Method) -> &'static str {
    match method {
        Method::FixedNormal => "fixed-normal",
        Method::FixedBad => "fixed-bad",
        Method::Statistic => "statistic",
        Method::Bayesian => "bayesian",
        Method::Adaptive => "adaptive",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_api::environment::{Channels, Prior, Split};
    use umwelt_api::environment::{Noise, Scale};
    use umwelt_api::prior::Source;

    fn estimate(mean: f64, low: f64, high: f64) -> Estimate {
        let interval = Some(Interval { low, high });
        Estimate { mean: Some(mean), sd: Some(0.01), interval }
    }

    fn scale() -> Scale {
        let normal = |mean, sd| Estimate { mean: Some(mean), sd: Some(sd), interval: None };
        let split = Split {
            together: normal(-0.3, 0.002),
            robot: normal(-0.2, 0.06),
            floor: normal(-0.1, 0.06),
        };
        Scale {
            used: true,
            wheel_radius_m: normal(0.021, 0.0002),
            described_wheel_radius_m: 0.03,
            track_width_m: normal(0.103, 0.001),
            described_track_width_m: 0.1,
            right_larger: normal(0.02, 0.001),
            forward: split,
            turn: split,
            drift: split,
            floors: 0,
        }
    }

    fn band(mean: f64, within: Option<(f64, f64)>) -> DeadBand {
        let interval = within.map(|(low, high)| Interval { low, high });
        DeadBand {
            status: Status::Estimated,
            estimated_fraction: Some(1.0),
            speed_rad_per_s: Estimate { mean: Some(mean), sd: None, interval },
            judgements: 24,
        }
    }

    fn environment() -> Environment {
        let slippery = Channel {
            used: true,
            mean: Some(-0.052),
            sd: Some(0.031),
            mean_interval: Some(Interval { low: -0.06, high: -0.044 }),
            predictive_interval: Some(Interval { low: -0.103, high: -0.001 }),
            samples: 412,
            effective_samples: Some(120.34),
            ln_evidence: Some(-33.1),
            status: Status::Estimated,
            estimated_fraction: Some(1.0),
            rejected_for: None,
        };
        let unknown = Channel {
            used: false,
            mean: Some(0.0),
            sd: None,
            mean_interval: None,
            predictive_interval: None,
            samples: 0,
            effective_samples: Some(0.0),
            ln_evidence: Some(0.0),
            status: Status::Estimating,
            estimated_fraction: Some(0.0),
            rejected_for: None,
        };
        Environment {
            method: Method::Bayesian,
            level: 0.9,
            channels: Channels {
                forward: slippery,
                lateral: slippery,
                turn: slippery,
                drift: unknown,
            },
            drive: Some(Drive {
                status: Status::Estimated,
                estimated_fraction: Some(1.0),
                delay_s: estimate(0.142, 0.139, 0.146),
                lag_s: estimate(0.11, 0.09, 0.13),
                dead_time_s: estimate(0.032, 0.01, 0.05),
                stretches: 8,
                stretches_not_understood: 1,
                scale: Some(scale()),
                dead_band: Some(band(0.97, Some((0.8, 1.1)))),
                kind: None,
            }),
            noise: Some(Noise {
                status: Status::Estimated,
                position_m: estimate(0.003, 0.0027, 0.0033),
                heading_rad: estimate(0.0052, 0.005, 0.0056),
                poses: Some(212.4),
            }),
            link: Link {
                samples: 12,
                median_s: Some(0.2124),
                p99_s: Some(0.48),
                late: 0,
                late_probability: Some(0.07),
                late_interval: Some(Interval { low: 0.004, high: 0.2 }),
                chance_of_luck: Some(0.54),
                note: Some("no late packet in 12 deliveries says little yet".to_owned()),
                delay_status: Status::Estimated,
                delay_estimated_fraction: Some(1.0),
                late_status: Status::Estimating,
                late_estimated_fraction: Some(0.2),
            },
            windows_rejected: 3,
            poses_set_aside: 1,
            prior: Prior::of("wet-hall".parse().ok(), Source::Put, Method::Bayesian),
        }
    }

    #[test]
    fn an_environment_is_shown_with_how_sure_it_is() {
        assert_eq!(show(&"a".parse().unwrap(), &environment()), "\
a: method bayesian, intervals hold with probability 90 %

CHANNEL           UNIT        MEAN      SD         MEAN WITHIN         NEXT WITHIN  SAMPLES  WORTH  LN EVIDENCE  STATUS
forward           m/m      -0.0520  0.0310  -0.0600 .. -0.0440  -0.1030 .. -0.0010      412  120.3        -33.1  estimated
lateral           m/m      -0.0520  0.0310  -0.0600 .. -0.0440  -0.1030 .. -0.0010      412  120.3        -33.1  estimated
turn              rad/rad  -0.0520  0.0310  -0.0600 .. -0.0440  -0.1030 .. -0.0010      412  120.3        -33.1  estimated
drift (not used)  rad/m     0.0000       -                   -                   -        0    0.0          0.0  estimating, 0 %

drive    follows a command in 142 ms (lag 110 ms, dead time 32 ms), with 90 % within 139 ms .. 146 ms; estimated from 8 stretches of motion, 1 more not understood
wheels   moves as with a wheel radius of 0.02100 +- 0.00020 m, described 0.03; a track of 0.10300 +- 0.00100 m, described 0.1; the right wheel larger by +2.00 +- 0.10 %; commands are corrected
         forward -30.00 +- 0.20 % in all: robot -20.00 +- 6.00 %, floor -10.00 +- 6.00 %; they part on another floor, which a reset begins
motors   stand below 0.97 rad/s of the wheels, with 90 % within 0.80 rad/s .. 1.10 rad/s; estimated from 24 steady motions
poses    off by 3.00 mm and 0.30 deg each (standard deviations), with 90 % within 2.70 mm .. 3.30 mm and 0.29 deg .. 0.32 deg; estimated from 212 poses in motion
link     loop delay: median 212 ms, 99 % of those not late within 480 ms (estimated)
late     0 of 12 deliveries: probability 7.0 %, with 90 % within 0.400 % .. 20.0 % (estimating, 20 %)
note     no late packet in 12 deliveries says little yet
prior    wet-hall: the description of the robot names wet-hall, which somebody put
motion   3 windows without constant motion gave no sample, 1 poses set aside
");
    }

    #[test]
    fn nothing_known_of_the_link_is_said_so() {
        let mut environment = environment();
        environment.link.median_s = None;
        environment.link.note = None;
        environment.prior = Prior::of(None, Source::Inline, Method::Statistic);
        let text = show(&"a".parse().unwrap(), &environment);
        assert!(text.contains("prior    the robot's own: the description"), "{text}");
        assert!(text.contains("no reply delivered yet") && !text.contains("note"), "{text}");
    }

    #[test]
    fn a_described_delay_is_said_to_be_given() {
        let given = |mean| Estimate { mean: Some(mean), sd: None, interval: None };
        let described = Drive {
            status: Status::Given,
            estimated_fraction: None,
            delay_s: given(0.1),
            lag_s: given(0.1),
            dead_time_s: given(0.0),
            stretches: 0,
            stretches_not_understood: 0,
            scale: None,
            kind: None,
            dead_band: None,
        };
        let text = "drive    follows a command in 100 ms (lag 100 ms, dead time 0 ms); given";
        assert_eq!(drive(&described, "90 %"), text);
    }

    #[test]
    fn motors_without_a_dead_band_are_said_to_turn() {
        let none = motors(&band(0.1, Some((0.0, 0.19))), "90 %");
        let text = "motors   turn from 0.19 rad/s of the wheels at the latest, with 90 %; estimated from 24 steady motions";
        assert_eq!(none, text);
        let given = motors(&DeadBand { status: Status::Given, ..band(0.33, None) }, "90 %");
        assert_eq!(given, "motors   stand below 0.33 rad/s of the wheels; given");
    }

    #[test]
    fn a_status_is_shown_with_its_fraction_or_its_reason() {
        assert_eq!(status(Status::Estimating, Some(0.426), None), "estimating, 43 %");
        let stuck = Some(watch::State::Stuck);
        assert_eq!(status(Status::Rejected, None, stuck), "rejected: stuck");
        assert_eq!(status(Status::Unestimated, None, None), "unestimated");
        assert_eq!(status(Status::Other, None, None), UNKNOWN);
    }

    #[test]
    fn methods_are_called_as_on_the_wire() {
        for named in [
            Method::FixedNormal,
            Method::FixedBad,
            Method::Statistic,
            Method::Bayesian,
            Method::Adaptive,
        ] {
            assert_eq!(serde_json::to_value(named).unwrap(), method(named));
        }
    }
}
