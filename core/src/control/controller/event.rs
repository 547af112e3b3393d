//! What happens in a step.

use crate::exchange::Observation;
use crate::watch::Alarm;
use arrayvec::ArrayVec;

/// Something that happened in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A pose was set aside: the robot cannot have moved there.
    PoseSetAside {
        /// The pose.
        observation: Observation,
        /// Distance in m from where it was predicted.
        distance: f64,
    },
    /// Several consistent poses in a row are accepted again.
    PosesAcceptedAgain,
    /// The calibration is over; the task's time begins.
    CalibrationEnded,
    /// The robot was seen at rest at a waypoint.
    WaypointReached {
        /// Index of the waypoint.
        leg: usize,
    },
    /// The last waypoint was reached.
    Arrived,
    /// The watch found something.
    Found {
        /// What.
        alarm: Alarm,
        /// Whether the robot rests for it.
        rests: bool,
    },
    /// What the watch had found is over by itself.
    Over(Alarm),
}

/// What happens in one step.
pub type Events = ArrayVec<Event, 8>;
