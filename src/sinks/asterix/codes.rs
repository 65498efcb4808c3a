//! Powers of cells as codes.
//!
//! | detection | code of a power `P` |
//! | --- | --- |
//! | logarithmic | `M (1 + 10 lg(P / P_full) / D)` |
//! | linear | `M sqrt(P / P_full)` |
//!
//! rounded, and kept within 0 and `M`, the greatest code; `P_full` its power, W, and `D` what lies between it
//! and code 0, dB. A power above `P_full` is counted as clipped.

use super::{Bits, Detection};

/// Turns powers into codes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coder {
    detection: Detection,
    /// The greatest code.
    most: f32,
    full_w: f32,
    /// Codes in a decibel.
    per_db: f32,
}

impl Coder {
    pub(super) fn new(detection: Detection, bits: Bits, full_dbw: f64) -> Self {
        let most = f32::from(bits.most());
        let per_db = match detection {
            Detection::Logarithmic { dynamic_db } => most / dynamic_db as f32,
            Detection::Linear => 0.0,
        };
        Self { detection, most, full_w: 10f64.powf(full_dbw / 10.0) as f32, per_db }
    }

    /// The code of a power, W, and whether that is more than a code can say.
    pub(super) fn code(&self, power_w: f32) -> (u16, bool) {
        let ratio = power_w / self.full_w;
        let code = match self.detection {
            Detection::Logarithmic { .. } => self.most + 10.0 * self.per_db * ratio.log10(),
            Detection::Linear => self.most * ratio.sqrt(),
        };
        // As a cast has it: below 0, and of no number, 0.
        (code.round().min(self.most) as u16, ratio > 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_those_of_the_table() {
        let log = Detection::Logarithmic { dynamic_db: 80.0 };
        let coder = Coder::new(log, Bits::Eight, -60.0);
        // 80 dB over 255 codes; half of that is 127.5.
        for (dbw, code) in [(-60.0, 255), (-140.0, 0), (-100.5, 126), (-200.0, 0), (-50.0, 255)] {
            assert_eq!(coder.code(10f32.powf(dbw / 10.0)), (code, dbw > -60.0), "{dbw} dBW");
        }
        assert_eq!(coder.code(0.0), (0, false));
        let coder = Coder::new(Detection::Linear, Bits::Sixteen, -60.0);
        for (dbw, code) in [(-60.0, 65_535), (-80.0, 6554), (-120.0, 66), (-59.0, 65_535)] {
            assert_eq!(coder.code(10f32.powf(dbw / 10.0)), (code, dbw > -60.0), "{dbw} dBW");
        }
    }
}
