//! A link between agent and server: a TCP proxy on loopback that delays, goes dead and comes back.
//!
//! Bytes keep their order, as TCP's do. A dead link loses nothing that TCP would not send again: what was under way
//! arrives when the link is back. Connections open through a dead link, and then nothing comes: half open. Connections
//! that there are can be made later than new ones, which then overtake them, or forgotten for good.

use crate::tap::Tap;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep_until};

/// Pieces under way per direction; beyond, the sender has to wait, as with any full pipe.
const UNDER_WAY: usize = 4096;

/// How the link is now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Link {
    up: Duration,
    down: Duration,
    is_dead: bool,
    /// Connections of an earlier generation are closed.
    generation: u64,
    /// Counts what befalls the connections that there are, and not those that are opened later.
    era: u64,
    /// Connections opened before this era are later than others by this much, both ways.
    lame_before: u64,
    lame: Duration,
    /// What is sent on connections opened before this era goes nowhere.
    swallowed_before: u64,
}

/// A running proxy. It ends, and its connections with it, when it is dropped.
#[derive(Debug)]
pub struct Proxy {
    address: SocketAddr,
    link: watch::Sender<Link>,
    tap: Tap,
    accepting: JoinHandle<()>,
}

impl Proxy {
    /// A link to `server` without delay.
    ///
    /// # Panics
    /// Where there is no free port.
    pub async fn start(server: SocketAddr) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.expect("a free port");
        let address = listener.local_addr().expect("it is bound");
        let link = watch::Sender::new(Link::default());
        let tap = Tap::default();
        let accepting = tokio::spawn(accept(listener, server, link.subscribe(), tap.clone()));
        Self { address, link, tap, accepting }
    }

    /// What the agent said last.
    pub fn tap(&self) -> &Tap {
        &self.tap
    }

    /// Where to connect instead of the server.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Delays what is sent from now on: `up` to the server, `down` from it.
    pub fn delay(&self, up: Duration, down: Duration) {
        self.link.send_modify(|link| (link.up, link.down) = (up, down));
    }

    /// Lets nothing through until [`Proxy::mend`]; connections stay open.
    pub fn cut(&self) {
        self.link.send_modify(|link| link.is_dead = true);
    }

    /// Lets through what waited, and what comes.
    pub fn mend(&self) {
        self.link.send_modify(|link| link.is_dead = false);
    }

    /// Delays what is sent from now on over the connections that there are: what takes a fresh one overtakes it.
    /// Zero ends it.
    pub fn lame(&self, late: Duration) {
        self.link.send_modify(|link| {
            link.era += 1;
            (link.lame_before, link.lame) = (link.era, late);
        });
    }

    /// Lets nothing through any more over the connections that there are, for good, their ends included: half open, as
    /// behind a router that has forgotten them. New ones are as good as ever.
    pub fn swallow(&self) {
        self.link.send_modify(|link| {
            link.era += 1;
            link.swallowed_before = link.era;
        });
    }

    /// Closes all connections; new ones are accepted.
    pub fn drop_connections(&self) {
        self.link.send_modify(|link| link.generation += 1);
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        self.accepting.abort();
    }
}

async fn accept(listener: TcpListener, server: SocketAddr, link: watch::Receiver<Link>, tap: Tap) {
    while let Ok((agent, _)) = listener.accept().await {
        tokio::spawn(connect(agent, server, link.clone(), tap.clone()));
    }
}

