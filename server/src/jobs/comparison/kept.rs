//! The settings of a comparison as they are kept: specs of the wire, in numbers whatever names and scenarios they came by.

use crate::jobs::UPGRADES;
use crate::store::document::Form;
use crate::store::document::robot::controller;
use serde::{Deserialize, Serialize};
use umwelt_api::training::{LinkModel, Slip};
use umwelt_api::{robot, task};
use umwelt_core::episode;
use umwelt_core::geometry::Pose;
use umwelt_core::plant::PlantModel;
use umwelt_lab::comparison::{self, Approach, ComparisonSettings};

/// How the record of a comparison is kept.
pub(super) const FORM: Form =
    Form { is_within: true, upgrades: UPGRADES, base: include_str!("kept.json") };

/// The settings of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spec {
    scenario: String,
    contenders: Vec<Contender>,
    environments: Vec<Environment>,
    controller: robot::Spec,
    task: task::Spec,
    start: Start,
    time_limit_s: f64,
    trials: usize,
    seed: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Contender {
    name: String,
    approach: String,
    horizon_slots: usize,
    prior: robot::Prior,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Environment {
    name: String,
    drive: robot::Drive,
    slip: Slip,
    noise: robot::Noise,
    link: LinkModel,
    region: Option<Region>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Region {
    from_m: f64,
    to_m: f64,
    slip: Slip,
    link: LinkModel,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Start {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

impl From<&comparison::Contender> for Contender {
    fn from(core: &comparison::Contender) -> Self {
        let comparison::Contender { name, approach, slots, prior } = core;
        let approach = approach.name().to_owned();
        Self { name: name.clone(), approach, horizon_slots: *slots, prior: (*prior).into() }
    }
}

impl Contender {
    fn convert(&self) -> Result<comparison::Contender, String> {
        let Self { name, approach, horizon_slots, prior } = self;
        Ok(comparison::Contender {
            name: name.clone(),
            approach: Approach::named(approach).ok_or_else(|| format!("no method {approach}"))?,
            slots: *horizon_slots,
            prior: prior.convert().map_err(|error| error.to_string())?,
        })
    }
}

impl From<&comparison::Environment> for Environment {
    fn from(core: &comparison::Environment) -> Self {
        let comparison::Environment { name, plant, link, region } = core;
        Self {
            name: name.clone(),
            drive: plant.drive.into(),
            slip: plant.slip.into(),
            noise: plant.noise.into(),
            link: link.into(),
            region: region.as_ref().map(Region::from),
        }
    }
}

impl Environment {
    fn convert(&self) -> Result<comparison::Environment, String> {
        let Self { name, drive, slip, noise, link, region } = self;
        let slip = slip.convert().map_err(|error| error.to_string())?;
        Ok(comparison::Environment {
            name: name.clone(),
            plant: PlantModel {
                drive: drive.convert(),
                slip,
                noise: noise.convert(),
                ..PlantModel::default()
            },
            link: link.convert().map_err(|error| error.to_string())?,
            region: region.as_ref().map(Region::convert).transpose()?,
        })
    }
}

impl From<&episode::Region> for Region {
    fn from(core: &episode::Region) -> Self {
        let episode::Region { from, to, slip, link } = core;
        Self { from_m: *from, to_m: *to, slip: (*slip).into(), link: link.into() }
    }
}

impl Region {
    fn convert(&self) -> Result<episode::Region, String> {
        let Self { from_m, to_m, slip, link } = self;
        Ok(episode::Region {
            from: *from_m,
            to: *to_m,
            slip: slip.convert().map_err(|error| error.to_string())?,
            link: link.convert().map_err(|error| error.to_string())?,
        })
    }
}

impl From<&ComparisonSettings> for Spec {
    fn from(core: &ComparisonSettings) -> Self {
        let Pose { x, y, heading } = core.start;
        Self {
            scenario: core.scenario.clone(),
            contenders: core.contenders.iter().map(Contender::from).collect(),
            environments: core.environments.iter().map(Environment::from).collect(),
            controller: (&core.controller).into(),
            task: (&core.task).into(),
            start: Start { x_m: x, y_m: y, heading_rad: heading.radians() },
            time_limit_s: core.time_limit,
            trials: core.trials,
            seed: core.seed,
        }
    }
}

impl Spec {
    /// The settings in core's terms.
    pub(super) fn convert(&self) -> Result<ComparisonSettings, String> {
        let Start { x_m, y_m, heading_rad } = self.start;
        let contenders = self.contenders.iter().map(Contender::convert);
        let environments = self.environments.iter().map(Environment::convert);
        Ok(ComparisonSettings {
            scenario: self.scenario.clone(),
            contenders: contenders.collect::<Result<_, _>>()?,
            environments: environments.collect::<Result<_, _>>()?,
            controller: controller(&self.controller)?,
            task: self.task.convert(),
            start: Pose::new(x_m, y_m, heading_rad),
            time_limit: self.time_limit_s,
            trials: self.trials,
            seed: self.seed,
        })
    }
}
