//! What comes with every server.

use crate::named::Known;
use umwelt_core::identification::BUILT_IN_PRIORS;
use umwelt_core::settings;

/// The priors that come with every server, by their names: what a name stands for without one.
///
/// # Errors
/// All the names, where nothing goes by this one.
pub fn prior(name: &str) -> Known<settings::Prior> {
    settings::Prior::built_in(name)
        .ok_or_else(|| BUILT_IN_PRIORS.into_iter().map(str::to_owned).collect())
}
