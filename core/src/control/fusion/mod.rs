//! Where the robot is: observed poses fused with what its commands predict (eq. 3 of the thesis), though some poses lie.
//!
//! Trackers flip headings, lose the robot, correct their map. No fixed angle tells such a pose from a robot that slipped:
//! its likelihood does. Every pose is explained by each of a few hypotheses of where the robot is, in one of four ways: it
//! moved as commanded, give or take what is known of drive and floor; it moved otherwise, as far as it can; the heading is
//! wrong; or all of the pose is. A pose that is wrong by the best hypothesis begins another one, in which that pose
//! is right and those before were wrong. Poses that go on to agree with it make it the likelier one after some tenths of a
//! second; and where poses of two minds alternate, how the positions move on decides between them.

mod gaussian;
mod noise;

pub use gaussian::{Gaussian, Moved, Updated};
pub use noise::{Identified, Kind, NoiseBelief, Step};

use crate::geometry::Pose;
use arrayvec::ArrayVec;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{LN_2, PI, TAU};

/// Hypotheses at once: where the robot is, where else it may be, and one that may have to go.
const MOST: usize = 3;

/// A pose out of so many shows a motion other than commanded: a wheel that stands, a push.
const OTHERWISE: f64 = 0.05;

/// A pose out of so many has a wrong heading, and another one is altogether wrong, where the one before was right.
const WRONG: f64 = 0.01;

/// Of wrong poses so many are about where the last wrong one was.
const AGAIN: f64 = 0.9;

/// Time in s for which a tracker that went wrong stays so.
const STAYS_WRONG: f64 = 0.15;

/// Least probability that the pose after a wrong one is wrong.
const LEAST_WRONG: f64 = 0.5;

/// Poses that are wrong alike and count.
const MOST_ALIKE: f64 = 8.0;

/// Radius in m within which a wrong pose is anywhere.
const ANYWHERE: f64 = 5.0;

/// Probability that with a wrong pose those before were wrong, or the robot was carried.
const ANOTHER: f64 = 2.5e-3;

/// Times as likely as the hypothesis that was gone by another one has to be.
const LIKELIER: f64 = 2.0;

/// A hypothesis that is less likely by this is given up.
const GIVEN_UP: f64 = 1e-9;

/// Share of a pose in what is known of how well motion is predicted: some ten poses.
const SHARE: f64 = 0.1;

/// Variances that a pose may lie off by, in parts of what is expected, and count.
const MOST_SURPRISE: f64 = 9.0;

/// What an observed pose is to the robot's controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// It shows where the robot is.
    Accepted,
    /// It lies this far in m from where the robot is.
    SetAside {
        /// Distance in m.
        distance: f64,
    },
    /// Poses that were set aside so far are those that show where the robot is.
    Again,
}

/// How a robot can move in the time between two poses, whatever is commanded: standard deviations in m and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// In m, either way.
    pub far: f64,
    /// In rad.
    pub round: f64,
}

/// One hypothesis of where the robot is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hypothesis {
    pose: Gaussian,
    ln_weight: f64,
    /// How far the poses that were wrong by it lay off of late.
    wrong: Option<Wrong>,
    /// Whether that was the last of all.
    is_wrong: bool,
}

/// How far poses lie off that are wrong alike.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wrong {
    /// Their mean: x, y in m and heading in rad.
    by: Vector3<f64>,
    /// How many count in it.
    poses: f64,
}

/// Where the robot is.
#[derive(Clone, Debug, PartialEq)]
pub struct Fusion {
    /// The first is the one that is gone by.
    hypotheses: ArrayVec<Hypothesis, MOST>,
    /// How far poses lie off of late against what is expected, in variances.
    surprise: f64,
}

impl Fusion {
    /// At an observed pose of this `noise` (covariance).
    pub fn new(observed: Pose, noise: &Matrix3<f64>) -> Self {
        let mut hypotheses = ArrayVec::new();
        hypotheses.push(Hypothesis::at(observed, noise));
        Self { hypotheses, surprise: 1.0 }
    }

