//! Work without robots: what all kinds of jobs share is tested with it, here and in the server.

use crate::work::{BatchOutcome, Work};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// What a [`FakeWork`] is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FakeSettings {
    /// How many batches there are.
    pub batches: usize,
    /// Episodes of each batch.
    pub episodes: usize,
    /// Time in µs that an episode takes.
    pub micros: u64,
    /// Whether the first episode panics.
    pub panics: bool,
    /// Whether the last batch leaves a reason for a failure rather than a report.
    pub fails: bool,
}

impl Default for FakeSettings {
    fn default() -> Self {
        Self { batches: 1, episodes: 10, micros: 0, panics: false, fails: false }
    }
}

/// Counts: the place of an evaluation shows in the sum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FakeWork {
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

    fn failure(&self) -> Option<String> {
        let over = self.done == self.settings.batches;
        (over && self.settings.fails).then(|| "it counts no further".to_owned())
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
        let over = self.done == self.settings.batches;
        self.report = (over && !self.settings.fails).then_some(self.sum);
        Ok(BatchOutcome { parts: vec![(self.done - 1, self.sum)], latest: Some(self.sum) })
    }
}
