//! Bytes to messages: NMEA 0183 sentences and NovAtel logs, mixed, cut anywhere, with anything in between.
//!
//! | message | how it is found | checked by |
//! | --- | --- | --- |
//! | NMEA 0183 ([`nmea`]) | a line with `$...*hh`, whatever stands before the `$` | exclusive or of the bytes between `$` and `*` |
//! | NovAtel ASCII ([`novatel`]) | a line with `#NAME,...;...*hhhhhhhh`, or `%` | CRC-32 of the bytes between `#` and `*` |
//! | NovAtel binary | `AA 44 12`, length of header and body, body; `AA 44 13` for the short header | CRC-32 of all before it |
//!
//! Lines end with CR LF, LF or CR alone. A header of NovAtel that cannot be one is passed over, and so is one
//! of more than 256 bytes when messages with right checksums stand where its body should be
//! (two sentences, or one message with a CRC): what follows garbage is decoded, not waited for.
//!
//! A [`Decoder`] knows no files and no ports: whoever has bytes pushes them, and is called with every
//! message. What is decided about a byte depends on it and on those after it, never on how they were cut, so
//! a stream gives the same messages in any pieces. Memory is bounded: lines of more than 4096 bytes and
//! binary messages of more than 16 KiB are counted as malformed and left. After a wrong checksum the search
//! goes on right behind the sync bytes, so a message that is hidden in what seemed another one is found.
//! Nothing is allocated after [`Decoder::new`].
//!
//! Every message and everything that is none is counted in [`Counts`]. A message that states that it
//! holds no solution (void) is handed on like others, without a position.
//!
//! ```
//! use nereus::nav::decode::{Content, Decoder};
//!
//! let mut decoder = Decoder::new();
//! let mut headings = Vec::new();
//! let mut see = |message: nereus::nav::decode::Message| {
//!     if let Content::Hdt(hdt) = message.content {
//!         headings.extend(hdt.heading_deg);
//!     }
//! };
//! decoder.push(b"noise\r\n$HEHDT,27", &mut see);
//! decoder.push(b"4.5,T*2B\r\n$HEHDT,275.0,T*00\r\n", &mut see);
//! assert_eq!(headings, [274.5]);
//! assert_eq!((decoder.counts().malformed, decoder.counts().bad_checksum), (1, 1));
//! ```

mod enclosed;
pub mod nmea;
pub mod novatel;

use std::fmt;
use std::io::Write as _;

use serde::Serialize;

use self::enclosed::Enclosed;
pub use self::nmea::{Gga, Gll, Gst, Hdt, Pashr, Rmc, Vtg, Zda};
pub use self::novatel::Inspvax;

/// The longest line that is read, bytes.
pub const MAX_LINE_BYTES: usize = 4096;
/// The longest binary message that is read, bytes with header and checksum.
pub const MAX_BINARY_BYTES: usize = 16 << 10;
/// Bytes that are held: whatever is not yet decided, and room for more.
const HELD_BYTES: usize = 2 * MAX_BINARY_BYTES;

/// A message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Message {
    /// Line of text on which it stands, from 1; a binary message stands on the line after the last one.
    pub line: u64,
    /// Who sent it: the first two letters of a sentence.
    pub talker: Option<[u8; 2]>,
    /// Whether the stream began within a sentence.
    pub begun_within: bool,
    /// Its content.
    pub content: Content,
}

/// Content of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Content {
    /// Position, quality and height.
    Gga(Gga),
    /// The same of several constellations.
    Gns(Gga),
    /// Position, speed, course and date.
    Rmc(Rmc),
    /// Position.
    Gll(Gll),
    /// Speed and course.
    Vtg(Vtg),
    /// Heading.
    Hdt(Hdt),
    /// Heading, and how it was found.
    Ths(Hdt),
    /// Time and date.
    Zda(Zda),
    /// Standard deviations of the position.
    Gst(Gst),
    /// Heading, roll and pitch.
    Pashr(Pashr),
    /// All of it.
    Inspvax(Inspvax),
    /// All of it but deviations: INSPVA or INSPVAS.
    Inspva(Inspvax),
}

/// What was found in a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Lines of text, empty ones too.
    pub lines: u64,
    /// Messages handed on.
    pub good: u64,
    /// Messages whose checksum is wrong.
    pub bad_checksum: u64,
    /// Messages of kinds that are not read here, their checksum right.
    pub unknown: u64,
    /// Lines that are no sentence, and messages whose fields cannot be read.
    pub malformed: u64,
    /// Among the good ones: positions that say of themselves that there is none, or are empty.
    pub void: u64,
    /// Among the malformed: lines of abbreviated ASCII logs of NovAtel.
    pub abbreviated: u64,
    /// Kinds that are not read here.
    #[serde(skip)]
    pub others: Others,
    /// The first line is the end of a sentence.
    #[serde(skip)]
    begun_within: bool,
}

/// Letters of a kind that are kept.
const KIND_LETTERS: usize = 16;

/// Kinds of messages that are not read, with how many there are: the first eight.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct Others([([u8; KIND_LETTERS], u64); 8]);

