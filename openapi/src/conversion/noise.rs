//! What is identified of the noise of poses.

use super::environment::interval;
use super::known;
use crate::environment::{Estimate, Noise, Status};
use umwelt_core::fusion::Identified;
use umwelt_core::settings::Settings;

impl Noise {
    /// What is believed of the noise under these settings; where it is described, what they say. None where the method does
    /// not ask for it.
    pub fn new(believed: Option<[Identified; 2]>, settings: &Settings) -> Option<Self> {
        let [position, heading] = believed?;
        if settings.identifies_noise {
            return Some(Self {
                status: position.status().into(),
                position_m: position.into(),
                heading_rad: heading.into(),
                poses: known(position.poses),
            });
        }
        let given = |sd| Estimate { mean: known(sd), sd: None, interval: None };
        Some(Self {
            status: Status::Given,
            position_m: given(settings.noise.position),
            heading_rad: given(settings.noise.heading),
            poses: None,
        })
    }
}

impl From<Identified> for Estimate {
    fn from(core: Identified) -> Self {
        // The logarithm of a variance of n poses is known to the square root of 2/n, that of its root to half of that.
        let sd = core.sd / (2.0 * core.poses).sqrt();
        Self { mean: known(core.sd), sd: known(sd), interval: interval(core.interval) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_core::fusion::NoiseBelief;
    use umwelt_core::settings::PoseNoise;

    #[test]
    fn noise_is_told_whoever_knows_it() {
        let believed = Some(NoiseBelief::default().identified());
        let noise = PoseNoise { position: 0.01, heading: 0.02 };
        let described = Settings { noise, ..Settings::default() };
        assert_eq!(Noise::new(None, &described), None);
        let told = Noise::new(believed, &described).unwrap();
        assert_eq!((told.status, told.heading_rad.mean), (Status::Given, Some(0.02)));
        assert_eq!((told.position_m.interval, told.poses), (None, None));
        let asked = Settings { identifies_noise: true, ..described };
        let told = Noise::new(believed, &asked).unwrap();
        assert_eq!(told.status, Status::Estimating);
        let interval = told.position_m.interval.unwrap();
        assert!(interval.low < 4e-4 && interval.high > 5e-3, "{interval:?}");
    }
}
