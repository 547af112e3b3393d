//! How it was set up: every constant, and why it is what it is where the thesis does not say.

use crate::comparison::{ComparisonSettings, REFERENCE_TRIALS, SAMPLES_BEFORE};
use std::fmt::{self, Write};

pub(super) fn write(text: &mut String, settings: &ComparisonSettings) -> fmt::Result {
    let ComparisonSettings { controller, task, environments, time_limit, .. } = settings;
    let (drive, law, limits) = (&controller.drive, &controller.steering, &controller.variance);
    writeln!(text, "## Setup\n\n| constant | value | from |\n|---|---|---|")?;
    let mut row =
        |name: &str, value: String, from: &str| writeln!(text, "| {name} | {value} | {from} |");
    row("wheel radius", format!("{} m", drive.wheel_radius), "ours: a robot of the 0.1 m class")?;
    row("track width", format!("{} m", drive.track_width), "ours: the same")?;
    row("speed", format!("{} to {} m/s", drive.min_linear, drive.max_linear), "thesis table 1")?;
    row(
        "angular velocity",
        format!("{} to {} rad/s", drive.min_angular, drive.max_angular),
        "thesis table 1",
    )?;
    row(
        "acceleration (eq. 20)",
        format!(
            "{} m/s^2, {} rad/s^2",
            drive.max_linear_acceleration, drive.max_angular_acceleration
        ),
        "ours: full speed within half a second",
    )?;
    row(
        "actuator lag and dead time, as the controller is told",
        format!("{} s, {} s", drive.lag, drive.dead_time),
        "the thesis has none; field robots 60 to 200 ms in all",
    )?;
    row(
        "alpha of the steering law (eq. 18)",
        format!("{} m/s", law.alpha),
        "ours: above the fastest speed, so that the limits of table 1 decide",
    )?;
    row("control cycle", format!("{} s", controller.slot), "thesis table 1")?;
    row(
        "nominal loop delay",
        format!("{} s", controller.loop_delay),
        "sensor 130 ms (thesis table 1) and the 99 % quantile of the normal round trip",
    )?;
    row(
        "variance limits",
        format!("{} m^2, {} rad^2", limits.position, limits.heading),
        "thesis table 1",
    )?;
    row(
        "camera noise",
        format!("{} m, {} rad", controller.noise.position, controller.noise.heading),
        "field recordings: 0.5 to 0.7 mm, 2.6 to 3 mrad",
    )?;
    row(
        "prediction",
        "moments in closed form".to_owned(),
        "in place of the thesis's Monte Carlo, whose number of agents it does not give",
    )?;
    row(
        "arrival",
        format!("within {} m, at rest for 3 slots", task.tolerance),
        "ours: twenty times the camera's noise",
    )?;
    if let Some(calibration) = &task.calibration {
        row(
            "calibration",
            format!(
                "{} rotations of {} s at {} rad/s, {} s of rest after each, {} m straight and back",
                calibration.rotations,
                calibration.rotate,
                calibration.angular,
                calibration.pause,
                calibration.straight
            ),
            "thesis: ten rotations and stops; the straight part is ours, a rotation says nothing of driving",
        )?;
    }
    row(
        "time limit",
        format!("{time_limit} s after the calibration"),
        "ours: many times what a robot at full speed takes",
    )?;
    let waypoints: Vec<String> =
        task.waypoints.iter().map(|it| format!("({}, {})", it.x, it.y)).collect();
    row("way", format!("{} m", waypoints.join(" -> ")), "the scenario")?;
    for it in environments {
        let slip = &it.plant.slip;
        let channel = |channel: umwelt_core::plant::SlipChannel| {
            format!("{:+} +- {}", channel.mean(), channel.sd())
        };
        let change = it.region.as_ref().map_or(String::new(), |region| {
            format!("; another floor or link for x from {} to {} m", region.from, region.to)
        });
        row(
            &format!("environment {}", it.name),
            format!(
                "slip forward {}, lateral {}, turn {}, drift {} rad/m; round trip {}{change}",
                channel(slip.forward),
                channel(slip.lateral),
                channel(slip.turn),
                channel(slip.drift),
                link(&it.link)
            ),
            "the scenario; sd over 100 ms",
        )?;
    }
    writeln!(
        text,
        "\nHow each environment shows in the samples is measured on {REFERENCE_TRIALS} robots of `statistic` per number of \
         slots, on seeds of their own; intervals are asked of a channel after {SAMPLES_BEFORE} samples. The peers' constants \
         were tuned on other seeds (`cargo run --release -p umwelt-lab --example tune_peers`)."
    )
}

fn link(link: &umwelt_core::link::LinkModel) -> String {
    use umwelt_core::link::Rtt;
    let mut text = match &link.rtt {
        Rtt::Constant(rtt) => format!("{rtt} s"),
        Rtt::Lognormal { median, p99 } => format!("{median} s in the median, {p99} s at 99 %"),
        Rtt::Trace(_) => "as recorded".to_owned(),
    };
    // Writing to a String cannot fail.
    if link.late.probability > 0.0 {
        let (share, extra) = (1e2 * link.late.probability, link.late.extra);
        let _ = write!(text, ", {share} % of the slots late by {extra} s");
    }
    if link.silences.rate > 0.0 {
        let (every, longest) = (1.0 / link.silences.rate, link.silences.longest);
        let _ = write!(text, ", a silence every {every:.0} s of up to {longest} s");
    }
    for outage in &link.outages {
        let _ = write!(text, ", nothing from {} s on for {} s", outage.start, outage.duration);
    }
    text
}
