//! Beliefs before any sample.

use crate::checked::Checked;
use crate::prior::Spec;
use crate::robot::{ChannelPrior, Prior};
use umwelt_core::conjugate::{ConjugateError, NormalInverseChiSquared};
use umwelt_core::settings;

impl From<NormalInverseChiSquared> for ChannelPrior {
    fn from(core: NormalInverseChiSquared) -> Self {
        Self { mu: core.mu(), k: core.k(), r: core.r(), s: core.s() }
    }
}

impl ChannelPrior {
    fn convert(self) -> Result<NormalInverseChiSquared, ConjugateError> {
        NormalInverseChiSquared::new(self.mu, self.k, self.r, self.s)
    }
}

impl From<settings::Prior> for Prior {
    fn from(core: settings::Prior) -> Self {
        Self {
            forward: core.forward.into(),
            lateral: core.lateral.into(),
            turn: core.turn.into(),
            drift: core.drift.into(),
        }
    }
}

impl Prior {
    /// The prior in core's terms, whatever its ranges: what a program keeps was checked when it came.
    ///
    /// # Errors
    /// Where a channel is no distribution at all.
    pub fn convert(self) -> Result<settings::Prior, ConjugateError> {
        Ok(settings::Prior {
            forward: self.forward.convert()?,
            lateral: self.lateral.convert()?,
            turn: self.turn.convert()?,
            drift: self.drift.convert()?,
        })
    }
}

impl Checked<Spec> {
    /// The prior in core's terms; the note stays behind.
    pub fn to_core(&self) -> settings::Prior {
        self.values().convert().expect("numbers in their ranges are a distribution")
    }
}
