//! `umwelt robot calibrate --accept`: a robot is described with the wheels and the track with which it moves as it does.

use super::super::failure::Failure;
use super::super::output::Output;
use super::super::progress::wait;
use serde_json::json;
use umwelt_api::RobotId;
use umwelt_api::environment::{Drive, Estimate};
use umwelt_api::robot::{Patch, Robot};
use umwelt_client::Client;

/// Part of itself to which a length is to be known.
const KNOWN: f64 = 0.02;

/// Describes the robot anew by what is identified of it.
pub(super) async fn accept(
    client: &Client,
    output: &mut Output,
    id: &RobotId,
) -> Result<(), Failure> {
    let before = wait(client.get_robot(id)).await?;
    let environment = wait(client.environment(id)).await?;
    let patch = patch(environment.drive.as_ref())
        .map_err(|reason| Failure::Failed(format!("{id} is described as before: {reason}")))?;
    let after = wait(client.if_match(&before.etag).patch_robot(id, &patch)).await?;
    output.result(&after, |after| accepted(&before, after))
}

/// What changes in a description; why nothing does.
fn patch(drive: Option<&Drive>) -> Result<Patch, String> {
    let drive = drive.filter(|drive| drive.scale.is_some() && drive.stretches > 0);
    let Some(scale) = drive.and_then(|drive| drive.scale) else {
        return Err("nothing is identified of its wheels yet; describe it with --method adaptive and let it drive".to_owned());
    };
    let mut patch = Patch::default();
    for (path, name, estimate) in [
        ("drive.wheel_radius_m", "wheel radius", scale.wheel_radius_m),
        ("drive.track_width_m", "track", scale.track_width_m),
    ] {
        patch.set(path, json!(known(name, &estimate)?));
    }
    Ok(patch)
}

/// A length that is known well, to a hundredth of a millimetre.
fn known(name: &str, estimate: &Estimate) -> Result<f64, String> {
    match (estimate.mean, estimate.sd) {
        (Some(mean), Some(sd)) if sd <= KNOWN * mean => Ok((mean * 1e5).round() / 1e5),
        (Some(mean), Some(sd)) => Err(format!(
            "its {name} is known to {:.0} % only, {mean:.4} +- {sd:.4} m; let it drive and turn more, or calibrate it",
            1e2 * sd / mean
        )),
        _ => Err(format!("its {name} is not known")),
    }
}

fn accepted(before: &Robot, after: &Robot) -> String {
    let (was, is) = (&before.spec.drive, &after.spec.drive);
    format!(
        "{} is described with a wheel radius of {} m (was {} m) and a track of {} m (was {} m)\n",
        after.robot, is.wheel_radius_m, was.wheel_radius_m, is.track_width_m, was.track_width_m
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_api::environment::{Scale, Split, Status};
    use umwelt_api::robot::Description;

    fn estimate(mean: f64, sd: f64) -> Estimate {
        Estimate { mean: Some(mean), sd: Some(sd), interval: None }
    }

    fn drive(radius: Estimate, stretches: u64) -> Drive {
        let some = estimate(-0.3, 0.001);
        let split = Split { together: some, robot: some, floor: some };
        Drive {
            status: Status::Estimated,
            estimated_fraction: Some(1.0),
            delay_s: some,
            lag_s: some,
            dead_time_s: some,
            stretches,
            stretches_not_understood: 0,
            dead_band: None,
            scale: Some(Scale {
                used: true,
                wheel_radius_m: radius,
                described_wheel_radius_m: 0.03,
                track_width_m: estimate(0.103_004, 0.001),
                described_track_width_m: 0.1,
                right_larger: some,
                forward: split,
                turn: split,
                drift: split,
                floors: 0,
            }),
            kind: None,
        }
    }

    #[test]
    fn what_is_known_well_is_accepted() {
        let patch = patch(Some(&drive(estimate(0.020_998, 0.0002), 9))).unwrap();
        let said = Description::read(&Description::default().patched(&patch)).unwrap();
        let said = serde_json::to_value(said.into_inner()).unwrap();
        assert_eq!(said, json!({"drive": {"wheel_radius_m": 0.021, "track_width_m": 0.103}}));
    }

    /// Guards against: the first stretch of motion is taken for what a robot is like.
    #[test]
    fn what_is_not_known_is_not_accepted() {
        let unsure = patch(Some(&drive(estimate(0.021, 0.002), 1))).unwrap_err();
        assert!(unsure.contains("known to 10 % only"), "{unsure}");
        assert!(patch(Some(&drive(estimate(0.021, 0.0001), 0))).is_err());
        assert!(patch(None).unwrap_err().contains("adaptive"));
    }
}
