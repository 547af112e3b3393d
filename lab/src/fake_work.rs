//! Work without robots: the pool is tested with it.

use crate::work::{BatchOutcome, Work};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// What a [`FakeWork`] is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct FakeSettings {
    pub(super) batches: usize,
    /// Of each batch.
    pub(super) episodes: usize,
    /// Time in µs that an episode takes.
    pub(super) micros: u64,
    /// Whether the first episode panics.
    pub(super) panics: bool,
}

impl Default for FakeSettings {
    fn default() -> Self {
        Self { batches: 1, episodes: 10, micros: 0, panics: false }
    }
}

/// Counts: the place of an evaluation shows in the sum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct FakeWork {
    version: u32,
    settings: FakeSettings,
    done: usize,
    sum: u64,
    report: Option<u64>,
}

impl Work for FakeWork {
    const STATE_VERSION: u32 = 1;
    type Settings = FakeSettings;
    type State = Self;
    type Stage = usize;
    type Latest = u64;
    type Part = u64;
    type Report = u64;
    type Episode = usize;
    type Evaluation = usize;

    fn new(settings: FakeSettings) -> Result<Self, String> {
        Ok(Self { version: Self::STATE_VERSION, settings, done: 0, sum: 0, report: None })
    }

    fn resume(_: FakeSettings, state: Self) -> Result<Self, String> {
        Ok(state)
    }

    fn settings(&self) -> &FakeSettings {
        &self.settings
    }

    fn state(&self) -> &Self {
        self
    }

    fn stage(&self) -> usize {
        self.done
    }

    fn episodes(&self) -> u64 {
        (self.done * self.settings.episodes) as u64
    }

    fn total_episodes(&self) -> u64 {
        (self.settings.batches * self.settings.episodes) as u64
    }

    fn report(&self) -> Option<&u64> {
        self.report.as_ref()
    }

    fn batch(&self) -> Vec<usize> {
        (0..self.settings.episodes).collect()
    }

    fn evaluate(settings: &FakeSettings, episode: &usize) -> usize {
        assert!(!(settings.panics && *episode == 0), "no floor under the robot");
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_micros(settings.micros) {
            std::hint::spin_loop();
        }
        *episode
    }

    fn tell(&mut self, evaluations: &[usize]) -> Result<BatchOutcome<Self>, String> {
        let weighed = evaluations.iter().zip(1..).map(|(&it, place): (_, usize)| it * place);
        self.sum += weighed.sum::<usize>() as u64;
        self.done += 1;
        self.report = (self.done == self.settings.batches).then_some(self.sum);
        Ok(BatchOutcome { parts: vec![(self.done - 1, self.sum)], latest: Some(self.sum) })
    }
}
