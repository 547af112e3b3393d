//! What is true of data from outside once it has been checked, as a type.

use crate::check::{Check, Validate};
use crate::problem::Problems;
use serde::Serialize;
use std::ops::Deref;

/// Outside data whose every value is in its range and agrees with the others. There is no other way to one than a check,
/// so what takes it neither checks again nor fails.
///
/// ```
/// use umwelt_api::{Checked, robot::Spec};
/// let spec = Checked::new(Spec { horizon_slots: 20, ..Spec::default() })?;
/// assert_eq!(spec.horizon_slots, 20);
/// assert!(Checked::new(Spec { horizon_slots: 68, ..Spec::default() }).is_err());
/// # Ok::<(), umwelt_api::Problems>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Checked<T>(T);

impl<T: Validate> Checked<T> {
    /// `value`, if nothing is wrong with it.
    ///
    /// # Errors
    /// Every field that is out of its range or contradicts another.
    pub fn new(value: T) -> Result<Self, Problems> {
        value.validate()?;
        Ok(Self(value))
    }

    /// `value`, which `check` has walked over.
    pub(crate) fn after(check: Check, value: T) -> Result<Self, Problems> {
        check.finish()?;
        Ok(Self(value))
    }
}

impl<T> Checked<T> {
    /// The value itself.
    pub fn into_inner(self) -> T {
        self.0
    }
}

impl<T> Deref for Checked<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}
