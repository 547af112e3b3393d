//! Versions of resources: the hash of what was said about them.
//!
//! The same content has the same version, before and after a restart, and nothing needs to be stored for it.

use serde::Serialize;
use std::sync::Arc;
use umwelt_api::robot::MAX_INTEGER;

/// The version of `content`: 16 hexadecimal digits.
pub(crate) fn of(content: &impl Serialize) -> Arc<str> {
    // Checked specs are finite, so they can be serialised; one that could not would match no version.
    of_bytes(&serde_json::to_vec(content).unwrap_or_default())
}

/// The version of something that is sent as these bytes.
pub(crate) fn of_bytes(bytes: &[u8]) -> Arc<str> {
    format!("{:016x}", fnv_1a(bytes)).into()
}

/// The same of something small, as a whole number above 0 that every JSON reader keeps.
pub(crate) fn tag(content: &impl Serialize) -> u64 {
    (fnv_1a(&serde_json::to_vec(content).unwrap_or_default()) & MAX_INTEGER).max(1)
}

/// FNV-1a, 64 bits: stable across releases, unlike the standard library's hashes.
pub(crate) fn fnv_1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published test vectors (Fowler, Noll, Vo): a version must not change with the program.
    #[test]
    fn fnv_1a_gives_the_published_values() {
        assert_eq!(fnv_1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv_1a(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv_1a(b"foobar"), 0x8594_4171_f739_67e8);
    }
}