    /// Where the robot is, and how surely.
    pub fn pose(&self) -> &Gaussian {
        &self.hypotheses[0].pose
    }

    /// Takes in a pose `observed` with this `noise` (covariance) `span` s after the last one, since which the robot has `moved`
    /// by its commands, and may have moved within `reach` otherwise.
    pub fn observe(
        &mut self,
        moved: &Moved,
        reach: Reach,
        span: f64,
        observed: Pose,
        noise: &Matrix3<f64>,
    ) -> Verdict {
        // Where poses lie off farther than they should the motion is known less well than it seems.
        let covariance = moved.covariance * self.surprise.max(1.0);
        let moved = Moved { covariance, ..*moved };
        let way = Way { moved, reach, span, observed, noise };
        let before = self.pose().after(&moved).mean;
        for (index, it) in self.hypotheses.iter_mut().enumerate() {
            let surprise = it.explain(&way);
            if index == 0
                && let Some(surprise) = surprise
            {
                let surprise = (surprise / 3.0).min(MOST_SURPRISE);
                self.surprise += SHARE * (surprise - self.surprise);
            }
        }
        self.begin_another(&way, before);
        self.choose(before, observed)
    }

    /// Takes in a pose that was taken before the newest one, since when the robot has `moved`.
    pub fn observe_late(&mut self, moved: &Moved, observed: Pose, noise: &Matrix3<f64>) {
        // What it shows of now is less by what the motion since adds.
        let now = Gaussian { mean: observed, covariance: *noise }.after(moved);
        for it in &mut self.hypotheses {
            if let Some(updated) = it.pose.fused(now.mean, &now.covariance)
                && updated.surprise < MOST_SURPRISE
            {
                it.pose = updated.pose;
            }
        }
    }

    /// Begins the hypothesis that a pose is right which is wrong by the one that is gone by.
    fn begin_another(&mut self, way: &Way, expected: Pose) {
        // Those that call it right know it already.
        if !self.hypotheses.iter().all(|it| it.is_wrong) {
            return;
        }
        let pose = Gaussian { mean: way.observed, covariance: *way.noise };
        let another = Hypothesis {
            ln_weight: self.hypotheses[0].ln_weight + (ANOTHER / WRONG).ln(),
            wrong: Some(Wrong { by: pose.off(expected), poses: 1.0 }),
            is_wrong: false,
            pose,
        };
        if self.hypotheses.is_full() {
            // The least likely of the others goes.
            let others = self.hypotheses[1..].iter_mut();
            if let Some(least) =
                others.min_by(|one, other| one.ln_weight.total_cmp(&other.ln_weight))
            {
                *least = another;
            }
        } else {
            self.hypotheses.push(another);
        }
    }

    fn choose(&mut self, expected: Pose, observed: Pose) -> Verdict {
        let best = self.hypotheses.iter().map(|it| it.ln_weight).fold(f64::NEG_INFINITY, f64::max);
        let is_gone_by = self.hypotheses[0].ln_weight + LIKELIER.ln() >= best;
        if !is_gone_by
            && let Some(likelier) = self.hypotheses.iter().position(|it| it.ln_weight >= best)
        {
            let likelier = self.hypotheses.remove(likelier);
            self.hypotheses.insert(0, likelier);
        }
        for it in &mut self.hypotheses {
            it.ln_weight -= best;
        }
        let chosen = self.hypotheses.remove(0);
        self.hypotheses.retain(|it| it.ln_weight > GIVEN_UP.ln());
        self.hypotheses.insert(0, chosen);
        if chosen.is_wrong {
            Verdict::SetAside { distance: expected.point().distance(observed.point()) }
        } else if is_gone_by {
            Verdict::Accepted
        } else {
            Verdict::Again
        }
    }
}

/// What hypotheses are to explain.
struct Way<'a> {
    moved: Moved,
    reach: Reach,
    span: f64,
    observed: Pose,
    noise: &'a Matrix3<f64>,
}

