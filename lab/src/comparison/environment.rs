//! Where contenders drive.

use umwelt_core::episode::Region;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::PlantModel;

/// An environment of a comparison: a robot on its floor, and the link to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Its name.
    pub name: String,
    /// What the robot and its floor really are like.
    pub plant: PlantModel,
    /// The link.
    pub link: LinkModel,
    /// A part of the room where floor or link are different.
    pub region: Option<Region>,
}
