//! Whether the intervals of a belief hold what comes.

use serde::{Deserialize, Serialize};
use umwelt_core::identification::estimate::Channel;
use umwelt_core::identification::{Belief, SampleObserver, Samples};
use umwelt_core::time::RobotTime;

/// Samples of a channel that are taken in before intervals are asked of it: before, nothing has been identified.
pub const SAMPLES_BEFORE: u64 = 10;

/// How many samples lay within the 90 % interval that was predicted for each before it came.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Coverage {
    /// Samples within.
    pub within: u32,
    /// Samples in all.
    pub samples: u32,
}

impl Coverage {
    /// Both together.
    pub fn and(self, other: Self) -> Self {
        Self { within: self.within + other.within, samples: self.samples + other.samples }
    }

    /// Share of the samples within; none without samples.
    pub fn share(self) -> Option<f64> {
        (self.samples > 0).then(|| f64::from(self.within) / f64::from(self.samples))
    }
}

/// Counts how well a belief knows what comes, while a controller learns it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct CoverageRecorder {
    coverage: Coverage,
}

impl CoverageRecorder {
    pub(super) fn coverage(&self) -> Coverage {
        self.coverage
    }
}

impl SampleObserver for CoverageRecorder {
    fn on_samples(&mut self, belief: &Belief, samples: &Samples, start: RobotTime) {
        let model = belief.model();
        let models = [model.forward, model.lateral, model.turn];
        for ((channel, model), sample) in Channel::ALL.iter().zip(models).zip(samples) {
            let known = belief.channel(*channel);
            if let Some(sample) = sample
                && known.samples() >= SAMPLES_BEFORE
            {
                self.coverage.samples += 1;
                self.coverage.within += u32::from(known.expects(&model, sample, start));
            }
        }
    }
}
