//! `oracle`: the thesis's method with the true errors of the floor, a bound for what identification can reach.

use umwelt_core::controller::compensation::{
    Compensation, NominalDelay, PoseEstimator, QuadraticCurve,
};
use umwelt_core::episode::{Region, Scenario};
use umwelt_core::geometry::Pose;
use umwelt_core::identification::Belief;
use umwelt_core::plant::{Slip, SlipChannel};
use umwelt_core::prediction::{ChannelModel, ErrorModel};

/// Knows the floor: its true errors, drift included, where the robot stands. It knows no more of the future than others:
/// neither the slip of the next moment nor the delay of the next packet.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Oracle {
    floor: ErrorModel,
    region: Option<(Region, ErrorModel)>,
}

impl Oracle {
    pub(super) fn new(scenario: &Scenario) -> Self {
        let region = scenario.region.clone().map(|region| {
            let floor = true_errors(&region.slip);
            (region, floor)
        });
        Self { floor: true_errors(&scenario.plant.slip), region }
    }
}

fn true_errors(slip: &Slip) -> ErrorModel {
    let known = |channel: SlipChannel| ChannelModel::known(channel.mean(), channel.sd().powi(2));
    ErrorModel {
        forward: known(slip.forward),
        lateral: known(slip.lateral),
        turn: known(slip.turn),
        drift: known(slip.drift),
    }
}

impl Oracle {
    /// What it decides by.
    pub(super) fn compensation(self) -> Compensation<Self> {
        Compensation { estimator: self, delay: NominalDelay, follower: QuadraticCurve }
    }
}

impl PoseEstimator for Oracle {
    fn error_model(&self, _: &Belief, pose: Pose) -> ErrorModel {
        match &self.region {
            Some((region, there)) if region.holds(pose) => *there,
            _ => self.floor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::ComparisonSettings;
    use umwelt_core::settings::{Method, Prior};

    /// Guards against an oracle that knows the wrong floor, and so a bound that is none.
    #[test]
    fn the_oracle_knows_the_floor_that_it_stands_on() {
        let settings = ComparisonSettings::scenario("floor-change").unwrap();
        let it = &settings.environments[0];
        let scenario = settings.episode(it, settings.controller);
        let oracle = Oracle::new(&scenario);
        let belief = Belief::new(Method::Statistic, &Prior::default(), false);
        let forward = |x: f64| oracle.error_model(&belief, Pose::new(x, 0.0, 0.0)).forward;
        for (x, slip) in [(0.0, Slip::HARD), (1.2, Slip::SLIPPERY), (2.0, Slip::HARD)] {
            let known = (slip.forward.mean(), slip.forward.sd().powi(2));
            assert_eq!((forward(x).mean, forward(x).variance), known, "at {x}");
        }
    }
}
