//! A PUB socket: listens, and gives every message to every subscriber that wants it and has room.
//!
//! A subscriber has a queue of its own. When it is full the subscriber misses what is published, and that is
//! counted: nobody else waits. Two threads serve each subscriber, one that writes and one that listens to
//! what it subscribes to.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::wire::{self, Command};

/// Most subscribers of a socket.
const MOST_PEERS: usize = 64;
/// Most subscriptions of a subscriber.
const MOST_TOPICS: usize = 256;
/// How long the handshake of a subscriber may take in all.
const HANDSHAKE: Duration = Duration::from_secs(5);
/// How long a writer may take to see that its connection has ended.
const ENDING: Duration = Duration::from_secs(1);

/// A message with its frames, as it is sent.
#[derive(Debug, Default)]
pub(super) struct Message {
    bytes: Vec<u8>,
    /// Where the body of the first frame begins and ends: what subscriptions are compared with.
    topic: (usize, usize),
}

impl Message {
    /// Forgets everything but its memory.
    pub(super) fn clear(&mut self) {
        self.bytes.clear();
        self.topic = (0, 0);
    }

    /// Appends a frame.
    pub(super) fn frame(&mut self, body: &[u8], more: bool) {
        let first = self.bytes.is_empty();
        wire::push_frame(&mut self.bytes, body, more);
        if first {
            self.topic = (self.bytes.len() - body.len(), self.bytes.len());
        }
    }

    pub(super) fn len(&self) -> usize {
        self.bytes.len()
    }

    fn is_wanted(&self, topics: &[Vec<u8>]) -> bool {
        let topic = self.bytes.get(self.topic.0..self.topic.1).unwrap_or_default();
        topics.iter().any(|prefix| topic.starts_with(prefix))
    }
}

/// What became of messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Subscribers that came.
    pub(super) seen: u64,
    /// Messages handed to the connection of a subscriber.
    pub(super) sent: u64,
    /// Messages that a subscriber has missed: its queue was full, or it was gone before they left.
    pub(super) lost: u64,
}

/// A subscriber.
#[derive(Debug)]
struct Peer {
    stream: TcpStream,
    state: Mutex<State>,
    change: Condvar,
}

#[derive(Debug, Default)]
struct State {
    topics: Vec<Vec<u8>>,
    queue: VecDeque<Arc<Message>>,
    /// Commands that are to be answered before the next message.
    answers: Vec<u8>,
    /// Whether the handshake is done.
    greeted: bool,
    /// Whether the writer is writing.
    busy: bool,
    /// Whether the connection has ended, or is to end.
    gone: bool,
    sent: u64,
    lost: u64,
}

#[derive(Debug, Default)]
struct Shared {
    peers: Mutex<Vec<Arc<Peer>>>,
    /// Counts of those that are gone.
    counts: Mutex<Counts>,
    closing: AtomicBool,
}

/// A PUB socket at an address.
#[derive(Debug)]
pub(super) struct Publisher {
    address: SocketAddr,
    limit: usize,
    shared: Arc<Shared>,
    acceptor: Option<JoinHandle<()>>,
}

/// A thread that panicked has left numbers behind, nothing that is half done.
fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Publisher {
    /// Listens at an address; a subscriber may have up to `limit` messages waiting.
    pub(super) fn bind(address: SocketAddr, limit: usize) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let shared = Arc::new(Shared::default());
        let ours = Arc::clone(&shared);
        let accept = move || accept(&listener, &ours, limit);
        let acceptor = thread::Builder::new().name("zmq accept".to_owned()).spawn(accept)?;
        Ok(Self { address, limit, shared, acceptor: Some(acceptor) })
    }

    pub(super) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Gives a message to everybody who wants it. Never waits.
    pub(super) fn publish(&self, message: &Arc<Message>) {
        for peer in held(&self.shared.peers).iter() {
            let mut state = held(&peer.state);
            if state.gone || !message.is_wanted(&state.topics) {
                continue;
            }
            if state.queue.len() < self.limit {
                state.queue.push_back(Arc::clone(message));
                peer.change.notify_all();
            } else {
                state.lost += 1;
            }
        }
    }

    /// Waits at most so long for what is on its way, then ends all connections.
    pub(super) fn close(&mut self, timeout: Duration) -> Counts {
        let Some(acceptor) = self.acceptor.take() else { return *held(&self.shared.counts) };
        self.shared.closing.store(true, Ordering::Release);
        // Wakes the acceptor, wherever it listens.
        let mut to = self.address;
        if to.ip().is_unspecified() {
            to.set_ip(if to.is_ipv4() {
                [127, 0, 0, 1].into()
            } else {
                std::net::Ipv6Addr::LOCALHOST.into()
            });
        }
        let woken = TcpStream::connect_timeout(&to, Duration::from_secs(1)).is_ok();
        if woken {
            let _ = acceptor.join();
        }
        let until = Instant::now() + timeout;
        let peers = std::mem::take(&mut *held(&self.shared.peers));
        for peer in &peers {
            let mut state = held(&peer.state);
            while !state.gone && (state.busy || !state.queue.is_empty()) {
                let left = until.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    break;
                }
                state = peer.change.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
            }
            drop(state);
            peer.end();
            peer.wait_for_writer();
            self.shared.tally(peer);
        }
        *held(&self.shared.counts)
    }
}