/// Carries one connection until both sides have ended it, it is dropped, or the proxy is.
async fn connect(agent: TcpStream, server: SocketAddr, link: watch::Receiver<Link>, tap: Tap) {
    let Link { generation, era, .. } = *link.borrow();
    let Ok(server) = TcpStream::connect(server).await else { return };
    if agent.set_nodelay(true).and(server.set_nodelay(true)).is_err() {
        return;
    }
    let (from_agent, to_agent) = agent.into_split();
    let (from_server, to_server) = server.into_split();
    let (mut changes, mut proxy) = (link.clone(), link.clone());
    let lame = move |link: &Link| {
        if era < link.lame_before { link.lame } else { Duration::ZERO }
    };
    let up = Way {
        era,
        delay: |link: &Link| link.up + lame(link),
        hear: |bytes: &[u8]| tap.hear(bytes),
    };
    let down = Way { era, delay: |link: &Link| link.down + lame(link), hear: |_: &[u8]| {} };
    let up = carry(from_agent, to_server, link.clone(), up);
    let down = carry(from_server, to_agent, link, down);
    tokio::select! {
        _ = async { tokio::join!(up, down) } => {}
        _ = changes.wait_for(|link| link.generation != generation) => {}
        () = async { while proxy.changed().await.is_ok() {} } => {}
    }
}

/// One direction of a connection: when it was opened, how late it is, and who hears what is said.
struct Way<D, H> {
    era: u64,
    delay: D,
    hear: H,
}

