//! How long a connection of HTTP/1 may keep silent between requests, and how long a header may take once it has begun.
//!
//! hyper has one limit for both. Clients keep connections for a minute or more and do not repeat a POST that falls into
//! the close; a header that comes byte by byte is an attack. When the time is over the reader sees the end of the
//! stream, as if the peer had closed: hyper ends the connection in order.

use futures_util::task::AtomicWaker;
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep_until};

/// What a connection is doing, as its requests and answers tell.
#[derive(Debug, Default)]
pub(super) struct Activity {
    /// Requests that have come in full, but for their body.
    requests: AtomicUsize,
    /// Those of them whose answer is not yet on its way to the last byte.
    unanswered: AtomicUsize,
    /// HTTP/2 has pings instead.
    is_http2: AtomicBool,
    /// Who reads. hyper does not ask again for what it was told is not there yet: so the end of an answer, where the
    /// wait begins, has to wake it.
    reader: AtomicWaker,
}

/// A request that is being answered, until it is dropped.
pub(super) struct Answering(Arc<Activity>);

impl Activity {
    /// A request has come.
    pub(super) fn begin(self: &Arc<Self>, is_http2: bool) -> Answering {
        self.is_http2.store(is_http2, Ordering::Relaxed);
        self.unanswered.fetch_add(1, Ordering::Relaxed);
        self.requests.fetch_add(1, Ordering::Relaxed);
        Answering(Arc::clone(self))
    }

    /// The number of the request that is waited for; none where nothing is.
    fn waits_for(&self) -> Option<usize> {
        let is_busy = self.unanswered.load(Ordering::Relaxed) > 0;
        let is_waiting = !is_busy && !self.is_http2.load(Ordering::Relaxed);
        is_waiting.then(|| self.requests.load(Ordering::Relaxed))
    }
}

impl Drop for Answering {
    fn drop(&mut self) {
        self.0.unanswered.fetch_sub(1, Ordering::Relaxed);
        if !self.0.is_http2.load(Ordering::Relaxed) {
            self.0.reader.wake();
        }
    }
}

/// The limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Silence before a request.
    pub(super) idle: Duration,
    /// From the first byte of a header to its last.
    pub(super) header: Duration,
}

/// A stream whose reader sees its end when the peer has been waited for long enough.
#[derive(Debug)]
pub(super) struct Timed<S> {
    stream: S,
    activity: Arc<Activity>,
    limits: Limits,
    wait: Option<Wait>,
    /// Made at the first wait and set anew for each one after it.
    alarm: Option<Pin<Box<Sleep>>>,
}

/// A wait for one request.
#[derive(Clone, Copy, Debug)]
struct Wait {
    request: usize,
    has_begun: bool,
    until: Instant,
}

impl<S> Timed<S> {
    pub(super) fn new(stream: S, activity: Arc<Activity>, limits: Limits) -> Self {
        Self { stream, activity, limits, wait: None, alarm: None }
    }

    /// Takes note that something was read, or that nothing is there to read. What is sent of a header does not extend
    /// its time.
    fn note(&mut self, was_read: bool) -> Option<Instant> {
        let request = self.activity.waits_for();
        let known =
            self.wait.filter(|wait| Some(wait.request) == request && (wait.has_begun || !was_read));
        self.wait = known.or_else(|| {
            let limit = if was_read { self.limits.header } else { self.limits.idle };
            let until = Instant::now() + limit;
            request.map(|request| Wait { request, has_begun: was_read, until })
        });
        self.wait.map(|wait| wait.until)
    }

