//! Parameters per pulse (PPP) and per vector (PVP) as words of eight bytes, big-endian.
//!
//! Phases follow the carrier's oscillator from each emission on: `PhiX0 = f0 Tc/2` at the middle of the
//! pulse, `RefPhi0 = f0 w` where the window opens `w` after the emission, so that the sample of an echo with
//! delay `tau` has the phase `-2 pi f0 tau` of a recording.
//!
//! **Times.** CRSD wants windows of a channel on one grid of samples, and the emulator opens them anywhere.
//! Both `TxTime` and `RcvStart` of a pulse are moved onto the grid by the same time, half a sample at most,
//! so their difference is exact; what must be added to get the exact time is in the added parameter
//! `TimeOffset`.

use glam::DVec3;

use super::states::State;
use crate::time::TimeTag;

/// Name, format and words of a parameter.
pub(super) type Field = (&'static str, &'static str, usize);

const F8: &str = "F8";
const I8: &str = "I8";
const INT_FRAC: &str = "Int=I8;Frac=F8;";
const XYZ: &str = "X=F8;Y=F8;Z=F8;";
const EB: &str = "DCX=F8;DCY=F8;";

/// Parameters of a pulse; the last ones are added to those of the standard.
pub(super) const PPP: [Field; 17] = [
    ("TxTime", INT_FRAC, 2),
    ("TxPos", XYZ, 3),
    ("TxVel", XYZ, 3),
    ("FX1", F8, 1),
    ("FX2", F8, 1),
    ("TXmt", F8, 1),
    ("PhiX0", INT_FRAC, 2),
    ("FxFreq0", F8, 1),
    ("FxRate", F8, 1),
    ("TxRadInt", F8, 1),
    ("TxACX", XYZ, 3),
    ("TxACY", XYZ, 3),
    ("TxEB", EB, 2),
    ("FxResponseIndex", I8, 1),
    ("TimeOffset", F8, 1),
    ("PulseNumber", I8, 1),
    ("Flags", I8, 1),
];

/// Parameters of a vector; the last one is added to those of the standard.
pub(super) const PVP: [Field; 17] = [
    ("RcvStart", INT_FRAC, 2),
    ("RcvPos", XYZ, 3),
    ("RcvVel", XYZ, 3),
    ("FRCV1", F8, 1),
    ("FRCV2", F8, 1),
    ("RefPhi0", INT_FRAC, 2),
    ("RefFreq", F8, 1),
    ("DFIC0", F8, 1),
    ("FICRate", F8, 1),
    ("RcvACX", XYZ, 3),
    ("RcvACY", XYZ, 3),
    ("RcvEB", EB, 2),
    ("SIGNAL", I8, 1),
    ("AmpSF", F8, 1),
    ("DGRGC", F8, 1),
    ("TxPulseIndex", I8, 1),
    ("TimeOffset", F8, 1),
];

/// Parameters beyond those of the standard.
pub(super) const ADDED: [&str; 3] = ["TimeOffset", "PulseNumber", "Flags"];

/// Bytes of a record.
pub(super) fn bytes(fields: &[Field]) -> usize {
    8 * fields.iter().map(|(_, _, words)| words).sum::<usize>()
}

/// A record under way.
#[derive(Default)]
pub(super) struct Record(pub Vec<u8>);

impl Record {
    pub fn real(&mut self, value: f64) -> &mut Self {
        self.0.extend(value.to_be_bytes());
        self
    }

    pub fn whole(&mut self, value: i64) -> &mut Self {
        self.0.extend(value.to_be_bytes());
        self
    }

    pub fn vector(&mut self, value: DVec3) -> &mut Self {
        value.to_array().into_iter().fold(self, Self::real)
    }

    /// Whole seconds after a reference, and the fraction.
    pub fn time(&mut self, time: TimeTag, reference_s: i64) -> &mut Self {
        self.whole(time.seconds() - reference_s).real(time.fraction_s())
    }

    /// Cycles that an oscillator turns in a time: whole ones, and the fraction, without rounding of the
    /// product.
    pub fn cycles(&mut self, hz: f64, seconds: f64) -> &mut Self {
        let product = hz * seconds;
        let lost = hz.mul_add(seconds, -product);
        let (mut whole, mut fraction) = (product.floor(), product - product.floor() + lost);
        if fraction < 0.0 {
            (whole, fraction) = (whole - 1.0, fraction + 1.0);
        }
        // A fraction that rounds to 1.
        if fraction >= 1.0 {
            (whole, fraction) = (whole + 1.0, fraction - 1.0);
        }
        self.whole(whole as i64).real(fraction)
    }