/// Carries one direction to its end.
async fn carry<D: Fn(&Link) -> Duration, H: Fn(&[u8])>(
    mut from: OwnedReadHalf,
    mut to: OwnedWriteHalf,
    link: watch::Receiver<Link>,
    way: Way<D, H>,
) {
    let Way { era, delay, hear } = way;
    let is_swallowed = |link: &watch::Receiver<Link>| era < link.borrow().swallowed_before;
    let (sender, mut under_way) = mpsc::channel::<(Instant, Vec<u8>)>(UNDER_WAY);
    let read = {
        let link = link.clone();
        async move {
            let mut bytes = vec![0; 16 * 1024];
            while let Ok(count @ 1..) = from.read(&mut bytes).await {
                hear(&bytes[..count]);
                if is_swallowed(&link) {
                    continue;
                }
                let arrival = Instant::now() + delay(&link.borrow());
                if sender.send((arrival, bytes[..count].to_vec())).await.is_err() {
                    return;
                }
            }
            if is_swallowed(&link) {
                std::future::pending::<()>().await;
            }
        }
    };
    let write = async move {
        let mut link = link;
        while let Some((arrival, bytes)) = under_way.recv().await {
            sleep_until(arrival).await;
            if link.wait_for(|link| !link.is_dead).await.is_err() {
                return;
            }
            if era >= link.borrow().swallowed_before && to.write_all(&bytes).await.is_err() {
                return;
            }
        }
        // The end of the stream crosses the link as well.
        let _ = link.wait_for(|link| !link.is_dead).await;
        let _ = to.shutdown().await;
    };
    tokio::join!(read, write);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A server that sends back what it gets.
    async fn echo() -> SocketAddr {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        tokio::spawn(async move {
            while let Ok((mut stream, _)) = listener.accept().await {
                tokio::spawn(async move {
                    let (mut from, mut to) = stream.split();
                    tokio::io::copy(&mut from, &mut to).await
                });
            }
        });
        address
    }

    async fn round_trip(stream: &mut TcpStream, text: &[u8]) -> Vec<u8> {
        stream.write_all(text).await.unwrap();
        let mut answer = vec![0; text.len()];
        stream.read_exact(&mut answer).await.unwrap();
        answer
    }

    #[tokio::test]
    async fn bytes_cross_as_late_as_is_said() {
        let proxy = Proxy::start(echo().await).await;
        let mut stream = TcpStream::connect(proxy.address()).await.unwrap();
        proxy.delay(Duration::from_millis(80), Duration::from_millis(40));
        let begin = Instant::now();
        assert_eq!(round_trip(&mut stream, b"late").await, b"late");
        assert!(begin.elapsed() >= Duration::from_millis(120));
    }

    #[tokio::test]
    async fn what_is_sent_later_with_less_delay_does_not_overtake() {
        let proxy = Proxy::start(echo().await).await;
        let mut stream = TcpStream::connect(proxy.address()).await.unwrap();
        let sent: Vec<u8> = (0..200).collect();
        for &byte in &sent {
            let delay = Duration::from_millis(u64::from(byte % 7));
            proxy.delay(delay, Duration::from_millis(3) / (1 + u32::from(byte % 2)));
            stream.write_all(&[byte]).await.unwrap();
            tokio::task::yield_now().await;
        }
        let mut came = vec![0; sent.len()];
        stream.read_exact(&mut came).await.unwrap();
        assert_eq!(came, sent);
    }

    /// Guards against: an outage that loses bytes, or lets some through, makes every test of outages a fiction.
    #[tokio::test]
    async fn a_dead_link_holds_everything_back_and_loses_nothing() {
        let proxy = Proxy::start(echo().await).await;
        let mut old = TcpStream::connect(proxy.address()).await.unwrap();
        round_trip(&mut old, b"x").await;
        proxy.cut();
        let mut fresh = TcpStream::connect(proxy.address()).await.unwrap();
        for stream in [&mut old, &mut fresh] {
            let silence =
                tokio::time::timeout(Duration::from_millis(100), round_trip(stream, b"held"));
            assert!(silence.await.is_err(), "nothing comes through");
        }
        proxy.mend();
        for stream in [&mut old, &mut fresh] {
            let mut answer = [0; 4];
            stream.read_exact(&mut answer).await.unwrap();
            assert_eq!(&answer, b"held");
        }
    }

    /// Guards against: requests are never really overtaken, and a test of reordering shows nothing.
    #[tokio::test]
    async fn a_fresh_connection_overtakes_a_lame_one() {
        let proxy = Proxy::start(echo().await).await;
        let mut old = TcpStream::connect(proxy.address()).await.unwrap();
        round_trip(&mut old, b"x").await;
        proxy.lame(Duration::from_millis(150));
        let begin = Instant::now();
        old.write_all(b"old").await.unwrap();
        let mut fresh = TcpStream::connect(proxy.address()).await.unwrap();
        round_trip(&mut fresh, b"fresh").await;
        let overtaken = tokio::time::timeout(Duration::ZERO, old.read(&mut [0; 3])).await;
        assert!(overtaken.is_err() || begin.elapsed() >= Duration::from_millis(300));
        assert_eq!(round_trip(&mut old, b"").await, b"");
        old.read_exact(&mut [0; 3]).await.unwrap();
        assert!(begin.elapsed() >= Duration::from_millis(300), "up and down");
    }

    #[tokio::test]
    async fn a_forgotten_connection_stays_open_and_carries_nothing() {
        let proxy = Proxy::start(echo().await).await;
        let mut old = TcpStream::connect(proxy.address()).await.unwrap();
        round_trip(&mut old, b"x").await;
        proxy.swallow();
        let silence = tokio::time::timeout(Duration::from_millis(100), round_trip(&mut old, b"y"));
        assert!(silence.await.is_err(), "neither an answer nor an end");
        let mut fresh = TcpStream::connect(proxy.address()).await.unwrap();
        assert_eq!(round_trip(&mut fresh, b"z").await, b"z");
    }

    #[tokio::test]
    async fn dropped_connections_end_and_new_ones_are_taken() {
        let proxy = Proxy::start(echo().await).await;
        let mut stream = TcpStream::connect(proxy.address()).await.unwrap();
        round_trip(&mut stream, b"x").await;
        proxy.drop_connections();
        assert!(matches!(stream.read(&mut [0; 1]).await, Ok(0) | Err(_)));
        let mut stream = TcpStream::connect(proxy.address()).await.unwrap();
        assert_eq!(round_trip(&mut stream, b"y").await, b"y");
        drop(proxy);
        assert!(matches!(stream.read(&mut [0; 1]).await, Ok(0) | Err(_)), "it ends with the proxy");
    }
}
