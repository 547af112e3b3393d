//! The journal of stops: a small file beside the store that takes a stop or a resume at once, whatever holds the store.
//!
//! It is appended to and synced; what it says and the store does not is brought into the store, and then it is emptied.
//! One line per word, `ARRIVAL WORD ROBOT SUM`, such as `17 stop rover-7 3f2a...`, the last part a checksum of the rest.
//! Of the words about one robot the one with the highest arrival counts, wherever it stands in the file.

use crate::resource::etag::fnv_1a;
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use umwelt_api::RobotId;

/// The journal's file in the data directory.
pub const STOPS_FILE: &str = "umwelt.stops";

/// What a robot was told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Word {
    /// Rest until resumed.
    Stop,
    /// Go on.
    Resume,
}

/// One line of the journal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    /// The place of the request in the order of arrivals.
    pub(crate) arrival: u64,
    pub(crate) robot: RobotId,
    pub(crate) word: Word,
}

/// What a journal says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Words {
    /// The last word about each robot.
    pub(crate) last: BTreeMap<RobotId, (u64, Word)>,
    /// Whether something that was written down whole cannot be read any more: of whom it spoke is not known.
    pub(crate) is_damaged: bool,
}

impl Words {
    /// The highest arrival that it speaks of; 0 where it says nothing.
    pub(crate) fn newest(&self) -> u64 {
        self.last.values().map(|(arrival, _)| *arrival).max().unwrap_or(0)
    }

    fn add(&mut self, Entry { arrival, robot, word }: Entry) {
        let last = self.last.entry(robot).or_insert((arrival, word));
        if arrival >= last.0 {
            *last = (arrival, word);
        }
    }

    /// What `text` says. A last line without its end was never acknowledged: the process died while it wrote.
    fn read(text: &[u8]) -> Self {
        let mut words = Self::default();
        for line in text.split_inclusive(|byte| *byte == b'\n') {
            match line.strip_suffix(b"\n").map(entry) {
                Some(Some(entry)) => words.add(entry),
                Some(None) => words.is_damaged = true,
                None => {}
            }
        }
        words
    }
}

impl Entry {
    fn line(&self) -> String {
        let word = match self.word {
            Word::Stop => "stop",
            Word::Resume => "resume",
        };
        let said = format!("{} {word} {}", self.arrival, self.robot);
        format!("{said} {:016x}\n", fnv_1a(said.as_bytes()))
    }
}

/// The entry in a line without its end.
fn entry(line: &[u8]) -> Option<Entry> {
    let (said, sum) = std::str::from_utf8(line).ok()?.rsplit_once(' ')?;
    if u64::from_str_radix(sum, 16).ok()? != fnv_1a(said.as_bytes()) {
        return None;
    }
    let mut parts = said.split(' ');
    let arrival = parts.next()?.parse().ok()?;
    let word = match parts.next()? {
        "stop" => Word::Stop,
        "resume" => Word::Resume,
        _ => return None,
    };
    Some(Entry { arrival, robot: parts.next()?.parse().ok()?, word })
}

/// The journal of a data directory, which no one else uses meanwhile.
#[derive(Debug)]
pub(crate) struct StopJournal {
    file: File,
    /// Up to where the file holds whole lines.
    length: u64,
    /// The highest arrival about each robot in it.
    last: BTreeMap<RobotId, u64>,
}

impl StopJournal {
    /// Opens the journal in `directory`, which is there. Returns it with what it says.
    ///
    /// # Errors
    /// Where the file cannot be made, read or written.
    pub(crate) fn open(directory: &Path) -> io::Result<(Self, Words)> {
        let path = directory.join(STOPS_FILE);
        let file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        // Its entry in the directory is on the disk with this.
        File::open(directory)?.sync_all()?;
        let mut text = vec![0; usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX)];
        file.read_exact_at(&mut text, 0)?;
        let words = Words::read(&text);
        let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let last = words.last.iter().map(|(id, (arrival, _))| (id.clone(), *arrival)).collect();
        Ok((Self { file, length: whole as u64, last }, words))
    }

    /// Writes `entries` down. They are on the disk once this returns `Ok`.
    ///
    /// # Errors
    /// Where that cannot be done; some of them may be written down all the same.
    pub(crate) fn append(&mut self, entries: &[Entry]) -> io::Result<()> {
        let lines: String = entries.iter().map(Entry::line).collect();
        // Behind what is whole: half a line of an earlier attempt goes.
        self.file.set_len(self.length)?;
        for entry in entries {
            let last = self.last.entry(entry.robot.clone()).or_default();
            *last = entry.arrival.max(*last);
        }
        self.file.write_all_at(lines.as_bytes(), self.length)?;
        self.file.sync_data()?;
        self.length += lines.len() as u64;
        Ok(())
    }

    /// Empties the journal where the store holds every word in it: `held` says up to which arrival it holds those about
    /// each robot. Returns whether it is empty now.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub(crate) fn clear(&mut self, held: &BTreeMap<RobotId, u64>) -> io::Result<bool> {
        let is_held = |(id, last): (&RobotId, &u64)| held.get(id).is_some_and(|held| held >= last);
        if !self.last.iter().all(is_held) {
            return Ok(false);
        }
        self.file.set_len(0)?;
        self.file.sync_data()?;
        (self.length, self.last) = (0, BTreeMap::new());
        Ok(true)
    }
}

