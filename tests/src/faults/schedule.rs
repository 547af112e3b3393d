//! Which faults come to whom, and when: a function of the seed.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::ops::Range;

/// A kind of injection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// SIGKILL to the server, and a new one on the same data.
    ServerKill,
    /// The server stands still: SIGSTOP, SIGCONT.
    ServerPause,
    /// SIGTERM to the server, and a new one.
    ServerRestart,
    /// Nothing more can be written to any file of the server.
    DiskFull,
    /// Another program holds the server's store.
    StoreHeld,
    /// All robots are stopped, and resumed.
    StopAll,
    /// SIGKILL to an agent, and a new one.
    AgentKill,
    /// The link is gone, its connections closed.
    LinkCut,
    /// The link has forgotten its connections: what is sent over them goes nowhere.
    HalfOpen,
    /// Requests overtake others that were sent before.
    Reorder,
    /// Requests come again, in any order.
    Duplicate,
    /// Nothing comes through, and everything afterwards.
    Silence,
    /// The tracker repeats its last pose with fresh stamps.
    FrozenTracker,
    /// The wheels are told to turn and do not.
    BlockedWheels,
    /// The tracker shows nothing.
    NoPoses,
    /// One robot is stopped, and resumed.
    Stop,
    /// A resume is under way when the robot is stopped.
    StopRace,
    /// The robot gets another task.
    NewTask,
}

impl Kind {
    /// Every kind, those of the server first.
    pub const ALL: [Self; 18] = [
        Self::ServerKill,
        Self::ServerPause,
        Self::ServerRestart,
        Self::DiskFull,
        Self::StoreHeld,
        Self::StopAll,
        Self::AgentKill,
        Self::LinkCut,
        Self::HalfOpen,
        Self::Reorder,
        Self::Duplicate,
        Self::Silence,
        Self::FrozenTracker,
        Self::BlockedWheels,
        Self::NoPoses,
        Self::Stop,
        Self::StopRace,
        Self::NewTask,
    ];

    /// Whether it concerns all robots; the others come to one of them.
    pub fn is_of_server(self) -> bool {
        (self as usize) < 6
    }

    /// How long it lasts in s.
    fn lasts(self) -> Range<f64> {
        match self {
            Self::ServerKill | Self::ServerRestart => 0.05..1.5,
            Self::ServerPause | Self::StoreHeld => 1.0..3.0,
            Self::DiskFull => 1.5..3.5,
            // Long enough to see whether it moves again.
            Self::StopAll | Self::Stop | Self::StopRace => 4.0..6.0,
            Self::AgentKill => 0.05..2.0,
            Self::LinkCut | Self::Reorder => 0.5..4.0,
            Self::HalfOpen | Self::Duplicate | Self::NewTask => 0.5..1.0,
            Self::Silence => 12.0..12.1,
            // Long enough to see that it rests, and that it does so to the end.
            Self::FrozenTracker | Self::BlockedWheels | Self::NoPoses => 6.0..9.0,
        }
    }
}

/// One injection.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Injection {
    /// Its number, from 1 on.
    pub number: usize,
    /// What is injected.
    pub kind: Kind,
    /// The number of the robot that it comes to; none for all.
    pub robot: Option<usize>,
    /// When it may begin, in s after the first.
    pub from: f64,
    /// How long it lasts in s.
    pub lasts: f64,
    /// Seed of what else is random about it.
    pub seed: u64,
}

/// Time in s from one injection of the server to the next, and from one of a robot to its next: with what it takes to
/// recover, and some peace.
const PACE_OF_SERVER: f64 = 7.0;
const PACE_OF_ROBOT: f64 = 15.0;

/// `count` injections for so many robots. Kinds come in rounds of all of them, each round in an order of its own.
pub fn schedule(seed: u64, count: usize, robots: usize) -> Vec<Injection> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut kinds: Vec<Kind> = Vec::new();
    while kinds.len() < count {
        let mut round = Kind::ALL;
        round.shuffle(&mut rng);
        kinds.extend(round);
    }
    kinds.truncate(count);
    let of_server = kinds.iter().filter(|kind| kind.is_of_server()).count();
    let per_robot = (count - of_server).div_ceil(robots.max(1));
    let whole = (of_server as f64 * PACE_OF_SERVER).max(per_robot as f64 * PACE_OF_ROBOT);
    let (mut server, mut others) = (0, 0);
    let mut order: Vec<usize> = (0..robots).collect();
    let mut injections = Vec::with_capacity(count);
    for (index, kind) in kinds.into_iter().enumerate() {
        let (robot, turn, turns) = if kind.is_of_server() {
            server += 1;
            (None, server - 1, of_server)
        } else {
            if others % robots == 0 {
                order.shuffle(&mut rng);
            }
            others += 1;
            (Some(order[(others - 1) % robots]), (others - 1) / robots, per_robot)
        };
        let pace = whole / turns as f64;
        injections.push(Injection {
            number: index + 1,
            kind,
            robot,
            from: pace * (f64::from(turn as u32) + rng.random_range(0.0..0.5)),
            lasts: rng.random_range(kind.lasts()),
            seed: rng.random(),
        });
    }
    injections
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_seed_says_it_all() {
        assert_eq!(schedule(1, 300, 20), schedule(1, 300, 20));
        assert_ne!(schedule(1, 300, 20), schedule(2, 300, 20));
    }

    #[test]
    fn every_round_has_every_kind_and_no_one_is_left_out() {
        let injections = schedule(3, 18 * 20, 20);
        for round in injections.chunks(Kind::ALL.len()) {
            let kinds: BTreeSet<Kind> = round.iter().map(|injection| injection.kind).collect();
            assert_eq!(kinds.len(), Kind::ALL.len());
        }
        let robots: BTreeSet<usize> = injections.iter().filter_map(|it| it.robot).collect();
        assert_eq!(robots.len(), 20);
        for injection in &injections {
            assert_eq!(injection.robot.is_none(), injection.kind.is_of_server());
        }
        let last = injections.iter().map(|it| it.from + it.lasts).fold(0.0, f64::max);
        assert!(last < 25.0 * 60.0, "{last} s");
    }

    #[test]
    fn whoever_gets_several_gets_them_one_after_the_other() {
        let injections = schedule(4, 300, 7);
        for robot in 0..7 {
            let mine = injections.iter().filter(|it| it.robot == Some(robot));
            let times: Vec<f64> = mine.map(|it| it.from).collect();
            assert!(times.is_sorted(), "{times:?}");
        }
    }
}
