//! What is identified of a drive.

use super::environment::interval;
use super::known;
use crate::environment::{DeadBand, Drive, Estimate, Kind, NOTE, Scale, Split, Status};
use crate::robot;
use umwelt_core::drive::{DriveEstimate, Quantity, ScaleEstimate, SkidEstimate};
use umwelt_core::kinematics;
use umwelt_core::settings::{Method, Settings};

impl Drive {
    /// What is believed of a drive under these settings; where nothing is, because it is described, what they say.
    pub fn new(believed: Option<&DriveEstimate>, settings: &Settings) -> Self {
        let described = &settings.drive;
        let (status, delay) = match believed {
            Some(it) if settings.identifies_lag => {
                (it.status().into(), [it.sum, it.lag, it.dead_time].map(Estimate::from))
            }
            _ => {
                let sum = described.dead_time + described.lag;
                (Status::Given, [sum, described.lag, described.dead_time].map(given))
            }
        };
        let fraction = believed.filter(|_| settings.identifies_lag);
        let [delay_s, lag_s, dead_time_s] = delay;
        Self {
            status,
            estimated_fraction: fraction.and_then(|it| it.status().fraction()).and_then(known),
            delay_s,
            lag_s,
            dead_time_s,
            stretches: believed.map_or(0, |it| it.stretches),
            stretches_not_understood: believed.map_or(0, |it| it.not_understood),
            scale: believed.map(|it| Scale::new(it, settings)),
            kind: believed
                .and_then(|it| it.skid)
                .filter(|_| described.kind == kinematics::Kind::Differential)
                .map(Kind::from),
            dead_band: believed.map(|it| DeadBand::new(it, settings)),
        }
    }
}

impl DeadBand {
    fn new(believed: &DriveEstimate, settings: &Settings) -> Self {
        let drive = &settings.drive;
        if !settings.identifies_dead_band {
            let driving = drive.min_linear / drive.wheel_radius;
            let turning = drive.min_angular * drive.track_width / (2.0 * drive.wheel_radius);
            return Self {
                status: Status::Given,
                estimated_fraction: None,
                speed_rad_per_s: given(driving.min(turning)),
                judgements: believed.judgements,
            };
        }
        let status = believed.dead_band_status();
        Self {
            status: status.into(),
            estimated_fraction: status.fraction().and_then(known),
            speed_rad_per_s: believed.dead_band.into(),
            judgements: believed.judgements,
        }
    }
}

/// What is described.
fn given(mean: f64) -> Estimate {
    Estimate { mean: known(mean), sd: None, interval: None }
}

impl Scale {
    fn new(believed: &DriveEstimate, settings: &Settings) -> Self {
        let described = &settings.drive;
        let [forward, turn, drift] = believed.scale;
        let (by_forward, by_turn) = (1.0 + forward.together.mean, 1.0 + turn.together.mean);
        let of_forward = forward.together.sd / by_forward;
        let of_turn = turn.together.sd / by_turn;
        let track = described.track_width * by_forward / by_turn;
        let right_larger = drift.together.mean * track / by_forward;
        Self {
            used: settings.method == Method::Adaptive,
            wheel_radius_m: normal(
                described.wheel_radius * by_forward,
                described.wheel_radius * forward.together.sd,
            ),
            described_wheel_radius_m: described.wheel_radius,
            track_width_m: normal(track, track * of_forward.hypot(of_turn)),
            described_track_width_m: described.track_width,
            right_larger: normal(right_larger, drift.together.sd * track / by_forward),
            forward: forward.into(),
            turn: turn.into(),
            drift: drift.into(),
            floors: believed.floors,
        }
    }
}

impl From<SkidEstimate> for Kind {
    fn from(core: SkidEstimate) -> Self {
        let is_proposed = core.is_proposed();
        Self {
            described: robot::Kind::Differential,
            proposed: is_proposed.then_some(robot::Kind::SkidSteer),
            ln_evidence: known(core.ln_evidence),
            sideways_m_per_rad: core.sideways.into(),
            turn_by_speed_s_per_m: core.turn_by_speed.into(),
            note: is_proposed.then(|| NOTE.to_owned()),
        }
    }
}

/// Of a normal distribution.
fn normal(mean: f64, sd: f64) -> Estimate {
    Quantity::normal(mean, sd * sd).into()
}

impl From<ScaleEstimate> for Split {
    fn from(core: ScaleEstimate) -> Self {
        Self { together: core.together.into(), robot: core.robot.into(), floor: core.floor.into() }
    }
}

