//! Data blocks of category 240, byte by byte.
//!
//! A message is one data block of one record: category, length, field specification, items in the order of
//! the user application profile (010, 000, 020, 030, 040, 041, 048, 049, 050, 051, 052, 140).

use super::{Bits, CellTime, Source};
use crate::time::TimeTag;

/// The category.
const CATEGORY: u8 = 240;
/// Message types of item 000.
const SUMMARY: u8 = 1;
const VIDEO: u8 = 2;
/// Field specification of a summary: 010, 000, 030; 140.
const SUMMARY_ITEMS: [u8; 2] = [0xD1, 0x08];
/// That of a video message but for the items of which it has one of several: 010, 000, 020, 048; 049, 140.
const VIDEO_ITEMS: [u8; 2] = [0xE3, 0x88];
/// Bits of items 040 and 041 in its first octet.
const NANO: u8 = 0x08;
const FEMTO: u8 = 0x04;
/// What a video message has beside its cells, bytes.
const BESIDE_CELLS: usize = 3 + 2 + 2 + 1 + 4 + 12 + 2 + 5 + 1 + 3;
/// Longest text of a summary: its length is an octet.
pub(super) const MOST_TEXT: usize = 255;
/// Ticks of item 140 in a second, and seconds in a day.
const TICKS_PER_S: i64 = 128;
const DAY_S: i64 = 86_400;

/// One of the three items that hold cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Volume {
    /// Its bit in the second octet of the field specification.
    bit: u8,
    /// Octets that are repeated.
    octets: usize,
    /// Most repetitions: of 052 fewer than its counter has, so that it stays below 64 kbytes.
    most: usize,
}

/// Items 050, 051 and 052.
const VOLUMES: [Volume; 3] = [
    Volume { bit: 0x40, octets: 4, most: 255 },
    Volume { bit: 0x20, octets: 64, most: 255 },
    Volume { bit: 0x10, octets: 256, most: 254 },
];

impl Volume {
    /// The first in which so many octets have room.
    fn of(octets: usize) -> Self {
        let fits = |volume: &&Self| octets <= volume.octets * volume.most;
        *VOLUMES.iter().find(fits).unwrap_or(&VOLUMES[2])
    }
}

/// Most octets of cells in a message of so many bytes.
pub(super) fn most_octets(message_bytes: usize) -> usize {
    let room = message_bytes.saturating_sub(BESIDE_CELLS);
    // What fits into a smaller item is sent in it: of the room that the larger one leaves nothing is counted.
    let fit = |volume: &Volume| (room / volume.octets).min(volume.most) * volume.octets;
    VOLUMES.iter().map(fit).max().unwrap_or(0)
}

/// A group of cells that follow each other in range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cells<'a> {
    /// Number of the message.
    pub(super) index: u32,
    /// When the first pulse was emitted.
    pub(super) time: TimeTag,
    /// Azimuths of its edges, clockwise, degrees.
    pub(super) azimuths_deg: [f64; 2],
    /// Range of the first cell, in cells.
    pub(super) first: u32,
    /// Codes.
    pub(super) codes: &'a [u16],
}

/// Writes messages into one buffer.
#[derive(Debug)]
pub(super) struct Writer {
    source: Source,
    bits: Bits,
    cell: CellTime,
    block: Vec<u8>,
}

impl Writer {
    pub(super) fn new(source: Source, bits: Bits, cell: CellTime, message_bytes: usize) -> Self {
        Self { source, bits, cell, block: Vec::with_capacity(message_bytes) }
    }

    /// A summary of the stream; of a text that is too long its beginning.
    pub(super) fn summary(&mut self, text: &str, time: TimeTag) -> &[u8] {
        let plain = text.bytes().filter(u8::is_ascii).take(MOST_TEXT);
        self.begin(SUMMARY_ITEMS, SUMMARY);
        let at = self.block.len();
        self.block.push(0);
        self.block.extend(plain);
        self.block[at] = (self.block.len() - at - 1) as u8;
        self.end(time)
    }

