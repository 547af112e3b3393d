//! Memory that a burst took goes back to the system.

use std::time::Duration;
use tokio::task::spawn_blocking;
use tokio::time::sleep;

/// How often it is looked how large the process is.
const EVERY: Duration = Duration::from_secs(5);

/// Most looks between two attempts that come to nothing, ten minutes: each holds up others that allocate for some milliseconds.
const MOST_LOOKS: u32 = 120;

/// Growth in bytes that is worth an attempt.
const MUCH: u64 = 16 * 1024 * 1024;

/// Gives back what is free as long as the process is larger than it once was, for ever; where the system does not say how
/// large it is, never.
pub(crate) async fn give_back_what_is_free() {
    let Some(mut turns) = resident().map(Turns::beginning) else { return };
    loop {
        sleep(EVERY).await;
        let Some(now) = resident() else { return };
        if turns.is_due(now) {
            // It is gone on with where the server ends meanwhile, and no one waits for it.
            let _ = spawn_blocking(umwelt_memory::give_back).await;
            turns.done(now, resident().unwrap_or(now));
        }
    }
}

/// When it is worth an attempt.
#[derive(Clone, Copy, Debug)]
struct Turns {
    /// The smallest that the process was.
    least: u64,
    /// What it was after the last attempt, or at the last look where it was smaller then.
    last: u64,
    /// Looks between two attempts, and those that are still to come.
    pause: u32,
    left: u32,
}

impl Turns {
    fn beginning(resident: u64) -> Self {
        Self { least: resident, last: resident, pause: 1, left: 0 }
    }

    /// Whether it is, where the process is so large now.
    fn is_due(&mut self, now: u64) -> bool {
        self.least = self.least.min(now);
        if now > self.last + MUCH {
            (self.pause, self.left) = (1, 0);
        }
        self.last = self.last.min(now);
        if now <= self.least + MUCH {
            return false;
        }
        self.left = self.left.saturating_sub(1);
        self.left == 0
    }

    /// An attempt took the process from `before` to `after`.
    fn done(&mut self, before: u64, after: u64) {
        let is_worth = before > after + MUCH / 4;
        self.pause = if is_worth { 1 } else { (2 * self.pause).min(MOST_LOOKS) };
        (self.last, self.left) = (after, self.pause);
    }
}

/// How much memory the process has, in bytes.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MB: u64 = 1024 * 1024;

    /// At which looks an attempt is made, where the process is so large at each and an attempt leaves it `after`.
    fn attempts(sizes: &[u64], after: impl Fn(u64) -> u64) -> Vec<usize> {
        let mut turns = Turns::beginning(20 * MB);
        let mut attempts = Vec::new();
        for (look, &size) in sizes.iter().enumerate() {
            if turns.is_due(size * MB) {
                turns.done(size * MB, after(size) * MB);
                attempts.push(look);
            }
        }
        attempts
    }

    #[test]
    fn a_burst_is_given_back_once_and_memory_in_use_is_let_be() {
        assert_eq!(attempts(&[20, 25, 30, 20], |size| size), [0; 0]);
        assert_eq!(attempts(&[20, 90, 22, 22, 22, 22], |_| 22), [1]);
        // Still in use at first: tried again, more and more rarely.
        let used = attempts(&[90; 400], |size| size);
        assert_eq!(used[..5], [0, 2, 6, 14, 30]);
        assert!(used.len() <= 9, "{used:?}");
        // Another burst after a long time is tried at once.
        let mut sizes = vec![90; 200];
        sizes.push(150);
        assert_eq!(attempts(&sizes, |size| size).last(), Some(&200));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_system_says_how_large_the_process_is() {
        let before = resident().unwrap();
        let much = vec![1_u8; 64 * 1024 * 1024];
        assert!(resident().unwrap() >= before + 32 * MB, "{}", much.len());
    }
}
