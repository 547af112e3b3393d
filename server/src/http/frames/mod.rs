//! Frames of HTTP/2 as they arrive: counted, so that a flood of those without content ends its connection, and in
//! turns, so that no connection keeps the others waiting.
//!
//! hyper answers every SETTINGS and PING, and reads as long as there is something to read: some connections that send
//! nothing else take all the time there is. A [`Metered`] stream passes all bytes on as they are.

mod meter;

use meter::Meter;
use std::io;
use std::pin::{Pin, pin};
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::Instant;

/// Frames after which others have their turn: an agent has four requests in flight, of two frames each.
const FRAMES_A_TURN: u32 = 64;

/// Bytes after which others have their turn.
const BYTES_A_TURN: usize = 64 * 1024;

/// Seconds' worth of control frames that may come at once. A proxy that gives up all its requests at once sends 64.
const BURST: u32 = 10;

/// Bytes sent to a peer for which it may send one control frame more: some clients answer each event of a stream with
/// two WINDOW_UPDATE.
const BYTES_A_FRAME: usize = 128;

/// A stream whose peer may send only so many control frames per second.
#[derive(Debug)]
pub(crate) struct Metered<S> {
    stream: S,
    meter: Meter,
    allowance: Allowance,
    /// Frames and bytes since others had their turn.
    turn: (u32, usize),
}

impl<S> Metered<S> {
    pub(crate) fn new(stream: S, control_frames_per_s: u32) -> Self {
        let allowance = Allowance::new(control_frames_per_s, Instant::now());
        Self { stream, meter: Meter::default(), allowance, turn: (0, 0) }
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Metered<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let this = &mut *self;
        if this.turn.0 >= FRAMES_A_TURN || this.turn.1 >= BYTES_A_TURN {
            this.turn = (0, 0);
            // Behind all who want to run, and those for whom something has arrived meanwhile.
            return pin!(tokio::task::yield_now()).poll(context).map(Ok);
        }
        let before = buffer.filled().len();
        let read = Pin::new(&mut this.stream).poll_read(context, buffer);
        if read.is_pending() {
            this.turn = (0, 0);
        }
        ready!(read)?;
        let bytes = &buffer.filled()[before..];
        let seen = this.meter.read(bytes);
        this.turn = (this.turn.0 + seen.frames, this.turn.1 + bytes.len());
        if seen.control > 0 && !this.allowance.take(seen.control, Instant::now()) {
            buffer.set_filled(before);
            return Poll::Ready(Err(io::Error::other("a flood of control frames")));
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncWrite + Unpin> Metered<S> {
    fn wrote(&mut self, written: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        if let Poll::Ready(Ok(bytes)) = written {
            self.allowance.earn(bytes);
        }
        written
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Metered<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.wrote(written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, slices);
        self.wrote(written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

/// Control frames that a peer may still send: so many at once, more with time and with what it is sent.
#[derive(Debug)]
struct Allowance {
    per_s: u32,
    /// In bytes that were sent, [`BYTES_A_FRAME`] for a frame.
    left: u64,
    since: Instant,
}

impl Allowance {
    fn new(per_s: u32, now: Instant) -> Self {
        Self { per_s, left: most(per_s), since: now }
    }

    /// False where that is more than is left.
    fn take(&mut self, frames: u32, now: Instant) -> bool {
        let elapsed =
            now.saturating_duration_since(self.since).min(Duration::from_secs(BURST.into()));
        self.since = now;
        let gained = elapsed.as_secs_f64() * f64::from(self.per_s) * BYTES_A_FRAME as f64;
        self.left = (self.left + gained as u64).min(most(self.per_s));
        let cost = u64::from(frames) * BYTES_A_FRAME as u64;
        let is_enough = cost <= self.left;
        self.left = self.left.saturating_sub(cost);
        is_enough
    }

    fn earn(&mut self, bytes: usize) {
        self.left = (self.left + bytes as u64).min(most(self.per_s));
    }
}

fn most(per_s: u32) -> u64 {
    u64::from(per_s) * u64::from(BURST) * BYTES_A_FRAME as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    const PER_S: u32 = 100;
    const MOST: u32 = PER_S * BURST;
    const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
    const PING: &[u8] = b"\0\0\x08\x06\0\0\0\0\0abcdefgh";

    async fn read_all(bytes: &[u8]) -> io::Result<Vec<u8>> {
        let mut read = Vec::new();
        Metered::new(bytes, PER_S).read_to_end(&mut read).await.map(|_| read)
    }

    #[tokio::test(start_paused = true)]
    async fn what_is_no_flood_passes_as_it_is_and_a_flood_ends() {
        let pings = |count: u32| [PREFACE, &PING.repeat(count as usize)].concat();
        let calm = pings(MOST);
        assert_eq!(read_all(&calm).await.unwrap(), calm);
        let error = read_all(&pings(2 * MOST)).await.unwrap_err();
        assert_eq!(error.to_string(), "a flood of control frames");
        // The same bytes are nothing special in HTTP/1.1.
        let body = [b"POST / HTTP/1.1\r\n\r\n", &PING.repeat(20_000)[..]].concat();
        assert_eq!(read_all(&body).await.unwrap(), body);
    }

    #[test]
    fn time_and_what_is_sent_allow_more_up_to_a_bound() {
        let mut now = Instant::now();
        let mut allowance = Allowance::new(PER_S, now);
        assert!(allowance.take(MOST, now));
        assert!(!allowance.take(1, now));
        now += Duration::from_secs(1);
        assert!(allowance.take(PER_S, now));
        assert!(!allowance.take(1, now));
        allowance.earn(5 * BYTES_A_FRAME);
        assert!(allowance.take(5, now));
        assert!(!allowance.take(1, now));
        now += Duration::from_secs(3600);
        assert!(
            !allowance.take(MOST + 1, now),
            "an hour of silence is no more than ten seconds of it"
        );
    }

    /// Guards against: one connection that always has something to read, and never lets another one run.
    #[tokio::test(start_paused = true)]
    async fn a_connection_that_always_has_something_to_read_yields() {
        let turns = |frames: usize, frame: &'static [u8]| async move {
            let bytes = [PREFACE, &frame.repeat(frames)].concat();
            let reading = tokio::spawn(async move {
                let mut stream = Metered::new(&bytes[..], u32::MAX);
                let mut buffer = [0; 900];
                while stream.read(&mut buffer).await.unwrap() > 0 {}
            });
            let mut others = 0;
            while !reading.is_finished() {
                tokio::task::yield_now().await;
                others += 1;
            }
            others
        };
        let empty: &[u8] = b"\0\0\0\0\0\0\0\0\x01";
        let expected = 6400 / (FRAMES_A_TURN as usize + 100);
        let seen = turns(6400, empty).await;
        assert!(seen >= expected, "others had {seen} turns in 6400 frames");
    }

    #[tokio::test]
    async fn what_is_written_passes_as_it_is() {
        let (ours, mut theirs) = tokio::io::duplex(64);
        let mut metered = Metered::new(ours, PER_S);
        metered.write_all(b"hello").await.unwrap();
        metered.shutdown().await.unwrap();
        let mut read = String::new();
        theirs.read_to_string(&mut read).await.unwrap();
        assert_eq!(read, "hello");
    }
}
