//! Whether what a controller has learned, and how far its task has got, is worth keeping anew: a disk wears out with
//! every write, and one sample more among a thousand is none.

use super::Saved;
use super::plan::Phase;
use crate::conjugate::NormalInverseChiSquared;

/// Growth of what is counted (samples, deliveries, time) that is news: estimates then know their values by 2.5 % better.
pub const GROWTH: f64 = 0.05;

/// Move of a mean that is news, in units of its standard deviation: within half of one it says the same.
const MOVE: f64 = 0.5;

impl Saved {
    /// Whether it says something of weight that `kept`, an earlier one, does not: another phase of the task or a waypoint
    /// reached, what the watch holds the robot for, a mean that has moved, or anything counted that has grown by more than [`GROWTH`].
    pub fn is_news_after(&self, kept: &Self) -> bool {
        stage(self.phase) != stage(kept.phase)
            || self.watch != kept.watch
            || self.record.reached() != kept.record.reached()
            || has_grown(kept.record.elapsed(), self.record.elapsed())
            || has_grown(
                kept.belief.link.estimate().samples as f64,
                self.belief.link.estimate().samples as f64,
            )
            || kept.belief.channels().iter().zip(self.belief.channels()).any(|(kept, now)| {
                has_grown(kept.samples() as f64, now.samples() as f64)
                    || has_moved(kept.posterior(), now.posterior())
            })
    }

    /// Whether the watch holds the robot until it is resumed.
    pub fn is_held_by_watch(&self) -> bool {
        self.watch.holding.is_some()
    }

    /// Whether the watch holds the robot for something else than `kept` says, or no longer.
    pub fn is_held_otherwise(&self, kept: &Self) -> bool {
        self.watch.holding != kept.watch.holding
    }
}

/// What of a phase does not change within it.
fn stage(phase: Phase) -> (core::mem::Discriminant<Phase>, Option<usize>, u32) {
    let part = match phase {
        Phase::Calibrating { turn, .. } => turn,
        Phase::Straight { outbound, .. } => u32::from(outbound),
        _ => 0,
    };
    (core::mem::discriminant(&phase), phase.leg(), part)
}

fn has_grown(kept: f64, now: f64) -> bool {
    // Less is another count: of another task, or begun anew.
    now > kept * (1.0 + GROWTH) || now < kept
}

fn has_moved(kept: NormalInverseChiSquared, now: NormalInverseChiSquared) -> bool {
    now.mean_variance().is_some_and(|variance| {
        let moved = now.mu() - kept.mu();
        moved * moved > MOVE * MOVE * variance
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controller::Controller;
    use crate::exchange::{Delivery, Request};
    use crate::settings::Settings;
    use crate::task::Task;
    use crate::time::RobotTime;

    fn deliver(controller: &mut Controller, from: u64, to: u64) {
        for sequence in from..to {
            let delivery = Delivery { sequence, loop_delay: 0.1 };
            let deliveries = std::iter::once(delivery).collect();
            controller.late(&Request {
                sequence,
                sent: RobotTime::new(1.0),
                deliveries,
                ..Request::EMPTY
            });
        }
    }

    #[test]
    fn one_more_among_many_is_no_news_and_a_twentieth_more_is() {
        let mut controller = Controller::new(Settings::default());
        let nothing = controller.saved();
        assert!(!nothing.is_news_after(&nothing));
        deliver(&mut controller, 0, 1);
        assert!(controller.saved().is_news_after(&nothing), "the first of all");
        deliver(&mut controller, 1, 200);
        let kept = controller.saved();
        deliver(&mut controller, 200, 210);
        assert!(!controller.saved().is_news_after(&kept), "210 after 200");
        deliver(&mut controller, 210, 211);
        assert!(controller.saved().is_news_after(&kept), "211 after 200");
        assert!(nothing.is_news_after(&kept), "it was begun anew");
    }

    #[test]
    fn another_phase_of_the_task_is_news() {
        let mut controller = Controller::new(Settings::default());
        let idle = controller.saved();
        controller.set_task(Task::thesis());
        let calibrating = controller.saved();
        assert!(calibrating.is_news_after(&idle));
        assert!(!calibrating.is_news_after(&calibrating));
        controller.set_task(Task { calibration: None, ..Task::thesis() });
        assert!(controller.saved().is_news_after(&calibrating));
    }

    /// Held against the definition: a mean counts as moved beyond half of its own standard deviation.
    #[test]
    fn a_mean_that_moves_by_half_its_deviation_is_news() {
        let belief = |mu| NormalInverseChiSquared::new(mu, 16.0, 6.0, 1.0).unwrap();
        // E[sigma^2] = s / (r - 2) = 0.25, and the mean's variance is a sixteenth of it.
        let sd = (0.25_f64 / 16.0).sqrt();
        assert!(!has_moved(belief(0.0), belief(0.49 * sd)));
        assert!(has_moved(belief(0.0), belief(0.51 * sd)));
        assert!(has_moved(belief(0.0), belief(-0.51 * sd)));
    }
}