impl Hypothesis {
    fn at(observed: Pose, noise: &Matrix3<f64>) -> Self {
        let pose = Gaussian { mean: observed, covariance: *noise };
        Self { pose, ln_weight: 0.0, wrong: None, is_wrong: false }
    }

    /// Explains a pose in the way that is likeliest; by how many variances it lies off where it is right.
    fn explain(&mut self, way: &Way) -> Option<f64> {
        let &Way { ref moved, reach, span, observed, noise } = way;
        let expected = self.pose.after(moved);
        // A tracker that went wrong goes on so for a while.
        let is_wrong =
            if self.is_wrong { (-span / STAYS_WRONG).exp().max(LEAST_WRONG) } else { 2.0 * WRONG };
        let ln_density =
            |it: &Option<Updated>| it.as_ref().map_or(f64::NEG_INFINITY, |it| it.ln_density);
        let as_moved = |expected: Gaussian, noise: &Matrix3<f64>| {
            let normal = expected.fused(observed, noise);
            let mut ln_likelihood = (1.0 - OTHERWISE).ln() + ln_density(&normal);
            let (mut likeliest, mut updated) = (ln_likelihood, normal);
            // It drove otherwise, turned otherwise, or both.
            let (far, round) = (reach.far.powi(2), reach.round.powi(2));
            for spread in [[far, far, 0.0], [0.0, 0.0, round], [far, far, round]] {
                let covariance = expected.covariance + Matrix3::from_diagonal(&spread.into());
                let other = Gaussian { covariance, ..expected }.fused(observed, noise);
                let likely = (OTHERWISE / 3.0).ln() + ln_density(&other);
                ln_likelihood = ln_sum(ln_likelihood, likely);
                if likely > likeliest {
                    (likeliest, updated) = (likely, other);
                }
            }
            (ln_likelihood, updated, normal)
        };
        let (likelihood, updated, normal) = as_moved(expected, noise);
        let of_right = (1.0 - is_wrong).ln() + likelihood;

        // A wrong heading is any; a wrong pose is anywhere. Or either lies off as far as when last wrong.
        let position = expected.fused_position(observed, noise);
        let by_heading = ln_density(&position) - TAU.ln();
        let anywhere = -(TAU * PI * ANYWHERE * ANYWHERE).ln();
        let fresh = ln_sum(by_heading, anywhere) - LN_2;
        let again = self.wrong.map(|Wrong { by, poses }| {
            let again = Gaussian { mean: expected.moved_by(by), ..expected };
            let (again, ..) = as_moved(again, &(noise * (1.0 + poses.recip())));
            AGAIN.ln() + again
        });
        let of_wrong = match again {
            Some(again) => ln_sum(again, (1.0 - AGAIN).ln() + fresh),
            None => fresh,
        };
        let of_wrong = is_wrong.ln() + of_wrong;
        self.ln_weight += ln_sum(of_right, of_wrong);
        if of_right >= of_wrong {
            self.pose = updated.map_or(expected, |it| it.pose);
            self.is_wrong = false;
            return normal.map(|it| it.surprise);
        }
        // Where the position is right it still shows where the robot is.
        let holds = position.filter(|it| it.surprise < MOST_SURPRISE);
        let off = expected.off(observed);
        let alike = self.wrong.filter(|_| again.is_some_and(|again| again > fresh));
        let mut wrong = alike.unwrap_or(Wrong { by: off, poses: 0.0 });
        wrong.poses = (wrong.poses + 1.0).min(MOST_ALIKE);
        wrong.by += (off - wrong.by) / wrong.poses;
        (self.wrong, self.is_wrong) = (Some(wrong), true);
        self.pose = holds.map_or(expected, |it| it.pose);
        None
    }
}

/// ln(e^a + e^b).
fn ln_sum(a: f64, b: f64) -> f64 {
    let (high, low) = if a > b { (a, b) } else { (b, a) };
    if low == f64::NEG_INFINITY { high } else { high + (low - high).exp().ln_1p() }
}

#[cfg(test)]
mod tests;