/// The journal in `directory` with what it says. Where it cannot be written there is none, but what it says counts.
///
/// # Errors
/// Where what it says cannot be read: robots that were stopped would go on.
pub(crate) fn open(directory: &Path) -> io::Result<(Option<StopJournal>, Words)> {
    let path = directory.join(STOPS_FILE);
    let error = match StopJournal::open(directory) {
        Ok((journal, words)) => {
            if words.is_damaged {
                tracing::error!(
                    file = %path.display(),
                    "journal of stops damaged: all robots rest until they are resumed"
                );
            }
            return Ok((Some(journal), words));
        }
        Err(error) => error,
    };
    tracing::error!(file = %path.display(), %error, "cannot open journal of stops: the store alone keeps them");
    match std::fs::read(&path) {
        Ok(text) => Ok((None, Words::read(&text))),
        Err(missing) if missing.kind() == io::ErrorKind::NotFound => Ok((None, Words::default())),
        Err(unreadable) => {
            let message = format!(
                "cannot read the stops in {}: {unreadable}; make it readable",
                path.display()
            );
            Err(io::Error::new(unreadable.kind(), message))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::tempdir;

    fn entry_of(arrival: u64, robot: &str, word: Word) -> Entry {
        Entry { arrival, robot: robot.parse().unwrap(), word }
    }

    fn last(words: &Words) -> Vec<(&str, u64, Word)> {
        words.last.iter().map(|(id, (arrival, word))| (id.as_str(), *arrival, *word)).collect()
    }

    #[test]
    fn the_highest_arrival_counts_wherever_it_stands() {
        let directory = tempdir().unwrap();
        let (mut journal, words) = StopJournal::open(directory.path()).unwrap();
        assert_eq!(words, Words::default());
        let said = [(3, "a", Word::Stop), (2, "a", Word::Resume), (4, "b", Word::Resume)];
        journal.append(&said.map(|(arrival, robot, word)| entry_of(arrival, robot, word))).unwrap();
        journal.append(&[entry_of(9, "c", Word::Stop)]).unwrap();
        drop(journal);
        let (_, words) = StopJournal::open(directory.path()).unwrap();
        let expected = [("a", 3, Word::Stop), ("b", 4, Word::Resume), ("c", 9, Word::Stop)];
        assert_eq!((last(&words), words.newest()), (expected.to_vec(), 9));
        assert!(!words.is_damaged);
    }

    /// Guards against: a word that is thrown away before the store has it.
    #[test]
    fn it_is_emptied_only_where_the_store_holds_all_of_it() {
        let directory = tempdir().unwrap();
        let (mut journal, _) = StopJournal::open(directory.path()).unwrap();
        journal.append(&[entry_of(5, "a", Word::Stop), entry_of(6, "b", Word::Stop)]).unwrap();
        let held = |pairs: &[(&str, u64)]| {
            pairs.iter().map(|(id, held)| (id.parse().unwrap(), *held)).collect::<BTreeMap<_, _>>()
        };
        for too_little in [&[][..], &[("a", 5)], &[("a", 4), ("b", 6)]] {
            assert!(!journal.clear(&held(too_little)).unwrap());
        }
        assert_eq!(StopJournal::open(directory.path()).unwrap().1.last.len(), 2);
        assert!(journal.clear(&held(&[("a", 5), ("b", 7)])).unwrap());
        assert_eq!(StopJournal::open(directory.path()).unwrap().1, Words::default());
        journal.append(&[entry_of(8, "a", Word::Stop)]).unwrap();
        let (_, words) = StopJournal::open(directory.path()).unwrap();
        assert_eq!(last(&words), [("a", 8, Word::Stop)]);
    }

    /// A crash at every byte of a write: what was acknowledged before is read, half a line is not, and neither is taken
    /// for damage; the next write takes its place.
    #[test]
    fn a_crash_in_the_middle_of_a_line_costs_that_line_alone() {
        let directory = tempdir().unwrap();
        let file = directory.path().join(STOPS_FILE);
        let whole = entry_of(5, "a", Word::Stop).line();
        let half = entry_of(6, "a", Word::Resume).line();
        for end in 0..half.len() {
            std::fs::write(&file, format!("{whole}{}", &half[..end])).unwrap();
            let (mut journal, words) = StopJournal::open(directory.path()).unwrap();
            assert_eq!((last(&words), words.is_damaged), (vec![("a", 5, Word::Stop)], false));
            journal.append(&[entry_of(7, "b", Word::Stop)]).unwrap();
            let (_, words) = StopJournal::open(directory.path()).unwrap();
            assert_eq!(last(&words), [("a", 5, Word::Stop), ("b", 7, Word::Stop)]);
            assert!(!words.is_damaged);
        }
    }

    /// Guards against: a flipped bit that turns a stop into nothing, or into another robot's.
    #[test]
    fn every_changed_byte_is_noticed() {
        let lines = [entry_of(5, "a", Word::Stop), entry_of(6, "b", Word::Stop)];
        let text: Vec<u8> = lines.iter().map(Entry::line).collect::<String>().into_bytes();
        let first = lines[0].line().len();
        for at in 0..first {
            let mut changed = text.clone();
            changed[at] ^= 1;
            assert!(Words::read(&changed).is_damaged, "byte {at}");
        }
        assert!(!Words::read(&text).is_damaged);
    }
}
