//! A simulated environment as it is kept: in numbers, whatever presets it was put by.

use super::{Form, former};
use umwelt_api::training::{Floor, Link, LinkModel, Slip, Spec};
use umwelt_core::link;
use umwelt_core::plant;
use umwelt_lab::evolution::TrainingEnvironment;

/// How simulated environments are kept. Version 1 had core's names.
pub(crate) const FORM: Form = Form {
    is_within: false,
    upgrades: &[former::environment],
    base: include_str!("base/environment.json"),
};

/// What is kept of an environment beside its name.
pub(crate) fn of_environment(environment: &TrainingEnvironment, note: Option<String>) -> Spec {
    let TrainingEnvironment { slip, link, fitness, weight, .. } = environment;
    Spec {
        slip: Floor::Slip(Slip::from(*slip)),
        link: Link::Model(Box::new(LinkModel::from(link))),
        fitness: (*fitness).into(),
        weight: *weight,
        note,
    }
}

/// The environment of this name that is kept as `spec`.
pub(crate) fn environment(name: String, spec: &Spec) -> Result<TrainingEnvironment, String> {
    let (fitness, weight) = (spec.fitness.into(), spec.weight);
    Ok(TrainingEnvironment {
        name,
        slip: slip(&spec.slip)?,
        link: link(&spec.link)?,
        fitness,
        weight,
    })
}

fn slip(floor: &Floor) -> Result<plant::Slip, String> {
    match floor {
        Floor::Slip(slip) => slip.convert().map_err(|error| error.to_string()),
        Floor::Preset(name) => plant::Slip::preset(name).ok_or_else(|| format!("no floor {name}")),
    }
}

fn link(link: &Link) -> Result<link::LinkModel, String> {
    match link {
        Link::Model(model) => model.convert().map_err(|error| error.to_string()),
        Link::Preset(name) => {
            link::LinkModel::preset(name).ok_or_else(|| format!("no link {name}"))
        }
    }
}
