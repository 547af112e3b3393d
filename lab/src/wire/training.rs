//! Simulated environments: what is put, and what it stands for.

use crate::evolution::{self, ENVIRONMENTS, TrainingEnvironment};
use umwelt_api::training::{Fitness, Spec};
use umwelt_api::{Checked, EnvironmentId, Known};

/// The environment that `spec` puts under this name; the note stays behind.
pub fn environment(spec: &Checked<Spec>, name: &EnvironmentId) -> TrainingEnvironment {
    TrainingEnvironment {
        name: name.to_string(),
        slip: spec.to_slip(),
        link: spec.to_link(),
        fitness: spec.fitness.into(),
        weight: spec.weight,
    }
}

/// The simulated environments that come with every server, by their names.
///
/// # Errors
/// All the names, where nothing goes by this one.
pub fn built_in(name: &str) -> Known<TrainingEnvironment> {
    TrainingEnvironment::preset(name)
        .ok_or_else(|| ENVIRONMENTS.into_iter().map(str::to_owned).collect())
}

impl From<&TrainingEnvironment> for Spec {
    /// Without its name and without a note; slip and link by the names of presets where they are some.
    fn from(lab: &TrainingEnvironment) -> Self {
        Self {
            slip: lab.slip.into(),
            link: (&lab.link).into(),
            fitness: lab.fitness.into(),
            weight: lab.weight,
            note: None,
        }
    }
}

impl From<evolution::Fitness> for Fitness {
    fn from(lab: evolution::Fitness) -> Self {
        match lab {
            evolution::Fitness::Normal => Self::Normal,
            evolution::Fitness::Bad => Self::Bad,
        }
    }
}

impl From<Fitness> for evolution::Fitness {
    fn from(wire: Fitness) -> Self {
        match wire {
            Fitness::Normal => Self::Normal,
            Fitness::Bad => Self::Bad,
        }
    }
}
