//! The random number by which the server tells one run of an agent from another.

use umwelt_client::api::robot::MAX_INTEGER;

/// That of a new run.
pub(crate) fn random() -> u64 {
    rand::random::<u64>() & MAX_INTEGER
}

/// Another one, as random as the one before: the generator of Knuth's MMIX, its upper 53 bits.
pub(crate) fn after(epoch: u64) -> u64 {
    let next =
        epoch.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (next >> 11) & MAX_INTEGER
}