impl From<Quantity> for Estimate {
    fn from(core: Quantity) -> Self {
        Self { mean: known(core.mean), sd: known(core.sd), interval: interval(core.interval) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::Interval;
    use umwelt_core::drive::DriveBelief;

    #[test]
    fn how_late_a_drive_follows_is_told_whoever_knows_it() {
        let drive = kinematics::Drive { lag: 0.1, dead_time: 0.05, ..Default::default() };
        let described = Settings { drive, ..Settings::default() };
        let told = Drive::new(None, &described);
        assert_eq!((told.status, told.estimated_fraction), (Status::Given, None));
        assert_eq!((told.lag_s.mean, told.delay_s.interval), (Some(0.1), None));
        assert!(told.scale.is_none());

        let believed = DriveBelief::new(0.1).estimate();
        let asked = Settings { identifies_lag: true, ..described };
        let told = Drive::new(Some(&believed), &asked);
        assert_eq!((told.status, told.estimated_fraction), (Status::Estimating, Some(0.0)));
        assert_eq!((told.delay_s.mean, told.stretches), (Some(believed.sum.mean), 0));
        let Interval { low, high } = told.delay_s.interval.unwrap();
        assert!(low < 0.06 && high > 0.3, "{low} to {high} s");
        let told = told.dead_band.unwrap();
        assert_eq!((told.status, told.estimated_fraction), (Status::Given, None));
        let speed = told.speed_rad_per_s;
        assert!((speed.mean.unwrap() - 0.2 * 0.05 / 0.03).abs() < 1e-12 && speed.sd.is_none());
        let unsaid = Settings { identifies_dead_band: true, ..asked };
        let told = Drive::new(Some(&believed), &unsaid).dead_band.unwrap();
        assert_eq!((told.status, told.estimated_fraction), (Status::Estimating, Some(0.0)));
        let Interval { low, high } = told.speed_rad_per_s.interval.unwrap();
        assert!(low == 0.0 && (1.0..1.6).contains(&high), "{low} to {high} rad/s");
        // Where only the scale is identified the lag is what was described.
        let adaptive = Settings { method: Method::Adaptive, ..described };
        let told = Drive::new(Some(&believed), &adaptive);
        assert_eq!((told.status, told.lag_s.mean), (Status::Given, Some(0.1)));
        assert!(told.scale.is_some_and(|scale| scale.used));
    }

    /// Guards against: a robot that is proposed to be what it is described as, or without saying what else it may be.
    #[test]
    fn a_kind_is_proposed_where_it_is_another() {
        let skid = |ln_evidence| SkidEstimate {
            sideways: Quantity::normal(0.021, 1e-6),
            turn_by_speed: Quantity::normal(0.1, 0.04),
            ln_evidence,
        };
        let told = |ln_evidence, kind| {
            let believed =
                DriveEstimate { skid: Some(skid(ln_evidence)), ..DriveBelief::new(0.1).estimate() };
            let drive = kinematics::Drive { kind, ..Default::default() };
            Drive::new(Some(&believed), &Settings { drive, ..Settings::default() }).kind
        };
        let proposed = told(9.0, kinematics::Kind::Differential).unwrap();
        assert_eq!(proposed.proposed, Some(robot::Kind::SkidSteer));
        assert_eq!(
            (proposed.sideways_m_per_rad.mean, proposed.ln_evidence),
            (Some(0.021), Some(9.0))
        );
        assert!(proposed.note.is_some());
        let unsure = told(4.0, kinematics::Kind::Differential).unwrap();
        assert_eq!((unsure.proposed, unsure.note), (None, None));
        assert_eq!(told(9.0, kinematics::Kind::SkidSteer(Default::default())), None);
    }

    #[test]
    fn a_scale_is_told_as_the_wheels_that_would_make_it() {
        let mut believed = DriveBelief::new(0.1).estimate();
        for (scale, mean) in believed.scale.iter_mut().zip([-0.3, -0.25, 0.1]) {
            scale.together = Quantity::normal(mean, 1e-6);
        }
        let told = Drive::new(Some(&believed), &Settings::default()).scale.unwrap();
        let about = |estimate: Estimate, value: f64| {
            let mean = estimate.mean.unwrap();
            assert!((mean - value).abs() < 1e-9, "{mean}");
            estimate.sd.unwrap()
        };
        assert!((about(told.wheel_radius_m, 0.021) - 0.03e-3).abs() < 1e-9);
        let track = 0.1 * 0.7 / 0.75;
        assert!((about(told.track_width_m, track) - track * 1.954e-3).abs() < 1e-6);
        about(told.right_larger, 0.1 * track / 0.7);
        assert_eq!((told.described_wheel_radius_m, told.used), (0.03, false));
    }
}