impl Others {
    /// Counts a message of a kind.
    fn count(&mut self, kind: &[u8]) {
        let mut letters = [0; KIND_LETTERS];
        for (letter, of) in
            letters.iter_mut().zip(kind.iter().filter(|b| b.is_ascii_alphanumeric() || **b == b' '))
        {
            *letter = *of;
        }
        if letters[0] == 0 {
            return;
        }
        if let Some(place) = self.0.iter_mut().find(|place| place.0 == letters || place.1 == 0) {
            *place = (letters, place.1 + 1);
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0[0].1 == 0
    }
}

impl fmt::Debug for Others {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.to_string())
    }
}

impl fmt::Display for Others {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (letters, count)) in self.0.iter().take_while(|(_, count)| *count > 0).enumerate() {
            let kind: String = letters.iter().take_while(|b| **b != 0).map(|b| char::from(*b)).collect();
            write!(f, "{}{count} {kind}", if index == 0 { "" } else { ", " })?;
        }
        Ok(())
    }
}

/// Why a message with a right checksum is not handed on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unread {
    /// Not a kind that is read here.
    Unknown,
    /// Its fields cannot be read.
    Malformed,
}

/// Finds messages in a stream of bytes.
#[derive(Clone, Debug)]
pub struct Decoder {
    held: Vec<u8>,
    search: Search,
    counts: Counts,
}

/// What is known of the bytes that are held.
#[derive(Clone, Debug)]
struct Search {
    sums: novatel::Sums,
    enclosed: Enclosed,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder that has seen nothing.
    pub fn new() -> Self {
        Self {
            held: Vec::with_capacity(HELD_BYTES),
            search: Search {
                sums: novatel::Sums::with_capacity(HELD_BYTES),
                enclosed: Enclosed::with_capacity(),
            },
            counts: Counts::default(),
        }
    }

    /// Takes the next bytes of the stream, any number of them, and calls with every message that they
    /// complete.
    pub fn push(&mut self, mut bytes: &[u8], see: &mut dyn FnMut(Message)) {
        while !bytes.is_empty() {
            let taken = bytes.len().min(HELD_BYTES - self.held.len());
            self.held.extend_from_slice(&bytes[..taken]);
            bytes = &bytes[taken..];
            self.decide(false, see);
        }
    }

    /// Takes the end of the stream: a last line needs no line end. The decoder is as new but for its counts.
    pub fn finish(&mut self, see: &mut dyn FnMut(Message)) {
        self.decide(true, see);
        self.search.taken(usize::MAX);
        self.held.clear();
    }

    /// What was found so far.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    fn decide(&mut self, ended: bool, see: &mut dyn FnMut(Message)) {
        let mut at = 0;
        loop {
            let taken = step(&self.held, at, ended, &mut self.search, &mut self.counts, see);
            if taken == 0 {
                break;
            }
            at += taken;
        }
        self.held.drain(..at);
        self.search.taken(at);
    }
}

impl Search {
    /// So many bytes are gone from the front of what is held.
    fn taken(&mut self, bytes: usize) {
        self.sums.taken(bytes);
        self.enclosed.taken(bytes);
    }
}

/// Whether sync bytes of a binary message stand at the beginning; `None`: they may, when more comes.
fn sync(bytes: &[u8]) -> Option<bool> {
    match bytes {
        [0xAA, 0x44, 0x12 | 0x13, ..] => Some(true),
        [0xAA] | [0xAA, 0x44] => None,
        _ => Some(false),
    }
}

/// Takes what stands at a place in some bytes; how many they were, 0 when more is needed to decide.
/// Depends on nothing but the bytes from there on and on whether more may come.
fn step(
    held: &[u8],
    at: usize,
    ended: bool,
    search: &mut Search,
    counts: &mut Counts,
    see: &mut dyn FnMut(Message),
) -> usize {
    let bytes = &held[at..];
    if sync(bytes) == Some(true) {
        return binary(held, at, ended, search, counts, see);
    }
    let window = &bytes[..bytes.len().min(MAX_LINE_BYTES)];
    for (i, &byte) in window.iter().enumerate() {
        match byte {
            b'\n' | b'\r' => {
                let is_pair = match bytes.get(i + 1) {
                    // A CR alone ends the lines of old instruments.
                    None if byte == b'\r' && !ended => return 0,
                    next => byte == b'\r' && next == Some(&b'\n'),
                };
                counts.lines += 1;
                line(&window[..i], counts, see);
                return i + 1 + usize::from(is_pair);
            }
            0xAA => match sync(&bytes[i..]) {
                Some(true) => {
                    counts.lines += 1;
                    line(&window[..i], counts, see);
                    return i;
                }
                None if !ended => return 0,
                _ => {}
            },
            _ => {}
        }
    }
    if window.len() == MAX_LINE_BYTES {
        counts.malformed += 1;
        return MAX_LINE_BYTES;
    }
    if ended && !bytes.is_empty() {
        counts.lines += 1;
        line(bytes, counts, see);
        return bytes.len();
    }
    0
}

