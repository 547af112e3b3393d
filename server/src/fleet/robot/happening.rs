//! What the wire says of what happened to a robot.

use super::clock::RobotClock;
use umwelt_api::event::Kind;
use umwelt_core::controller::Event;
use umwelt_core::task::Progress;

/// What the wire says of an event of the controller.
pub(super) fn kind(event: &Event, progress: &Progress, clock: RobotClock) -> Kind {
    match *event {
        Event::PoseSetAside { observation, .. } => {
            Kind::PoseSetAside(clock.observation(observation).into())
        }
        Event::PosesAcceptedAgain => Kind::PoseBelievedAgain,
        Event::CalibrationEnded => Kind::CalibrationEnded,
        Event::WaypointReached { leg } => Kind::WaypointReached { leg },
        Event::Found { alarm, rests } => {
            Kind::Watch(umwelt_api::watch::Watch::new(&alarm, rests, Some(0.0)))
        }
        Event::Over(alarm) => Kind::WatchOver { state: alarm.condition().into() },
        Event::Arrived => {
            Kind::Arrived { elapsed_s: progress.elapsed, max_deviation_m: progress.max_deviation }
        }
    }
}
