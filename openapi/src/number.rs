//! Numbers that exist: NaN and infinities never leave silently.

use serde::Serializer;

/// Serialises a finite number and refuses any other; serde_json alone would write `null`.
pub(crate) fn finite<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() {
        serializer.serialize_f64(*value)
    } else {
        Err(serde::ser::Error::custom(format_args!("{value} cannot be said in JSON")))
    }
}
