//! From what was seen to what is wrong.

use super::finding::{Clock, Finding, Findings, Mirror, Quarter};
use super::levels::{Change, Levels};
use super::report::{Numbers, Report};
use super::response::Response;
use super::trace::Trace;
use crate::exchange::PoseNoise;
use crate::settings::Settings;
use std::f64::consts::{FRAC_PI_2, PI};

/// Fewest poses a second: a motion of a second is then five of them.
const FEWEST: f64 = 5.0;

/// Part of the commanded motion below which nothing moved: as in the watch.
const MOVED: f64 = 0.1;

/// Part of what the other wheel makes below which a wheel stands.
const STANDS: f64 = 0.25;

/// Directions that differ by less than this many rad are the same; slip aside and a poor camera stay below half of it.
const SAME_DIRECTION: f64 = 0.3;

/// Part of the drives that is to fit one direction.
const FITS: f64 = 0.7;

/// Factor by which wheels or track may be off: more than floors make of them.
const FACTOR: f64 = 1.25;

/// Delay in s that may go undescribed: an unstamped camera's and a slow motor's.
const DELAY: f64 = 0.2;

/// Motion seen before its command by more than this many s is of another clock.
const AHEAD: f64 = 0.15;

/// Age in s of the youngest pose that no tracker and no link make.
const OLD: f64 = 0.7;

/// A pose is of the future by so many s at least: what the agent's own rounding makes.
const FUTURE: f64 = 0.02;

/// Drift in s of the stamps within a check.
const DRIFT: f64 = 0.2;

/// Times the described noise that is another noise.
const NOISIER: f64 = 2.0;

/// Noise in m and rad that need not be described.
const UNDESCRIBED: PoseNoise = PoseNoise { position: 0.001, heading: 0.01 };

impl Report {
    /// What `trace` says of a robot described by `settings`.
    pub fn of(trace: &Trace, settings: &Settings) -> Self {
        let drive = &settings.drive;
        let levels = trace.is_complete().then(|| Levels::of(trace)).flatten();
        let spread = trace.noise().map_or(0.0, |noise| noise.heading);
        let response = levels.map(|it| Response::of(&it, trace.heading(), spread, drive));
        let (metre, radian) = response.map_or((1.0, 1.0), |it| (it.metre, it.radian));
        let noise = trace
            .noise()
            .map(|it| PoseNoise { position: it.position / metre, heading: it.heading / radian });
        let numbers = Numbers {
            poses_per_second: trace.rate(),
            noise,
            delay: levels.and_then(|levels| levels.delay),
            described_delay: drive.dead_time + drive.lag,
            forward: response.map(|it| it.frame.map_or(0.0, |frame| frame.scale)),
            turn: response.map(|it| it.turn),
            span: trace.span(),
        };
        let mut findings = Findings::new();
        let mut say = |finding| {
            let _ = findings.try_push(finding);
        };
        if trace.is_too_far() {
            let (distance, allowed) = (trace.farthest(), trace.wiggle().allowed());
            say(Finding::TooFar { distance, allowed });
            return Self { findings, numbers };
        }
        let clock = clock(trace, numbers.delay);
        if let Some(clock) = clock {
            say(Finding::OtherClock(clock));
        }
        if clock.is_none() && !trace.is_complete() {
            let (silence, poses) = (trace.silence(), trace.poses());
            say(match trace.rate() {
                rate if poses > 2 && rate < FEWEST => Finding::TooFewPoses(rate),
                _ if trace.is_silent() => Finding::NoPoses { silence, poses },
                _ => Finding::Unclear,
            });
        }
        if !trace.is_complete() {
            return Self { findings, numbers };
        }
        if trace.rate() < FEWEST {
            say(Finding::TooFewPoses(trace.rate()));
        }
        match levels.zip(response) {
            Some((levels, response)) => motion(&levels, &response, trace, settings, &mut say),
            None if trace.rate() >= FEWEST => say(Finding::Unclear),
            None => {}
        }
        if let Some(seen) = numbers.delay.filter(|_| clock.is_none()) {
            let described = numbers.described_delay;
            if (seen - described).abs() > DELAY {
                say(Finding::Delay { seen, described });
            }
        }
        if let Some(seen) = noise
            && radian == 1.0
            && is_noisier(seen, settings.noise)
        {
            say(Finding::Noise { seen, described: settings.noise });
        }
        Self { findings, numbers }
    }
}

fn clock(trace: &Trace, delay: Option<f64>) -> Option<Clock> {
    let [early, late] = trace.ages();
    let youngest = early.min(late);
    let drift = late - early;
    if drift.is_finite() && drift.abs() > DRIFT {
        return Some(Clock::Drifts(drift));
    }
    if youngest < -FUTURE {
        return Some(Clock::Future(-youngest));
    }
    if youngest.is_finite() && youngest > OLD {
        return Some(Clock::Old(youngest));
    }
    delay.filter(|delay| *delay < -AHEAD).map(|delay| Clock::Before(-delay))
}

