//! Pieces of commanded motion on their way into a prediction: those that are as good as one go in as one.

use super::motion::Motion;
use crate::geometry::Twist;

/// Longest motion that is gathered, in s.
const LONGEST: f64 = 0.3;

/// Most by which speeds may differ within a motion: |d omega| |v| + |d v| |omega| in m/s^2.
///
/// What differs moves the end of the longest motion aside by a twelfth of this x (0.3 s)^2: by 0.03 mm, a sixteenth of a
/// camera's noise. Turns in place and straight motions are always alike.
const ALIKE: f64 = 0.004;

/// Most pieces that go in by themselves; more are gathered after them. Fifteen seconds of slots: a robot that was not seen
/// for longer may be anywhere, and ten thousand agents must not be moved ten thousand times.
const MOST_APART: u32 = 500;

/// Gathers pieces that follow each other.
#[derive(Clone, Copy, Debug)]
pub struct Pieces {
    longest: f64,
    /// How many more go in by themselves.
    apart: u32,
    first: Twist,
    gathered: Motion,
}

impl Pieces {
    /// None yet; those that are alike go in as one.
    pub fn gathered() -> Self {
        Self { longest: LONGEST, apart: 0, first: Twist::ZERO, gathered: Motion::NONE }
    }

    /// None yet; each goes in by itself, up to `MOST_APART`.
    pub fn apart() -> Self {
        Self { longest: 0.0, apart: MOST_APART, ..Self::gathered() }
    }

    /// Takes in the motion of holding `twist` for `duration` s. Returns what was gathered before where that ends here.
    pub fn add(&mut self, twist: Twist, duration: f64) -> Option<Motion> {
        if twist == Twist::ZERO {
            return None;
        }
        let next = Motion::new(twist, duration);
        let (linear, angular) =
            (twist.linear - self.first.linear, twist.angular - self.first.angular);
        let apart = (angular * twist.linear).abs() + (linear * twist.angular).abs();
        let begun = self.gathered.is_motion();
        if begun && apart <= ALIKE && self.gathered.duration + duration <= self.longest {
            self.gathered = self.gathered.then(next);
            return None;
        }
        if self.apart > 0 {
            self.apart -= 1;
            self.longest = if self.apart == 0 { LONGEST } else { self.longest };
        }
        let ended = std::mem::replace(&mut self.gathered, next);
        self.first = twist;
        begun.then_some(ended)
    }

    /// What is left.
    pub fn rest(self) -> Option<Motion> {
        self.gathered.is_motion().then_some(self.gathered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::horizon::SLOT;
    use crate::kinematics::Kind;
    use crate::prediction::{ChannelModel, ErrorModel, Moments};
    use crate::settings::PoseNoise;
    use proptest::prelude::*;

    fn gather(mut pieces: Pieces, twists: &[Twist]) -> Vec<Motion> {
        let mut motions: Vec<_> =
            twists.iter().filter_map(|&twist| pieces.add(twist, SLOT)).collect();
        motions.extend(pieces.rest());
        motions
    }

    #[test]
    fn what_is_alike_is_one_up_to_the_longest() {
        let twists = [Twist::new(0.1, 0.2); 21];
        assert_eq!(gather(Pieces::apart(), &twists), twists.map(|twist| Motion::new(twist, SLOT)));
        let motions = gather(Pieces::gathered(), &twists);
        assert!(motions.len() == 3 && motions.iter().all(|motion| motion.duration < 0.301));
        // However fast: straight ahead, and in place.
        for twist in [Twist::new(0.02, 0.0), Twist::new(0.0, -0.2)] {
            let twists: Vec<_> = (1..6).map(|times| twist.scaled(f64::from(times))).collect();
            assert_eq!(gather(Pieces::gathered(), &twists).len(), 1);
        }
    }

    /// Guards against: a robot that brakes for minutes unseen costs as many moves of all agents as its ramp has steps.
    #[test]
    fn however_many_pieces_there_are_few_motions_come_of_them() {
        let most = MOST_APART as usize;
        assert_eq!(gather(Pieces::apart(), &vec![Twist::new(0.1, 0.2); most]).len(), most);
        let motions = gather(Pieces::apart(), &vec![Twist::new(0.1, 0.2); 20 * most]);
        assert!(motions.len() < 4 * most, "{}", motions.len());
        let driven: f64 = motions.iter().map(|motion| motion.duration).sum();
        assert!((driven - 20.0 * MOST_APART as f64 * SLOT).abs() < 1e-6, "none is left out");
    }

    #[test]
    fn what_differs_stays_apart_and_rest_is_no_motion() {
        let twists = [(0.1, 0.0), (0.1, 0.06), (-0.1, 0.06), (0.0, 0.06)];
        assert_eq!(gather(Pieces::gathered(), &twists.map(|(v, w)| Twist::new(v, w))).len(), 4);
        assert_eq!(gather(Pieces::gathered(), &[Twist::ZERO; 5]), []);
        let slow = Twist::new(0.004, 0.0);
        let motions = gather(Pieces::gathered(), &[Twist::ZERO, slow, Twist::ZERO]);
        assert_eq!(motions, [Motion::new(slow, SLOT)]);
    }

    proptest! {
        /// Guards against: a prediction that is another because its commands were gathered.
        #[test]
        fn gathered_or_apart_the_prediction_is_the_same(
            commands in proptest::collection::vec((-0.13..0.13f64, -1.25..1.25f64, 1usize..8), 1..4),
            bend in 0.0..0.03f64, heading in -3.0..3.0f64,
        ) {
            let twists: Vec<_> = commands.iter().flat_map(|&(v, w, slots)| {
                (0..slots).map(move |slot| Twist::new(v, w + bend * slot as f64 / 8.0))
            }).collect();
            let model = ErrorModel {
                forward: ChannelModel { mean_variance: 0.001, ..ChannelModel::known(-0.1, 0.01) },
                lateral: ChannelModel::known(0.02, 0.001),
                turn: ChannelModel { mean_variance: 0.002, ..ChannelModel::known(0.1, 0.02) },
                drift: ChannelModel::known(0.1, 0.01),
            };
            let [one, other] = [Pieces::apart(), Pieces::gathered()].map(|pieces| {
                let mut moments = Moments::new(Kind::Differential, Pose::new(0.1, 0.2, heading), PoseNoise::CAMERA);
                gather(pieces, &twists).into_iter().for_each(|motion| moments.advance(&model, motion));
                moments
            });
            let (a, b) = (one.mean(), other.mean());
            prop_assert!(a.point().distance(b.point()) < 1e-4, "{a:?} {b:?}");
            prop_assert!(a.heading.minus(b.heading).abs() < 1e-12);
            let (a, b) = (one.spread(), other.spread());
            prop_assert!((a.heading / b.heading - 1.0).abs() < 1e-9, "{a:?} {b:?}");
            prop_assert!((a.position / b.position - 1.0).abs() < 0.05, "{a:?} {b:?}");
        }
    }
}
