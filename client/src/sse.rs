//! The event stream format of the HTML standard, parsed: pure, chunk by chunk.

/// Longest event: the largest environment or horizon has some kilobytes.
const MAX_EVENT: usize = 1 << 20;

/// One event as it came: its data, and the id to resume behind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Message {
    /// The last id that the stream has named up to here.
    pub(crate) id: Option<String>,
    /// The `data:` lines, joined by line feeds.
    pub(crate) data: String,
}

/// An event longer than [`MAX_EVENT`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an event is longer than {} KiB", MAX_EVENT >> 10)]
pub(crate) struct TooLong;

/// The state between two chunks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parser {
    line: Vec<u8>,
    data: Option<String>,
    id: Option<String>,
    begun: bool,
    /// The last byte was a carriage return: a line feed that follows belongs to it.
    after_return: bool,
}

impl Parser {
    /// Takes in the next bytes; adds each event that they complete to `messages`.
    ///
    /// # Errors
    /// Where an event is too long; the stream cannot be followed any further.
    pub(crate) fn push(
        &mut self,
        chunk: &[u8],
        messages: &mut Vec<Message>,
    ) -> Result<(), TooLong> {
        for &byte in chunk {
            let after_return = std::mem::replace(&mut self.after_return, byte == b'\r');
            match byte {
                b'\n' if after_return => {}
                b'\n' | b'\r' => messages.extend(self.end_line()),
                _ if self.length() >= MAX_EVENT => return Err(TooLong),
                _ => self.line.push(byte),
            }
        }
        Ok(())
    }

    fn length(&self) -> usize {
        self.line.len() + self.data.as_ref().map_or(0, String::len)
    }

    fn end_line(&mut self) -> Option<Message> {
        let bytes = std::mem::take(&mut self.line);
        let text = String::from_utf8_lossy(&bytes);
        let mut line: &str = &text;
        if !std::mem::replace(&mut self.begun, true) {
            line = line.strip_prefix('\u{feff}').unwrap_or(line);
        }
        if line.is_empty() {
            let data = self.data.take()?;
            return Some(Message { id: self.id.clone(), data });
        }
        // A comment, which keeps the connection alive, is a field without a name.
        let (field, value) = line.split_once(':').unwrap_or((line, ""));
        let value = value.strip_prefix(' ').unwrap_or(value);
        match field {
            "data" => match &mut self.data {
                Some(data) => {
                    data.push('\n');
                    data.push_str(value);
                }
                None => self.data = Some(value.to_owned()),
            },
            "id" if !value.contains('\0') => self.id = Some(value.to_owned()),
            // `event` is said in the data too; `retry` is ours to decide: the backoff is bounded either way.
            _ => {}
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::collection::vec;
    use proptest::prelude::*;

    fn parsed<'a>(chunks: impl IntoIterator<Item = &'a [u8]>) -> Vec<Message> {
        let (mut parser, mut messages) = (Parser::default(), Vec::new());
        for chunk in chunks {
            parser.push(chunk, &mut messages).unwrap();
        }
        messages
    }

    fn message(id: Option<&str>, data: &str) -> Message {
        Message { id: id.map(str::to_owned), data: data.to_owned() }
    }

    #[test]
    fn the_examples_of_the_standard() {
        let stocks = "data: YHOO\ndata: +2\ndata: 10\n\n";
        assert_eq!(parsed([stocks.as_bytes()]), [message(None, "YHOO\n+2\n10")]);

        let ids = ": test stream\n\ndata: first event\nid: 1\n\ndata:second event\nid\n\ndata:  third event\n\n";
        let expected = [
            message(Some("1"), "first event"),
            message(Some(""), "second event"),
            message(Some(""), " third event"),
        ];
        assert_eq!(parsed([ids.as_bytes()]), expected);

        let empty = "data\n\ndata\ndata\n\ndata:";
        assert_eq!(parsed([empty.as_bytes()]), [message(None, ""), message(None, "\n")]);
    }

    #[test]
    fn every_line_end_ends_a_line_once() {
        for end in ["\n", "\r", "\r\n"] {
            let text = "\u{feff}id: 7|event: pose|data: a||:||data: b||".replace('|', end);
            let expected = [message(Some("7"), "a"), message(Some("7"), "b")];
            assert_eq!(parsed([text.as_bytes()]), expected, "{end:?}");
        }
    }

    #[test]
    fn what_is_cut_off_is_no_event() {
        assert_eq!(parsed(["id: 1\ndata: a\n".as_bytes()]), []);
    }

    #[test]
    fn an_endless_event_is_refused() {
        let (mut parser, mut messages) = (Parser::default(), Vec::new());
        let line = [b"data: ".as_slice(), &[b'x'; 1000], b"\n"].concat();
        let refused = (0..2000).find_map(|_| parser.push(&line, &mut messages).err());
        assert_eq!((refused, messages), (Some(TooLong), Vec::new()));
    }

    /// The same, naively: the whole text at once, by the letter of the standard.
    fn parsed_naively(text: &str) -> Vec<Message> {
        let text = text.replace("\r\n", "\n").replace('\r', "\n");
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let (mut id, mut data, mut messages) = (None, Vec::<&str>::new(), Vec::new());
        let mut lines: Vec<_> = text.split('\n').collect();
        lines.pop();
        for line in lines {
            if line.is_empty() {
                if !data.is_empty() {
                    messages.push(Message { id: id.clone(), data: data.join("\n") });
                }
                data.clear();
                continue;
            }
            let (field, value) = line.split_once(':').unwrap_or((line, ""));
            let value = value.strip_prefix(' ').unwrap_or(value);
            match field {
                "data" => data.push(value),
                "id" if !value.contains('\0') => id = Some(value.to_owned()),
                _ => {}
            }
        }
        messages
    }

    fn stream() -> impl Strategy<Value = String> {
        let piece = prop_oneof![
            Just("\n".to_owned()),
            Just("\r".to_owned()),
            Just("\r\n".to_owned()),
            Just("data:".to_owned()),
            Just("data: ä€\u{1f916}".to_owned()),
            Just("id: 4".to_owned()),
            Just("id:\0".to_owned()),
            Just(": alive".to_owned()),
            Just("\u{feff}".to_owned()),
            "[a-z: ]{0,5}",
        ];
        vec(piece, 0..40).prop_map(|pieces| pieces.concat())
    }

    proptest! {
        #[test]
        fn any_chunking_gives_the_same_events(text in stream(), cuts in vec(0usize..400, 0..20)) {
            let bytes = text.as_bytes();
            let mut cuts: Vec<_> = cuts.into_iter().map(|cut| cut.min(bytes.len())).collect();
            cuts.extend([0, bytes.len()]);
            cuts.sort_unstable();
            let chunks = cuts.windows(2).map(|pair| &bytes[pair[0]..pair[1]]);
            prop_assert_eq!(parsed(chunks), parsed_naively(&text));
            prop_assert_eq!(parsed(bytes.chunks(1)), parsed_naively(&text));
        }

        #[test]
        fn no_bytes_break_it(bytes in vec(any::<u8>(), 0..500)) {
            parsed([bytes.as_slice()]);
        }
    }
}