fn is_noisier(seen: PoseNoise, described: PoseNoise) -> bool {
    let is_above = |seen: f64, described: f64, least: f64| seen > NOISIER * described.max(least);
    is_above(seen.position, described.position, UNDESCRIBED.position)
        || is_above(seen.heading, described.heading, UNDESCRIBED.heading)
}

/// What the motions say of units, wheels and frame.
fn motion(
    levels: &Levels,
    response: &Response,
    trace: &Trace,
    settings: &Settings,
    say: &mut impl FnMut(Finding),
) {
    let Response { turn, spin, drive, .. } = *response;
    let (left, right) = response.wheels();
    let turns = left.abs().max(right.abs());
    if turns < MOVED && drive < MOVED {
        let same = !trace.has_changed();
        return say(Finding::DoesNotMove { same, seen: (drive, turn.abs()) });
    }
    if response.metre > 1.0 {
        let millimetres = response.metre > 100.0;
        say(Finding::Units { millimetres, times: drive.max(response.shift) * response.metre });
    }
    if response.radian > 1.0 {
        // What wheels and frame are like shows once the heading is right.
        return say(Finding::Degrees {
            times: turn.abs().max(spin.abs()) * response.radian,
            spread: trace.noise().map_or(0.0, |noise| noise.heading),
        });
    }
    if turns < MOVED {
        // The heading shows no turn; whether there was one the directions of the drives say.
        return say(match turned_unseen(levels) {
            Some(angle) => Finding::HeadingFixed(angle),
            None => Finding::DoesNotTurn(turn.abs()),
        });
    }
    let wheels = (left, right);
    if left.abs() < STANDS * right.abs() {
        return say(Finding::Stands { left: true, wheels });
    }
    if right.abs() < STANDS * left.abs() {
        return say(Finding::Stands { left: false, wheels });
    }
    if left * right < 0.0 {
        return say(Finding::Inverted { left: left < 0.0, wheels });
    }
    if drive < MOVED {
        return say(Finding::DoesNotDrive(drive));
    }
    frame(response, say);
    factors(response, settings, say);
}

/// The angle in rad between the directions of the drives before and after the turn in the middle, where it is half of what
/// was commanded at least.
fn turned_unseen(levels: &Levels) -> Option<f64> {
    let [_, before, _, turn, after, ..] = levels.changes;
    let direction = |drive: Change| {
        let [x, y, _] = drive.moved.map(|it| it / drive.commanded);
        y.atan2(x)
    };
    let angle = apart(direction(before), direction(after));
    (angle > turn.commanded.abs() / 2.0).then_some(angle)
}

/// What the directions of the drives say of the frame.
fn frame(response: &Response, say: &mut impl FnMut(Finding)) {
    let Some(frame) = response.frame else { return };
    if frame.fit < FITS {
        return say(Finding::Unclear);
    }
    let is_at = |direction: f64| apart(frame.angle, direction) < SAME_DIRECTION;
    let turns_back = response.turn < 0.0;
    match (frame.mirrored, turns_back) {
        (true, true) => say(Finding::Clockwise(frame.angle)),
        (true, false) => {
            let mirrors = [
                (Mirror::Y, 0.0),
                (Mirror::X, PI),
                (Mirror::Exchanged, FRAC_PI_2),
                (Mirror::ExchangedBack, -FRAC_PI_2),
            ];
            let mirror = mirrors.into_iter().find(|(_, direction)| is_at(*direction));
            say(mirror.map_or(Finding::Unclear, |(mirror, _)| Finding::Mirrored(mirror)));
        }
        (false, true) if is_at(PI) => say(Finding::BothInverted),
        (false, back) => {
            if back {
                say(Finding::Swapped);
            }
            if is_at(PI) {
                say(Finding::HalfTurn);
            } else if is_at(-FRAC_PI_2) {
                say(Finding::QuarterTurn(Quarter::Left));
            } else if is_at(FRAC_PI_2) {
                say(Finding::QuarterTurn(Quarter::Right));
            } else if !is_at(0.0) {
                say(Finding::HeadingOff(-frame.angle));
            }
        }
    }
}

/// Whether wheels or track are off by a factor.
fn factors(response: &Response, settings: &Settings, say: &mut impl FnMut(Finding)) {
    let forward = response.frame.map_or(0.0, |frame| frame.scale);
    let is_off = |factor: f64| factor.ln().abs() > FACTOR.ln();
    if is_off(forward) {
        let described = settings.drive.wheel_radius;
        say(Finding::WheelRadius { as_with: described * forward, described });
    }
    let wider = forward / response.turn.abs();
    if is_off(wider) {
        let described = settings.drive.track_width;
        say(Finding::TrackWidth { as_with: described * wider, described });
    }
}

/// How far two directions lie apart in rad, 0..=pi.
fn apart(one: f64, other: f64) -> f64 {
    let difference = (one - other).rem_euclid(2.0 * PI);
    difference.min(2.0 * PI - difference)
}
