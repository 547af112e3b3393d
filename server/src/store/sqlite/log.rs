//! SQLite's write-ahead log, looked through before SQLite opens it. SQLite takes the first frame that is not as it was
//! written for the end of the log, as a power cut leaves it, and drops without a word whatever comes after it. But nothing
//! is begun before what came before it is on the disk: a frame that is wrong and lies before the last transaction is
//! damage, and what would be dropped was acknowledged.
//!
//! The format is described in SQLite's "WAL-mode File Format": a header of 32 bytes, then frames of a header of 24 bytes
//! and a page. Each has the checksum of all that is before it, and the salt of this run through the log.

use std::fs;
use std::io;
use std::path::Path;

const HEADER: usize = 32;
const FRAME_HEADER: usize = 24;

/// What a log begins with; the lowest bit says that checksums are of big-endian words.
const MAGIC: u32 = 0x377f_0682;

/// SQLite's pages have at most so many bytes.
const LARGEST_PAGE: usize = 65_536;

/// What is wrong with the log of a data file; none where it holds together as far as can be told.
pub(super) fn damage(log: &Path) -> io::Result<Option<String>> {
    match fs::read(log) {
        Ok(bytes) => Ok(broken(&bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

fn broken(log: &[u8]) -> Option<String> {
    let (header, frames) = log.split_at_checked(HEADER)?;
    if frames.is_empty() {
        return None;
    }
    let Some((mut sum, page_size)) = begun(header) else {
        return Some("its header is not what was written".to_owned());
    };
    let salt = &header[16..24];
    // What is left of an earlier run has another salt, and what was cut off is no frame.
    let frames: Vec<&[u8]> = frames.chunks_exact(FRAME_HEADER + page_size).collect();
    let is_of_this_run = |frame: &&[u8]| frame[8..16] == *salt;
    let is_whole = |frame: &&&[u8]| {
        sum.take_in(&frame[..8]);
        sum.take_in(&frame[FRAME_HEADER..]);
        is_of_this_run(frame) && sum.is(&frame[16..24])
    };
    let whole = frames.iter().take_while(is_whole).count();
    // The transaction that the wrong frame is in may be the last, which may have been under way. Its end is the first
    // frame from there on that says how large the file is after it.
    let rest = frames.get(whole..)?;
    let ends = rest.iter().position(|frame| is_of_this_run(frame) && word(frame, 4) != 0)?;
    let goes_on = rest[ends + 1..].iter().any(is_of_this_run);
    goes_on.then(|| {
        format!("of {} pages in it the {}. is not what was written", frames.len(), whole + 1)
    })
}

/// The checksum after a header, and the size of a page; none where the header is not what was written.
fn begun(header: &[u8]) -> Option<(Sum, usize)> {
    let (magic, page_size) = (word(header, 0), word(header, 8) as usize);
    let is_log = magic & !1 == MAGIC && page_size.is_power_of_two() && page_size <= LARGEST_PAGE;
    let mut sum = Sum { is_big_endian: magic & 1 == 1, first: 0, second: 0 };
    sum.take_in(&header[..24]);
    (is_log && sum.is(&header[24..32])).then_some((sum, page_size))
}

/// The big-endian word at `at`.
fn word(bytes: &[u8], at: usize) -> u32 {
    bytes[at..].first_chunk().map_or(0, |word| u32::from_be_bytes(*word))
}

/// The running checksum of a log.
struct Sum {
    is_big_endian: bool,
    first: u32,
    second: u32,
}

impl Sum {
    fn take_in(&mut self, bytes: &[u8]) {
        for pair in bytes.chunks_exact(8) {
            let [one, other] = [word(pair, 0), word(pair, 4)]
                .map(|word| if self.is_big_endian { word } else { word.swap_bytes() });
            self.first = self.first.wrapping_add(one).wrapping_add(self.second);
            self.second = self.second.wrapping_add(other).wrapping_add(self.first);
        }
    }

    fn is(&self, bytes: &[u8]) -> bool {
        (self.first, self.second) == (word(bytes, 0), word(bytes, 4))
    }
}