impl Drop for Publisher {
    fn drop(&mut self) {
        self.close(Duration::ZERO);
    }
}

impl Shared {
    /// Adds what became of the messages of a subscriber that is gone.
    fn tally(&self, peer: &Peer) {
        let mut state = held(&peer.state);
        let mut counts = held(&self.counts);
        counts.sent += std::mem::take(&mut state.sent);
        counts.lost += std::mem::take(&mut state.lost);
    }
}

impl Peer {
    /// Ends the connection. What still waits is lost, and its memory is free for other messages.
    fn end(&self) {
        let mut state = held(&self.state);
        state.gone = true;
        state.lost += state.queue.len() as u64;
        state.queue.clear();
        drop(state);
        self.change.notify_all();
        // It may have ended already.
        let _ = self.stream.shutdown(Shutdown::Both);
    }

    /// Waits until the writer has counted its last message.
    fn wait_for_writer(&self) {
        let state = held(&self.state);
        let _ = self.change.wait_timeout_while(state, ENDING, |state| state.busy);
    }
}

/// Reads from a subscriber until an instant: one that sends a byte now and then holds its place no longer.
struct Until<'a> {
    stream: &'a TcpStream,
    end: Instant,
}

impl Read for Until<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left))?;
        self.stream.read(into)
    }
}

/// Takes in subscribers until the socket closes.
fn accept(listener: &TcpListener, shared: &Arc<Shared>, limit: usize) {
    loop {
        let accepted = listener.accept();
        if shared.closing.load(Ordering::Acquire) {
            return;
        }
        let Ok((stream, _)) = accepted else {
            // Out of file descriptors, say: others may end.
            thread::sleep(Duration::from_millis(20));
            continue;
        };
        let mut peers = held(&shared.peers);
        peers.retain(|peer| {
            let state = held(&peer.state);
            let gone = state.gone && !state.busy;
            drop(state);
            if gone {
                shared.tally(peer);
            }
            !gone
        });
        if peers.len() >= MOST_PEERS {
            // A connection that has not yet introduced itself gives way; subscribers stay.
            let Some(place) = peers.iter().position(|peer| !held(&peer.state).greeted) else { continue };
            peers.remove(place).end();
        }
        // Small messages leave at once.
        let _ = stream.set_nodelay(true);
        let queue = VecDeque::with_capacity(limit.min(4096));
        let state = Mutex::new(State { queue, ..State::default() });
        let peer = Arc::new(Peer { stream, state, change: Condvar::new() });
        let (ours, all) = (Arc::clone(&peer), Arc::clone(shared));
        let serve = move || {
            // A connection that ends is no error.
            let _ = serve(&ours, &all);
            ours.end();
        };
        if thread::Builder::new().name("zmq listen".to_owned()).spawn(serve).is_ok() {
            peers.push(peer);
        }
    }
}