/// A binary message; its sync bytes are there.
fn binary(
    held: &[u8],
    at: usize,
    ended: bool,
    search: &mut Search,
    counts: &mut Counts,
    see: &mut dyn FnMut(Message),
) -> usize {
    const SYNC_BYTES: usize = 3;
    let more = |counts: &mut Counts| {
        counts.malformed += u64::from(ended);
        if ended { SYNC_BYTES } else { 0 }
    };
    let Some(frame) = novatel::Frame::of(&held[at..]) else { return more(counts) };
    let Search { sums, enclosed } = search;
    let (body, end) = (at + frame.header_bytes, at + frame.all_bytes());
    let is_long = !frame.is_read() && frame.all_bytes() > enclosed::SHORT_BYTES;
    if !frame.is_believed() || is_long && enclosed.refutes(held, body, end, sums) {
        counts.malformed += 1;
        return SYNC_BYTES;
    }
    let Some(message) = held.get(at..end) else { return more(counts) };
    if !sums.is_intact(held, at, end) {
        counts.bad_checksum += 1;
        return SYNC_BYTES;
    }
    let content = novatel::binary(&frame, message);
    if content == Err(Unread::Unknown) {
        let mut name = [b' '; KIND_LETTERS];
        // It fits.
        let _ = write!(&mut name[..], "message {}", novatel::number_of(message));
        counts.others.count(name.trim_ascii_end());
    }
    report(content, None, counts, see);
    frame.all_bytes()
}

/// A line of text without its end.
fn line(line: &[u8], counts: &mut Counts, see: &mut dyn FnMut(Message)) {
    let mut rest = line.trim_ascii();
    if rest.is_empty() {
        return;
    }
    let is_start = |byte: &u8| matches!(byte, b'$' | b'!');
    let start = rest.iter().position(is_start);
    if let Some(at) = novatel::ascii_start(&rest[..start.unwrap_or(rest.len())]) {
        match novatel::ascii(&rest[at..]) {
            None => counts.bad_checksum += 1,
            Some(content) => {
                if content == Err(Unread::Unknown) {
                    counts.others.count(rest[at + 1..].split(|b| *b == b',').next().unwrap_or_default());
                }
                report(content, None, counts, see);
            }
        }
        return;
    }
    let Some(start) = start else {
        counts.malformed += 1;
        counts.abbreviated += u64::from(novatel::is_abbreviated(rest));
        counts.begun_within |= counts.lines == 1 && ends_sentence(rest);
        return;
    };
    rest = &rest[start..];
    loop {
        let Some((body, given)) = nmea::split_checksum(rest) else {
            counts.malformed += 1;
            return;
        };
        // The end of one sentence and the beginning of another may be lost; but `$` within a sound one
        // occurs. The checksum of what is left is that of all without that of what was passed over: every
        // byte is read once.
        let mut left = nmea::checksum(body);
        let mut found = (left == given).then_some(0);
        for (at, byte) in (1..).zip(body) {
            if found.is_some() {
                break;
            }
            left ^= byte;
            found = (is_start(byte) && left == given).then_some(at);
        }
        match found.map(|at| (at, &body[at..])) {
            None => counts.bad_checksum += 1,
            Some((at, body)) => {
                counts.malformed += u64::from(at > 0);
                let content = nmea::sentence(body);
                let address = body.split(|b| *b == b',').next().unwrap_or_default();
                if content == Err(Unread::Unknown) {
                    counts.others.count(address);
                }
                let talker = address.first_chunk().copied().filter(|_| address.len() == 5);
                report(content, talker, counts, see);
            }
        }
        // Behind the checksum another sentence may follow.
        let behind = &rest[body.len() + 4..];
        match behind.iter().position(is_start) {
            Some(next) => rest = &behind[next..],
            None => return,
        }
    }
}

/// Whether a line is the end of a sentence whose beginning is missing.
fn ends_sentence(line: &[u8]) -> bool {
    matches!(line, [.., b'*', high, low] if high.is_ascii_hexdigit() && low.is_ascii_hexdigit())
}

/// Counts a message and hands it on.
fn report(
    content: Result<Content, Unread>,
    talker: Option<[u8; 2]>,
    counts: &mut Counts,
    see: &mut dyn FnMut(Message),
) {
    match content {
        Err(Unread::Unknown) => counts.unknown += 1,
        Err(Unread::Malformed) => counts.malformed += 1,
        Ok(content) => {
            counts.good += 1;
            counts.void += u64::from(content.is_void());
            see(Message { line: counts.lines, talker, begun_within: counts.begun_within, content });
        }
    }
}

impl Content {
    /// Whether this message of a position states that there is none.
    pub fn is_void(&self) -> bool {
        match self {
            Self::Gga(gga) | Self::Gns(gga) => gga.fix.is_none(),
            Self::Rmc(rmc) => rmc.fix.is_none(),
            Self::Gll(gll) => gll.fix.is_none(),
            Self::Inspvax(inspvax) | Self::Inspva(inspvax) => !inspvax.is_solution(),
            _ => false,
        }
    }
}