    /// Position, velocity, and later the axes, stand apart in a record.
    pub fn motion(&mut self, state: &State) -> &mut Self {
        self.vector(state.position_m).vector(state.velocity_mps)
    }

    /// Axes, and the electrical boresight along the mechanical one.
    pub fn axes(&mut self, state: &State) -> &mut Self {
        self.vector(state.acx).vector(state.acy).real(0.0).real(0.0)
    }
}

/// A record that is read back.
pub(super) struct Known<'a> {
    pub fields: &'a [Field],
    pub bytes: Vec<u8>,
}

impl Known<'_> {
    fn word(&self, name: &str, place: usize) -> [u8; 8] {
        let before: usize =
            self.fields.iter().take_while(|(known, ..)| *known != name).map(|(.., n)| n).sum();
        let at = 8 * (before + place);
        self.bytes.get(at..at + 8).and_then(|word| word.try_into().ok()).unwrap_or_default()
    }

    pub fn vector(&self, name: &str) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| f64::from_be_bytes(self.word(name, axis))))
    }

    /// Whole seconds and fraction in one number, as a reader adds them up.
    pub fn time_s(&self, name: &str) -> f64 {
        i64::from_be_bytes(self.word(name, 0)) as f64 + f64::from_be_bytes(self.word(name, 1))
    }
}

/// The grid of samples of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Where the first window opens.
    first: TimeTag,
    rate_hz: f64,
}

/// A time that is off by less than this part of a sample is on the grid.
const ON_GRID: f64 = 1e-4;

impl Grid {
    pub fn new(first: TimeTag, rate_hz: f64) -> Self {
        Self { first, rate_hz }
    }

    /// What brings a window onto the grid, s.
    pub fn shift_s(&self, opening: TimeTag) -> f64 {
        let whole_s = (opening.seconds() - self.first.seconds()) as f64;
        let rest_s = opening.fraction_s() - self.first.fraction_s();
        let sample = ((whole_s + rest_s) * self.rate_hz).round();
        let second = (sample / self.rate_hz).floor();
        let fraction_s = second.mul_add(-self.rate_hz, sample) / self.rate_hz;
        let shift_s = (second - whole_s) + (fraction_s - rest_s);
        if (shift_s * self.rate_hz).abs() < ON_GRID { 0.0 } else { shift_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_have_the_bytes_that_were_tried() {
        // 200 and 216 bytes of the standard's own parameters, and what is added.
        assert_eq!((bytes(&PPP), bytes(&PVP)), (200 + 24, 216 + 8));
    }

    #[test]
    fn cycles_are_exact() {
        let mut record = Record::default();
        record.cycles(9.65e9, 5.123_456_789_012_345e-3);
        let known = Known { fields: &[("Phi", INT_FRAC, 2)], bytes: record.0 };
        // The product of the two doubles in 40 digits: 49441358.013969128...
        assert_eq!(i64::from_be_bytes(known.word("Phi", 0)), 49_441_358);
        let fraction = f64::from_be_bytes(known.word("Phi", 1));
        assert!((fraction - 0.013_969_13).abs() < 1e-7, "{fraction}");
        // A product that is rounded up to a whole number: the fraction stays below 1.
        let mut record = Record::default();
        record.cycles(10e9, 0.333e-6 / 2.0);
        let known = Known { fields: &[("Phi", INT_FRAC, 2)], bytes: record.0 };
        assert_eq!(i64::from_be_bytes(known.word("Phi", 0)), 1664);
        assert!((0.0..1.0).contains(&f64::from_be_bytes(known.word("Phi", 1))));
    }

    #[test]
    fn windows_are_moved_by_half_a_sample_at_most() {
        let first = TimeTag::new(1_000, 0.25);
        let grid = Grid::new(first, 100e6);
        for pulse in 0..2000 {
            let opening = first.plus(f64::from(pulse) / 222.0);
            let shift_s = grid.shift_s(opening);
            assert!(shift_s.abs() <= 0.5001e-8);
            let samples = opening.plus(shift_s).since(first) * 100e6;
            assert!((samples - samples.round()).abs() < 1e-3, "{pulse}: {samples}");
        }
        assert_eq!(grid.shift_s(first.plus(3600.0)), 0.0);
    }
}