    /// A video message.
    pub(super) fn video(&mut self, cells: &Cells<'_>) -> &[u8] {
        let octets = cells.codes.len() * self.bits.octets();
        let volume = Volume::of(octets);
        let (header, cell) = match self.cell {
            CellTime::Nano(ns) => (NANO, ns),
            CellTime::Femto(fs) => (FEMTO, fs),
        };
        self.begin([VIDEO_ITEMS[0] | header, VIDEO_ITEMS[1] | volume.bit], VIDEO);
        let block = &mut self.block;
        block.extend(cells.index.to_be_bytes());
        for azimuth_deg in cells.azimuths_deg {
            block.extend(azimuth(azimuth_deg).to_be_bytes());
        }
        block.extend(cells.first.to_be_bytes());
        block.extend(cell.to_be_bytes());
        // Not compressed, and the bits of a cell.
        block.extend([0, self.bits.resolution()]);
        block.extend((octets as u16).to_be_bytes());
        block.extend(&(cells.codes.len() as u32).to_be_bytes()[1..]);
        let repeated = octets.div_ceil(volume.octets);
        block.push(repeated as u8);
        let begin = block.len();
        match self.bits {
            Bits::Eight => block.extend(cells.codes.iter().map(|code| *code as u8)),
            Bits::Sixteen => block.extend(cells.codes.iter().flat_map(|code| code.to_be_bytes())),
        }
        block.resize(begin + repeated * volume.octets, 0);
        self.end(cells.time)
    }

    fn begin(&mut self, items: [u8; 2], kind: u8) {
        self.block.clear();
        self.block.extend([CATEGORY, 0, 0]);
        self.block.extend(items);
        self.block.extend([self.source.sac, self.source.sic, kind]);
    }

    /// Time of day, and the length.
    fn end(&mut self, time: TimeTag) -> &[u8] {
        self.block.extend(&ticks(time).to_be_bytes()[1..]);
        let length = self.block.len() as u16;
        self.block[1..3].copy_from_slice(&length.to_be_bytes());
        &self.block
    }
}

/// An azimuth in 1/65536 of a turn.
fn azimuth(deg: f64) -> u16 {
    (deg.rem_euclid(360.0) / 360.0 * 65_536.0).round() as u32 as u16
}

/// Time since midnight, 1/128 s.
fn ticks(time: TimeTag) -> u32 {
    let within = (time.fraction_s() * TICKS_PER_S as f64).floor() as i64;
    (time.seconds().rem_euclid(DAY_S) * TICKS_PER_S + within) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_has_no_more_bytes_than_it_may() {
        for bytes in [548, 1472, 1452, 8972, 65_507] {
            let most = most_octets(bytes);
            let mut writer = Writer::new(Source::default(), Bits::Eight, CellTime::Femto(1), bytes);
            for count in [1, 4, 5, 1020, 1021, most - 1, most] {
                let codes = vec![7; count.min(most)];
                let cells = Cells {
                    index: 0,
                    time: TimeTag::default(),
                    azimuths_deg: [0.0; 2],
                    first: 0,
                    codes: &codes,
                };
                let block = writer.video(&cells);
                assert!(block.len() <= bytes, "{count} cells in {bytes}: {}", block.len());
                assert_eq!(usize::from(block[1]) << 8 | usize::from(block[2]), block.len());
            }
        }
        assert_eq!(most_octets(65_507), 65_024);
    }

    #[test]
    fn angles_and_times_turn_over() {
        assert_eq!([0.0, 359.999, 360.0, -90.0, 450.0].map(azimuth), [0, 0, 0, 49_152, 16_384]);
        // 13:00:00.5 of some day, and the last tick of one.
        assert_eq!(ticks(TimeTag::new(946_684_800 + 46_800, 0.5)), 46_800 * 128 + 64);
        assert_eq!(ticks(TimeTag::new(946_684_799, 0.999)), 11_059_199);
    }
}
