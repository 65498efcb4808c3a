//! Messages that stand within a longer one that is announced.
//!
//! 28 bytes of garbage may announce 16 KiB, which take a slow line minutes. What stands meanwhile on lines of
//! its own with a right checksum, or is a message of NovAtel that is read with a right CRC, shows that there
//! is no such message: two sentences do, or one message with a CRC of 32 bits. Messages that carry the text
//! of another port hold 80 bytes of it, less than that.
//!
//! Every byte is looked at once, however many messages seem to begin before it.

use std::collections::VecDeque;

use super::{nmea, novatel};

/// Announced messages up to this length are waited for, bytes.
pub(super) const SHORT_BYTES: usize = 256;
/// What refutes an announced message.
const REFUTED: u32 = 2;
/// The longest line that counts, bytes.
const LINE_BYTES: usize = 1024;

/// What was found so far.
#[derive(Clone, Debug)]
pub(super) struct Enclosed {
    /// Up to where it was searched.
    searched: usize,
    /// Beginning, end, and what it counts.
    found: VecDeque<(usize, usize, u32)>,
}

/// What stands at a place.
enum Found {
    /// Nothing; search on so many bytes later.
    Nothing(usize),
    /// A message of so many bytes.
    Message(usize, u32),
    /// It depends on bytes to come.
    More,
}

impl Enclosed {
    /// With room for all that can be found: nothing is allocated later.
    pub fn with_capacity() -> Self {
        // The shortest that counts is a sentence of ten bytes and the end of its line.
        Self { searched: 0, found: VecDeque::with_capacity(super::HELD_BYTES / 10) }
    }

    /// Whether what stands at `from..to` of the bytes held refutes that this is one message.
    pub fn refutes(&mut self, held: &[u8], from: usize, to: usize, sums: &mut novatel::Sums) -> bool {
        self.searched = self.searched.max(from);
        // It ends where the answer is known, so that what is known later does not depend on how much had
        // come.
        if self.has_refuted(from, to) {
            return true;
        }
        while self.searched < held.len().min(to) {
            match at(held, self.searched, sums) {
                Found::More => return false,
                Found::Nothing(bytes) => self.searched += bytes,
                Found::Message(bytes, counts) => {
                    self.found.push_back((self.searched, self.searched + bytes, counts));
                    self.searched += bytes;
                    if self.has_refuted(from, to) {
                        return true;
                    }
                }
            }
        }
        false
    }

    fn has_refuted(&self, from: usize, to: usize) -> bool {
        let within = self.found.iter().filter(|(begin, end, _)| *begin >= from && *end <= to);
        within.map(|(_, _, counts)| counts).sum::<u32>() >= REFUTED
    }

    /// So many bytes are gone from the front of what is held.
    pub fn taken(&mut self, bytes: usize) {
        self.searched = self.searched.saturating_sub(bytes);
        self.found.retain_mut(|(begin, end, _)| {
            let stays = *begin >= bytes;
            if stays {
                (*begin, *end) = (*begin - bytes, *end - bytes);
            }
            stays
        });
    }
}

fn at(held: &[u8], at: usize, sums: &mut novatel::Sums) -> Found {
    let bytes = &held[at..];
    match bytes[0] {
        0xAA => binary(held, at, sums),
        b'$' | b'!' | b'#' | b'%' if at > 0 && matches!(held[at - 1], b'\r' | b'\n') => {
            let window = &bytes[..bytes.len().min(LINE_BYTES)];
            let length = window.iter().take_while(|byte| matches!(byte, 0x20..=0x7E)).count();
            match window.get(length) {
                None if window.len() < LINE_BYTES => Found::More,
                Some(b'\r' | b'\n') => line(&window[..length]),
                _ => Found::Nothing(length.max(1)),
            }
        }
        _ => Found::Nothing(1),
    }
}

fn line(line: &[u8]) -> Found {
    let counts = if matches!(line[0], b'#' | b'%') {
        if novatel::ascii(line).is_some() { REFUTED } else { 0 }
    } else {
        match nmea::split_checksum(line) {
            Some((body, given)) => u32::from(body.len() > 5 && nmea::checksum(body) == given),
            None => 0,
        }
    };
    if counts > 0 { Found::Message(line.len(), counts) } else { Found::Nothing(line.len()) }
}

fn binary(held: &[u8], at: usize, sums: &mut novatel::Sums) -> Found {
    match super::sync(&held[at..]) {
        Some(false) => return Found::Nothing(1),
        None => return Found::More,
        Some(true) => {}
    }
    let Some(frame) = novatel::Frame::of(&held[at..]) else { return Found::More };
    if !(frame.is_read() && frame.is_believed()) {
        return Found::Nothing(1);
    }
    if held.len() < at + frame.all_bytes() {
        return Found::More;
    }
    if sums.is_intact(held, at, at + frame.all_bytes()) {
        Found::Message(frame.all_bytes(), REFUTED)
    } else {
        Found::Nothing(1)
    }
}
