//! The bodies of the contract.

use crate::body::Body;
use crate::checked::Checked;
use crate::problem::Problems;
use crate::{comparison, evolution, prior, robot, step, task, training};

macro_rules! bodies {
    ($($module:ident::$type:ident)*) => {$(
        impl Body for $module::$type {
            const MAX_BYTES: usize = $module::MAX_BODY;

            fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
                Self::read(json)
            }
        }
    )*};
}

bodies! {
    robot::Description
    task::Spec
    step::Request
    prior::Spec
    training::Spec
    evolution::Request
    comparison::Request
}

impl Body for robot::Patch {
    const MAX_BYTES: usize = robot::MAX_BODY;
    const MEDIA_TYPES: &'static [&'static str] =
        &["application/json", "application/merge-patch+json"];

    fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        Self::read(json)
    }
}
