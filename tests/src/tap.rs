//! What an agent said last, as it crossed the link: requests that can be said again.

use serde::de::IgnoredAny;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// How the body of a step begins, as our agent writes it.
const BEGIN: &[u8] = b"{\"sequence\":";

/// Most bodies that are kept, the newest: two seconds of them.
const KEPT: usize = 64;

/// The bodies of an agent's last steps. Both versions of HTTP carry them as they are, as a rule in one piece; what is
/// cut in two is not kept.
#[derive(Clone, Debug, Default)]
pub struct Tap(Arc<Mutex<VecDeque<Vec<u8>>>>);

impl Tap {
    /// Takes in what was sent.
    pub fn hear(&self, mut bytes: &[u8]) {
        while let Some(at) = bytes.windows(BEGIN.len()).position(|window| window == BEGIN) {
            bytes = &bytes[at..];
            let mut bodies = serde_json::Deserializer::from_slice(bytes).into_iter::<IgnoredAny>();
            let length = match bodies.next() {
                Some(Ok(_)) => bodies.byte_offset(),
                _ => BEGIN.len(),
            };
            if length > BEGIN.len() {
                self.keep(bytes[..length].to_vec());
            }
            bytes = &bytes[length..];
        }
    }

    fn keep(&self, body: Vec<u8>) {
        let mut kept = self.lock();
        if kept.len() == KEPT {
            kept.pop_front();
        }
        kept.push_back(body);
    }

    /// What is kept, oldest first.
    pub fn bodies(&self) -> Vec<Vec<u8>> {
        self.lock().iter().cloned().collect()
    }

    /// Forgets all: another agent speaks from here on.
    pub fn clear(&self) {
        self.lock().clear();
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Vec<u8>>> {
        // A body is kept or not: what is behind a poisoned lock is whole.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_bodies_are_found_among_other_bytes_and_the_newest_are_kept() {
        let tap = Tap::default();
        tap.hear(b"\0\x01{\"sequence\":1,\"observations\":[{\"x_m\":1}]}\0\0{\"sequence\":2}{\"sequence\":3,");
        let found = tap.bodies();
        assert_eq!(
            found,
            [&b"{\"sequence\":1,\"observations\":[{\"x_m\":1}]}"[..], b"{\"sequence\":2}"]
        );
        for sequence in 3..100 {
            tap.hear(format!("{{\"sequence\":{sequence}}}").as_bytes());
        }
        assert_eq!(tap.bodies().len(), KEPT);
        assert_eq!(tap.bodies().pop().unwrap(), b"{\"sequence\":99}");
        tap.clear();
        assert!(tap.bodies().is_empty());
    }
}
