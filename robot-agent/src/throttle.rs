//! Says the same thing not more than once in a while.

/// Time in s between two lines about the same thing.
const QUIET: f64 = 2.0;

/// Whether to say something again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Throttle {
    /// Time in s between two lines.
    quiet: f64,
    said: Option<f64>,
    unsaid: u64,
}

impl Default for Throttle {
    fn default() -> Self {
        Self::every(QUIET)
    }
}

impl Throttle {
    /// At most one line in `quiet` s.
    pub(crate) fn every(quiet: f64) -> Self {
        Self { quiet, said: None, unsaid: 0 }
    }

    /// Asks to speak at robot time `now`: how often it stayed unsaid since the last time, or none to stay quiet.
    pub(crate) fn ask(&mut self, now: f64) -> Option<u64> {
        if self.said.is_some_and(|said| now < said + self.quiet) {
            self.unsaid += 1;
            return None;
        }
        self.said = Some(now);
        Some(std::mem::take(&mut self.unsaid))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_is_said_and_the_rest_is_counted() {
        let mut throttle = Throttle::default();
        assert_eq!(throttle.ask(5.0), Some(0));
        assert_eq!([5.1, 5.2, 6.9].map(|now| throttle.ask(now)), [None; 3]);
        assert_eq!(throttle.ask(7.0), Some(3));
    }
}