/// Greets a subscriber, then listens to what it subscribes to, until it is gone.
fn serve(peer: &Arc<Peer>, shared: &Shared) -> io::Result<()> {
    let mut stream = &peer.stream;
    let mut until = Until { stream, end: Instant::now() + HANDSHAKE };
    stream.set_write_timeout(Some(HANDSHAKE))?;
    stream.write_all(&wire::greeting())?;
    let mut greeting = [0; 64];
    until.read_exact(&mut greeting)?;
    if !wire::understands(&greeting) {
        return Ok(());
    }
    stream.write_all(&wire::ready())?;
    match wire::read(&mut until)? {
        Command::Ready(kind) if kind == b"SUB" || kind == b"XSUB" => {}
        _ => return Ok(()),
    }
    held(&peer.state).greeted = true;
    held(&shared.counts).seen += 1;
    // From here on a subscriber may sleep as long as it likes.
    stream.set_read_timeout(None)?;
    stream.set_write_timeout(None)?;
    let writer = Arc::clone(peer);
    let write = move || {
        let _ = write(&writer);
        writer.end();
    };
    let writer = thread::Builder::new().name("zmq send".to_owned()).spawn(write)?;
    let ended = listen(peer, &mut stream);
    peer.end();
    let _ = writer.join();
    ended
}

fn listen(peer: &Peer, stream: &mut &TcpStream) -> io::Result<()> {
    loop {
        let command = wire::read(stream)?;
        let mut state = held(&peer.state);
        match command {
            Command::Subscribe(topic) if state.topics.len() < MOST_TOPICS => state.topics.push(topic),
            Command::Cancel(topic) => {
                if let Some(at) = state.topics.iter().position(|other| *other == topic) {
                    state.topics.swap_remove(at);
                }
            }
            Command::Ping(context) if state.answers.len() < MOST_TOPICS => {
                let pong = wire::command("PONG", &context);
                state.answers.extend_from_slice(&pong);
                peer.change.notify_all();
            }
            _ => {}
        }
    }
}

/// Writes what waits for a subscriber, until it is gone.
fn write(peer: &Peer) -> io::Result<()> {
    let mut stream = &peer.stream;
    let mut answers = Vec::new();
    let mut state = held(&peer.state);
    loop {
        while !state.gone && state.queue.is_empty() && state.answers.is_empty() {
            state = peer.change.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.gone {
            return Ok(());
        }
        std::mem::swap(&mut answers, &mut state.answers);
        let message = state.queue.pop_front();
        state.busy = true;
        drop(state);
        let written = stream
            .write_all(&answers)
            .and_then(|()| message.as_ref().map_or(Ok(()), |message| stream.write_all(&message.bytes)));
        answers.clear();
        state = held(&peer.state);
        state.busy = false;
        match (&written, message) {
            (Ok(()), Some(_)) => state.sent += 1,
            (Err(_), Some(_)) => state.lost += 1,
            _ => {}
        }
        if state.queue.is_empty() {
            // Whoever waits for the last message.
            peer.change.notify_all();
        }
        written?;
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Memory of messages is used again when nobody holds them.
    #[test]
    fn a_subscriber_that_is_gone_holds_no_messages() {
        let mut publisher = Publisher::bind("127.0.0.1:0".parse().unwrap(), 16).unwrap();
        let mut sub = TcpStream::connect(publisher.address()).unwrap();
        sub.write_all(&wire::greeting()).unwrap();
        sub.write_all(&wire::command("READY", b"\x0bSocket-Type\0\0\0\x03SUB")).unwrap();
        sub.write_all(&[0, 1, 1]).unwrap();
        let message = |size: usize| {
            let mut message = Message::default();
            message.frame(&vec![0; size], false);
            Arc::new(message)
        };
        let until = Instant::now() + Duration::from_secs(10);
        let soon = |done: &dyn Fn() -> bool| {
            while !done() {
                assert!(Instant::now() < until);
                thread::sleep(Duration::from_millis(1));
            }
        };
        soon(&|| held(&publisher.shared.peers).iter().any(|peer| !held(&peer.state).topics.is_empty()));
        // More than the buffers of a connection take: the writer is stuck in the first, the second waits.
        let (first, second) = (message(64 << 20), message(8));
        publisher.publish(&first);
        publisher.publish(&second);
        assert_eq!(Arc::strong_count(&second), 2);
        drop(sub);
        soon(&|| Arc::strong_count(&first) + Arc::strong_count(&second) == 2);
        assert_eq!(publisher.close(Duration::ZERO), Counts { seen: 1, sent: 0, lost: 2 });
    }
}
