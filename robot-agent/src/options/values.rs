//! What the values of flags say: numbers, poses, floors, links, and where a trace goes.

use std::fmt::Display;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::str::FromStr;
use tracing::warn;
use umwelt_agent::{TraceRow, TraceSink};
use umwelt_core::geometry::Pose;
use umwelt_core::link::{LinkModel, PRESETS, Rtt, parse_trace};
use umwelt_core::plant::{SLIP_PRESETS, Slip, SlipChannel};

fn number(text: &str) -> Result<f64, String> {
    let number: f64 = f64::from_str(text.trim()).map_err(|_| format!("{text:?} is no number"))?;
    if number.is_finite() { Ok(number) } else { Err(format!("{number} is not finite")) }
}

/// A number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|n| if n > 0.0 { Ok(n) } else { Err(format!("{n} is not positive")) })
}

/// A number that is zero or above.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    number(text).and_then(|n| if n >= 0.0 { Ok(n) } else { Err(format!("{n} is negative")) })
}

/// A number of either sign.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    number(text)
}

/// `X,Y,HEADING` in m and rad.
pub(super) fn pose(text: &str) -> Result<Pose, String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    match numbers[..] {
        [x, y, heading] => Ok(Pose::new(x, y, heading)),
        _ => Err("three numbers are needed, X,Y,HEADING in m and rad".into()),
    }
}

/// A preset, or `CHANNEL=MEAN:SD,...`; channels not named have no error.
pub(super) fn slip(text: &str) -> Result<Slip, String> {
    if let Some(slip) = Slip::preset(text) {
        return Ok(slip);
    }
    let mut slip = Slip::NONE;
    for part in text.split(',') {
        let usage = || {
            let presets = SLIP_PRESETS.join(", ");
            format!("{part:?} is neither one of {presets} nor CHANNEL=MEAN:SD")
        };
        let (name, numbers) = part.split_once('=').ok_or_else(usage)?;
        let (mean, sd) = numbers.split_once(':').ok_or_else(usage)?;
        let channel = SlipChannel::new(number(mean)?, number(sd)?).map_err(|e| e.to_string())?;
        match name.trim() {
            "forward" => slip.forward = channel,
            "lateral" => slip.lateral = channel,
            "turn" => slip.turn = channel,
            "drift" => slip.drift = channel,
            _ => return Err(format!("{name:?} is none of forward, lateral, turn, drift")),
        }
    }
    Ok(slip)
}

/// A preset, or a recording of round trips as `trace:FILE`.
pub(super) fn link(text: &str) -> Result<LinkModel, String> {
    if let Some(link) = LinkModel::preset(text) {
        return Ok(link);
    }
    let Some(file) = text.strip_prefix("trace:") else {
        return Err(format!(
            "--link {text:?} is neither one of {} nor trace:FILE",
            PRESETS.join(", ")
        ));
    };
    let wrong = |error: &dyn Display| format!("--link: {file}: {error}");
    let csv = std::fs::read_to_string(file).map_err(|error| wrong(&error))?;
    let trace = parse_trace(&csv).map_err(|error| wrong(&error))?;
    Ok(LinkModel::ordinary(Rtt::Trace(trace)))
}

/// A CSV file that takes the rows of a trace.
pub(super) fn trace(file: &Path) -> Result<TraceSink, String> {
    let wrong = |error: &dyn Display| format!("--trace: {}: {error}", file.display());
    let mut csv = BufWriter::new(File::create(file).map_err(|error| wrong(&error))?);
    writeln!(csv, "t_s,x_m,y_m,heading_rad,left_rad_per_s,right_rad_per_s")
        .map_err(|error| wrong(&error))?;
    let mut is_broken = false;
    Ok(Box::new(move |row: &TraceRow| {
        let Some(pose) = row.pose else { return };
        let (x, y, heading) = (pose.x, pose.y, pose.heading.radians());
        let (left, right) = (row.applied.left, row.applied.right);
        let written = writeln!(csv, "{},{x},{y},{heading},{left},{right}", row.time);
        if let Err(error) = written
            && !std::mem::replace(&mut is_broken, true)
        {
            warn!("the trace is incomplete: {error}");
        }
    }))
}
