//! What is said of an event of a robot's controller: on the wire, and in the log.

use super::clock::RobotClock;
use umwelt_api::RobotId;
use umwelt_api::event::Kind;
use umwelt_core::controller::Event;
use umwelt_core::task::Progress;

/// Says in the log what the watch finds.
pub(super) fn warn(robot: &RobotId, event: &Event) {
    match event {
        Event::Found { alarm, rests } => {
            let (state, seen, remedy) = (alarm.condition().name(), alarm.seen(), alarm.remedy());
            if *rests {
                tracing::warn!(%robot, state, seen, remedy, "the watch brings the robot to rest");
            } else {
                tracing::warn!(%robot, state, seen, remedy, "the watch has a remark");
            }
        }
        Event::Over(alarm) => {
            tracing::info!(%robot, state = alarm.condition().name(), "over, the robot goes on");
        }
        _ => {}
    }
}

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
