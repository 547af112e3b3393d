//! Work without robots: the pool is tested with it.

use crate::work::{Told, Work};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// What a [`Toy`] is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Wishes {
    pub(super) batches: usize,
    /// Of each batch.
    pub(super) episodes: usize,
    /// Time in µs that an episode takes.
    pub(super) micros: u64,
    /// Whether the first episode panics.
    pub(super) panics: bool,
}

impl Default for Wishes {
    fn default() -> Self {
        Self { batches: 1, episodes: 10, micros: 0, panics: false }
    }
}

/// Counts: the place of an evaluation shows in what comes of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Toy {
    version: u32,
    wishes: Wishes,
    done: usize,
    sum: u64,
    report: Option<u64>,
}

impl Work for Toy {
    const STATE_VERSION: u32 = 1;
    type Settings = Wishes;
    type State = Self;
    type Stage = usize;
    type Latest = u64;
    type Part = u64;
    type Report = u64;
    type Episode = usize;
    type Evaluation = usize;

    fn resume(_: Wishes, state: Self) -> Result<Self, String> {
        Ok(state)
    }

    fn state(&self) -> &Self {
        self
    }

    fn new(wishes: Wishes) -> Result<Self, String> {
        Ok(Self { version: Self::STATE_VERSION, wishes, done: 0, sum: 0, report: None })
    }

    fn stage(&self) -> usize {
        self.done
    }

    fn episodes(&self) -> u64 {
        (self.done * self.wishes.episodes) as u64
    }

    fn total_episodes(&self) -> u64 {
        (self.wishes.batches * self.wishes.episodes) as u64
    }

    fn report(&self) -> Option<&u64> {
        self.report.as_ref()
    }

    fn batch(&self) -> Vec<usize> {
        (0..self.wishes.episodes).collect()
    }

    fn evaluate(&self, episode: &usize) -> usize {
        assert!(!(self.wishes.panics && *episode == 0), "no floor under the robot");
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_micros(self.wishes.micros) {
            std::hint::spin_loop();
        }
        *episode
    }

    fn tell(&mut self, evaluations: &[usize]) -> Result<Told<Self>, String> {
        let weighed = evaluations.iter().zip(1..).map(|(&it, place): (_, usize)| it * place);
        self.sum += weighed.sum::<usize>() as u64;
        self.done += 1;
        self.report = (self.done == self.wishes.batches).then_some(self.sum);
        Ok(Told { parts: vec![(self.done - 1, self.sum)], latest: Some(self.sum) })
    }
}