    /// Whether the time of the wait is over; wakes the reader when it is.
    fn is_over(&mut self, context: &mut Context<'_>) -> bool {
        self.activity.reader.register(context.waker());
        let Some(until) = self.note(false) else { return false };
        let alarm = self.alarm.get_or_insert_with(|| Box::pin(sleep_until(until)));
        if alarm.deadline() != until {
            alarm.as_mut().reset(until);
        }
        alarm.as_mut().poll(context).is_ready()
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Timed<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        match Pin::new(&mut self.stream).poll_read(context, buffer) {
            Poll::Pending if self.is_over(context) => Poll::Ready(Ok(())),
            Poll::Ready(Ok(())) if buffer.filled().len() > before => {
                self.note(true);
                Poll::Ready(Ok(()))
            }
            polled => polled,
        }
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Timed<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, buffer)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffers: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(context, buffers)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};

    const IDLE: Duration = Duration::from_secs(75);
    const HEADER: Duration = Duration::from_secs(10);

    fn connection() -> (DuplexStream, Timed<DuplexStream>, Arc<Activity>) {
        let (peer, stream) = duplex(1024);
        let activity = Arc::new(Activity::default());
        let limits = Limits { idle: IDLE, header: HEADER };
        (peer, Timed::new(stream, Arc::clone(&activity), limits), activity)
    }

    /// Bytes that are read, and how long they were waited for.
    async fn read(stream: &mut Timed<DuplexStream>) -> (usize, Duration) {
        let begin = Instant::now();
        let mut buffer = [0; 64];
        (stream.read(&mut buffer).await.unwrap(), begin.elapsed())
    }

    #[tokio::test(start_paused = true)]
    async fn silence_between_requests_ends_after_the_idle_time() {
        let (mut peer, mut stream, activity) = connection();
        peer.write_all(b"GET").await.unwrap();
        assert_eq!(read(&mut stream).await.0, 3);
        drop(activity.begin(false));
        let (bytes, waited) = read(&mut stream).await;
        assert_eq!(bytes, 0);
        assert!((IDLE..IDLE + HEADER / 2).contains(&waited), "{waited:?}");
    }

    #[tokio::test(start_paused = true)]
    async fn a_header_that_trickles_has_its_time_from_the_first_byte_on() {
        let (mut peer, mut stream, activity) = connection();
        drop(activity.begin(false));
        let trickle = async {
            tokio::time::sleep(IDLE / 2).await;
            while peer.write_all(b"x").await.is_ok() {
                tokio::time::sleep(HEADER / 4).await;
            }
        };
        let begin = Instant::now();
        let reading = async {
            while read(&mut stream).await.0 > 0 {}
            drop(stream);
        };
        tokio::join!(trickle, reading);
        let lasted = begin.elapsed();
        assert!(lasted >= IDLE / 2 + HEADER && lasted <= IDLE / 2 + 2 * HEADER, "{lasted:?}");
    }

    /// Guards against: a follower of events, or who waits for a slow answer, is cut off.
    #[tokio::test(start_paused = true)]
    async fn no_one_is_hurried_who_waits_for_an_answer_or_speaks_http_2() {
        for is_http2 in [false, true] {
            let (_peer, mut stream, activity) = connection();
            let answering = activity.begin(is_http2);
            if is_http2 {
                drop(answering);
            }
            let waited = tokio::time::timeout(10 * IDLE, read(&mut stream)).await;
            assert!(waited.is_err(), "HTTP/2: {is_http2}");
        }
    }

    /// Guards against: whoever was last read from during an answer is never looked at again, and stays for ever.
    #[tokio::test(start_paused = true)]
    async fn the_wait_begins_with_the_end_of_the_answer_though_no_one_reads_again() {
        let (_peer, mut stream, activity) = connection();
        let answering = activity.begin(false);
        let reading = tokio::spawn(async move { read(&mut stream).await });
        tokio::time::sleep(2 * IDLE).await;
        assert!(!reading.is_finished());
        drop(answering);
        let (bytes, waited) = tokio::time::timeout(10 * IDLE, reading).await.unwrap().unwrap();
        assert_eq!(bytes, 0);
        assert!((3 * IDLE..3 * IDLE + HEADER / 2).contains(&waited), "{waited:?}");
    }

    #[tokio::test(start_paused = true)]
    async fn every_request_has_the_whole_time() {
        let (mut peer, mut stream, activity) = connection();
        for _ in 0..5 {
            tokio::time::sleep(IDLE * 9 / 10).await;
            peer.write_all(b"GET").await.unwrap();
            assert_eq!(read(&mut stream).await.0, 3);
            drop(activity.begin(false));
            let nothing = tokio::time::timeout(HEADER / 10, read(&mut stream)).await;
            assert!(nothing.is_err(), "the wait begins anew");
        }
    }
}
