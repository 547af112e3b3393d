//! Finds the frames of HTTP/2 in bytes that arrive in any pieces.

/// What a connection of HTTP/2 begins with (RFC 9113, 3.4).
const PREFACE: &[u8; 24] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

/// Bytes of a frame's header (RFC 9113, 4.1): length, kind, flags, stream.
const HEADER: usize = 9;

const DATA: u8 = 0;
const HEADERS: u8 = 1;
const END_STREAM: u8 = 0x1;
const PADDED: u8 = 0x8;

/// A piece of a body that is smaller than this, and not its last, costs more than it brings.
const SMALL: usize = 64;

/// What was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Seen {
    /// Frames that have begun.
    pub(super) frames: u32,
    /// Those of them that bring no request and no content.
    pub(super) control: u32,
}

/// Where in the bytes of a connection the meter is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Meter {
    /// So many bytes into the preface.
    Preface(usize),
    /// So many bytes into the header of a frame.
    Header([u8; HEADER], usize),
    /// So many bytes before the next header.
    Content(usize),
    /// It is not HTTP/2.
    Other,
}

impl Default for Meter {
    fn default() -> Self {
        Self::Preface(0)
    }
}

impl Meter {
    /// Takes in the next bytes of the connection.
    pub(super) fn read(&mut self, mut bytes: &[u8]) -> Seen {
        let mut seen = Seen::default();
        while !bytes.is_empty() {
            bytes = match self {
                Self::Other => return seen,
                Self::Preface(_) => self.preface(bytes),
                Self::Header(..) => self.header(bytes, &mut seen),
                Self::Content(_) => self.content(bytes),
            };
        }
        seen
    }

    fn preface<'a>(&mut self, bytes: &'a [u8]) -> &'a [u8] {
        let Self::Preface(at) = *self else { return bytes };
        let count = bytes.len().min(PREFACE.len() - at);
        let (now, rest) = bytes.split_at(count);
        *self = if *now != PREFACE[at..at + count] {
            Self::Other
        } else if at + count == PREFACE.len() {
            Self::Header([0; HEADER], 0)
        } else {
            Self::Preface(at + count)
        };
        rest
    }

    fn header<'a>(&mut self, bytes: &'a [u8], seen: &mut Seen) -> &'a [u8] {
        let Self::Header(header, at) = self else { return bytes };
        let count = bytes.len().min(HEADER - *at);
        let (now, rest) = bytes.split_at(count);
        header[*at..*at + count].copy_from_slice(now);
        *at += count;
        if *at == HEADER {
            let [high, middle, low, kind, flags, ..] = *header;
            let length = usize::from(high) << 16 | usize::from(middle) << 8 | usize::from(low);
            seen.frames += 1;
            seen.control += u32::from(is_control(kind, flags, length));
            *self = if length == 0 { Self::Header([0; HEADER], 0) } else { Self::Content(length) };
        }
        rest
    }

    fn content<'a>(&mut self, bytes: &'a [u8]) -> &'a [u8] {
        let Self::Content(left) = self else { return bytes };
        let count = bytes.len().min(*left);
        *left -= count;
        if *left == 0 {
            *self = Self::Header([0; HEADER], 0);
        }
        &bytes[count..]
    }
}

/// Whether a frame brings neither a request nor content worth it: SETTINGS, PING, RST_STREAM, PRIORITY, WINDOW_UPDATE,
/// CONTINUATION, GOAWAY, those of no known kind, and DATA that is all but empty.
fn is_control(kind: u8, flags: u8, length: usize) -> bool {
    match kind {
        HEADERS => false,
        DATA => flags & END_STREAM == 0 && (length < SMALL || flags & PADDED != 0),
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frame(kind: u8, flags: u8, content: &[u8]) -> Vec<u8> {
        let length = content.len() as u32;
        [&length.to_be_bytes()[1..], &[kind, flags], &[0, 0, 0, 1], content].concat()
    }

    fn seen(connection: &[u8]) -> Seen {
        Meter::default().read(&[PREFACE, connection].concat())
    }

    #[test]
    fn a_request_is_no_control_and_all_else_is() {
        let step = [frame(1, 4, &[0; 80]), frame(0, 1, &[0; 2000])].concat();
        assert_eq!(seen(&step), Seen { frames: 2, control: 0 });
        // An end of its own, as some clients send it.
        let step = [frame(1, 4, &[0; 80]), frame(0, 0, &[0; 2000]), frame(0, 1, &[])].concat();
        assert_eq!(seen(&step), Seen { frames: 3, control: 0 });
        for (kind, flags, length) in [
            (0, 0, 0),
            (0, 0, 1),
            (0, PADDED, 200),
            (2, 0, 5),
            (3, 0, 4),
            (4, 0, 6),
            (4, 1, 0),
            (6, 0, 8),
            (7, 0, 8),
            (8, 0, 4),
            (9, 4, 100),
            (0x10, 0, 8),
            (0xff, 0xff, 0),
        ] {
            let frames = frame(kind, flags, &vec![0; length]).repeat(3);
            assert_eq!(seen(&frames), Seen { frames: 3, control: 3 }, "{kind} {flags} {length}");
        }
    }

    #[test]
    fn what_does_not_begin_as_http_2_is_not_counted() {
        for other in [&b"GET / HTTP/1.1\r\n\r\n"[..], b"PRI * HTTP/2.0\r\n\r\nSN\r\n\r\n"] {
            let mut meter = Meter::default();
            let bytes = [other, &frame(4, 0, &[]).repeat(100)].concat();
            assert_eq!(meter.read(&bytes), Seen::default());
            assert_eq!(meter, Meter::Other);
        }
    }

    proptest! {
        /// However the bytes of a connection are cut: the same frames are seen, and as many as were sent.
        #[test]
        fn the_pieces_in_which_bytes_arrive_never_show(
            frames in prop::collection::vec((any::<u8>(), any::<u8>(), 0_usize..300), 0..40),
            cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..60),
        ) {
            let sent = frames.iter().map(|(kind, flags, length)| frame(*kind, *flags, &vec![7; *length]));
            let connection = [PREFACE.to_vec(), sent.collect::<Vec<_>>().concat()].concat();
            let mut cuts: Vec<_> = cuts.iter().map(|cut| cut.index(connection.len() + 1)).collect();
            cuts.extend([0, connection.len()]);
            cuts.sort_unstable();
            let (mut meter, mut in_pieces) = (Meter::default(), Seen::default());
            for cut in cuts.windows(2) {
                let Seen { frames, control } = meter.read(&connection[cut[0]..cut[1]]);
                in_pieces.frames += frames;
                in_pieces.control += control;
            }
            let control = frames.iter().filter(|(kind, flags, length)| is_control(*kind, *flags, *length));
            let expected = Seen { frames: frames.len() as u32, control: control.count() as u32 };
            prop_assert_eq!(in_pieces, expected);
            prop_assert_eq!(Meter::default().read(&connection), expected);
        }

        /// Whatever arrives, nothing panics, and nothing is seen that is shorter than a header.
        #[test]
        fn any_bytes_are_taken(bytes in prop::collection::vec(any::<u8>(), 0..500)) {
            let seen = seen(&bytes);
            prop_assert!(seen.frames as usize <= bytes.len() / HEADER);
            prop_assert!(seen.control <= seen.frames);
        }
    }
}
