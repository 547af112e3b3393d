//! The thesis's prediction by Monte Carlo (its section 4.1.3): agents with random errors, counted in cells.

use super::model::{ChannelModel, ERROR_WINDOW, ErrorModel};
use super::motion::Motion;
use super::spread::Spread;
use crate::geometry::elementary::sin_cos;
use crate::geometry::{Displacement, Pose};
use crate::kinematics::Kind;
use crate::settings::PoseNoise;
use rand::{RngExt, SeedableRng};
use rand_distr::{ChiSquared, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// One possible robot: where it is, and the error distribution that it drives with.
#[derive(Clone, Copy, Debug)]
struct Agent {
    x: f64,
    y: f64,
    heading: f64,
    /// Mean and standard deviation of each channel's ratio, drawn once.
    channels: [(f64, f64); 4],
}

/// A cell of the thesis's table: indices in x, y and heading, with the number of agents in it.
type Cell = ([i64; 3], u32);

/// Possible poses of a robot, each with its own draw from the posterior.
#[derive(Clone, Debug)]
pub struct Agents {
    agents: Vec<Agent>,
    random: Pcg64Mcg,
    cell: f64,
    /// Motion to the left in m per radian of turn.
    sideways: f64,
}

impl Agents {
    /// `agents` robots of this kind (at least one) at an observed pose; `cell` is the edge of a table cell in m, and ten times
    /// as many rad for the heading.
    pub fn new(
        kind: Kind,
        pose: Pose,
        noise: PoseNoise,
        model: &ErrorModel,
        agents: usize,
        cell: f64,
        seed: u64,
    ) -> Self {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let agents = (0..agents.max(1))
            .map(|_| Agent {
                x: pose.x + noise.position * normal(&mut random),
                y: pose.y + noise.position * normal(&mut random),
                heading: pose.heading.radians() + noise.heading * normal(&mut random),
                channels: [model.forward, model.lateral, model.turn, model.drift]
                    .map(|channel| draw(channel, &mut random)),
            })
            .collect();
        Self { agents, random, cell, sideways: kind.sideways() }
    }

    /// Moves every agent by one commanded motion with errors of its own.
    pub fn advance(&mut self, motion: Motion) {
        if !motion.is_motion() {
            return;
        }
        let Motion { length, turn, duration, .. } = motion;
        let share = (ERROR_WINDOW / duration).sqrt();
        for agent in &mut self.agents {
            let [forward, lateral, around, drift] =
                agent.channels.map(|(mean, sd)| mean + sd * share * normal(&mut self.random));
            let turned = turn * (1.0 + around) + length * drift;
            let (sin, cos) = sin_cos(agent.heading + turned / 2.0);
            let (ahead, mut aside) = (length * (1.0 + forward), length * lateral);
            if self.sideways != 0.0 {
                aside += self.sideways * turned;
            }
            agent.x += ahead * cos - aside * sin;
            agent.y += ahead * sin + aside * cos;
            agent.heading += turned;
        }
    }

    /// The thesis's table: how many agents are in each cell around the first one, sorted by cell.
    fn table(&self) -> (Pose, Vec<Cell>) {
        let first = &self.agents[0];
        let (x, y, heading) = (first.x, first.y, first.heading);
        let index = |offset: f64, edge: f64| (offset / edge).round() as i64;
        let mut cells: Vec<[i64; 3]> = self
            .agents
            .iter()
            .map(|agent| {
                [
                    index(agent.x - x, self.cell),
                    index(agent.y - y, self.cell),
                    index(agent.heading - heading, 10.0 * self.cell),
                ]
            })
            .collect();
        cells.sort_unstable();
        let table = cells
            .chunk_by(|one, other| one == other)
            .map(|same| (same[0], same.len() as u32))
            .collect();
        (Pose::new(x, y, heading), table)
    }

    /// Mean offset from the table's origin, and the second central moments (xx, yy, xy, heading).
    fn moments(&self) -> (Pose, [f64; 3], [f64; 4]) {
        let (origin, table) = self.table();
        let total = self.agents.len() as f64;
        let edges = [self.cell, self.cell, 10.0 * self.cell];
        let place = |cell: &[i64; 3]| -> [f64; 3] {
            std::array::from_fn(|axis| cell[axis] as f64 * edges[axis])
        };
        let mut mean = [0.0; 3];
        for (cell, count) in &table {
            let at = place(cell);
            for axis in 0..3 {
                mean[axis] += at[axis] * f64::from(*count) / total;
            }
        }
        let mut second = [0.0; 4];
        for (cell, count) in &table {
            let at = place(cell);
            let [dx, dy, dh] = std::array::from_fn(|axis| at[axis] - mean[axis]);
            for (sum, term) in second.iter_mut().zip([dx * dx, dy * dy, dx * dy, dh * dh]) {
                *sum += term * f64::from(*count) / total;
            }
        }
        (origin, mean, second)
    }

    /// The expected pose.
    pub fn mean(&self) -> Pose {
        let (origin, [x, y, heading], _) = self.moments();
        // The offset is in world axes.
        Pose { heading: origin.heading, ..Pose::new(origin.x + x, origin.y + y, 0.0) }
            .then(Displacement { turn: heading, ..Displacement::default() })
    }

    /// The variances that the variance rule looks at.
    pub fn spread(&self) -> Spread {
        let (_, _, [xx, yy, xy, heading]) = self.moments();
        Spread::new(xx, yy, xy, heading)
    }
}

fn normal(random: &mut Pcg64Mcg) -> f64 {
    random.sample(StandardNormal)
}

/// A mean and standard deviation from what is believed of a channel: sigma^2 = s/chi^2_r, mu ~ N(mu_n, sigma^2/k_n).
fn draw(channel: ChannelModel, random: &mut Pcg64Mcg) -> (f64, f64) {
    let Some(posterior) = channel.posterior else {
        return (channel.mean, channel.variance.sqrt());
    };
    let sd = match ChiSquared::new(posterior.r()) {
        Ok(chi_squared) => (posterior.s() / random.sample(chi_squared)).sqrt(),
        Err(_) => channel.variance.sqrt(),
    };
    (channel.mean + sd / posterior.k().sqrt() * normal(random), sd)
}

#[cfg(test)]
mod tests {
    use super::super::{Moments, Prediction};
    use super::*;
    use crate::conjugate::NormalInverseChiSquared;
    use crate::kinematics::SkidSteer;

    const AGENTS: usize = 40_000;

    /// Twenty slots: a turn, then a curve, at the robot's full speed.
    fn drive() -> Vec<Motion> {
        let slot = 0.03;
        let turning = Motion::arc(0.0, 1.25 * slot, slot);
        let driving = Motion::arc(0.13 * slot, 0.3 * slot, slot);
        [vec![turning; 8], vec![driving; 20]].concat()
    }

    fn both(kind: Kind, model: &ErrorModel) -> (Moments, Agents) {
        let (pose, noise) =
            (Pose::new(0.2, -0.1, 2.9), PoseNoise { position: 0.0005, heading: 0.003 });
        let mut moments = Moments::new(kind, pose, noise);
        let mut agents = Agents::new(kind, pose, noise, model, AGENTS, 1e-5, 7);
        for motion in drive() {
            moments.advance(model, motion);
            agents.advance(motion);
        }
        (moments, agents)
    }

    /// Of every kind; the middle of a skid-steer robot also spreads as its heading does, by up to 4 cm here.
    fn compare(model: &ErrorModel, tolerance: f64) {
        let skid = |sideways| Kind::SkidSteer(SkidSteer { sideways, turn_by_speed: 0.0 });
        for kind in [Kind::Differential, skid(0.04), skid(-0.04)] {
            compare_kind(kind, model, tolerance);
        }
    }

    fn compare_kind(kind: Kind, model: &ErrorModel, tolerance: f64) {
        let (moments, agents) = both(kind, model);
        let (expected, got) = (agents.spread(), moments.spread());
        assert!((got.position / expected.position - 1.0).abs() < tolerance, "{got:?} {expected:?}");
        assert!((got.heading / expected.heading - 1.0).abs() < tolerance, "{got:?} {expected:?}");
        // The mean of n agents is known to 4 sd/sqrt(n).
        let near = 4.0 * (expected.position / AGENTS as f64).sqrt() + 1e-5;
        assert!(moments.mean().point().distance(agents.mean().point()) < near);
        let near = 4.0 * (expected.heading / AGENTS as f64).sqrt() + 1e-4;
        assert!(moments.mean().heading.minus(agents.mean().heading).abs() < near);
    }

    /// The relative error of a variance from n agents is sqrt(2/n) = 0.7 %; four times that.
    #[test]
    fn with_known_variances_the_moments_agree_to_sampling_error() {
        let model = ErrorModel {
            forward: ChannelModel::known(-0.1, 0.04),
            lateral: ChannelModel::known(0.02, 0.01),
            turn: ChannelModel::known(-0.05, 0.02),
            drift: ChannelModel::known(0.3, 1.0),
        };
        compare(&model, 4.0 * (2.0 / AGENTS as f64).sqrt());
    }

    /// A Student t with few degrees of freedom has heavy tails: its sampled variance is itself noisy.
    #[test]
    fn with_a_posterior_they_agree_to_a_tenth_above_four_degrees_of_freedom() {
        let believed = |mu, k, r, sd: f64| {
            let posterior = NormalInverseChiSquared::new(mu, k, r, sd * sd * (r - 2.0));
            ChannelModel::from_posterior(posterior.expect("valid"))
        };
        let model = ErrorModel {
            forward: believed(-0.1, 2.0, 8.0, 0.15),
            lateral: believed(0.0, 4.0, 8.0, 0.05),
            turn: believed(0.05, 3.0, 8.0, 0.12),
            drift: ChannelModel::PERFECT,
        };
        compare(&model, 0.10);
    }

    /// Var(heading) = E[sigma^2] (sum phi^2 + (sum phi)^2/k_n), with white errors of 100 ms each.
    #[test]
    fn the_heading_variance_shares_the_mean() {
        let posterior = NormalInverseChiSquared::new(0.0, 2.0, 6.0, 0.04).expect("valid");
        let model =
            ErrorModel { turn: ChannelModel::from_posterior(posterior), ..ErrorModel::PERFECT };
        let mut moments = Moments::new(Kind::Differential, Pose::default(), PoseNoise::default());
        let phi = 0.1;
        for _ in 0..20 {
            moments.advance(&model, Motion::arc(0.0, phi, 0.1));
        }
        let (sum_of_squares, sum) = (20.0 * phi * phi, 20.0 * phi);
        let expected = 0.01 * (sum_of_squares + sum * sum / 2.0);
        assert!((moments.spread().heading - expected).abs() < 1e-12);
    }

    /// How a stretch of time is cut into pieces does not change what is predicted.
    #[test]
    fn cutting_a_motion_does_not_change_its_spread() {
        let model = ErrorModel {
            forward: ChannelModel::known(0.05, 0.04),
            turn: ChannelModel::known(0.0, 0.05),
            ..ErrorModel::PERFECT
        };
        let spread = |pieces: u32| {
            let mut prediction =
                Prediction::moments(Kind::Differential, Pose::default(), PoseNoise::default());
            let share = 1.0 / f64::from(pieces);
            for _ in 0..pieces {
                let motion = Motion::arc(0.02 * share, 0.05 * share, 0.15 * share);
                prediction.advance(&model, motion);
            }
            prediction.spread()
        };
        let (one, many) = (spread(1), spread(15));
        assert!((one.heading / many.heading - 1.0).abs() < 1e-9);
        assert!((one.position / many.position - 1.0).abs() < 1e-3);
    }

    /// No variance: the moments go where the arc goes.
    #[test]
    fn without_errors_the_prediction_is_the_arc() {
        let mut prediction =
            Prediction::moments(Kind::Differential, Pose::new(1.0, 2.0, 0.5), PoseNoise::default());
        for _ in 0..100 {
            let motion = Motion::arc(0.0013, 0.01, 0.01);
            prediction.advance(&ErrorModel::PERFECT, motion);
        }
        let exact = Pose::new(1.0, 2.0, 0.5).then(crate::kinematics::arc(0.13, 1.0));
        assert!(prediction.mean().point().distance(exact.point()) < 1e-6);
        assert_eq!(prediction.spread(), Spread { position: 0.0, heading: 0.0 });
    }
}
