//! Frequencies that many spectra are asked at.

use num_complex::Complex64;

use super::gridded::{Gridded, Places};
use super::shaping::response;
use crate::cpu::{Task, Variant};
use crate::radar::phasor::phasor;

/// Middles of segments for which factors are kept.
const MIDDLES: usize = 16;
/// Parts of a sample to which middles are rounded, so that equal ones are: 2e-8 rad at most.
const PARTS: f64 = (1u32 << 26) as f64;

/// Frequencies at which many waveforms are read one after the other, Hz. Segments of a continuous signal find
/// once where in their transforms these lie.
#[derive(Debug, Default)]
pub struct Frequencies {
    hz: Vec<f64>,
    of_segments: Option<OfSegments>,
    /// The same less an offset, Hz.
    shifted: Option<(f64, Box<Self>)>,
}

/// Where transforms of segments are read, and what multiplies them.
#[derive(Debug)]
struct OfSegments {
    /// Of their samples.
    rate_hz: f64,
    places: Places,
    /// By the time from the emission to the sample in the middle, samples.
    factors: Vec<(f64, Vec<Complex64>)>,
}

impl Frequencies {
    /// What one of them may take, bytes: places and weights, and a factor by each middle.
    pub const BYTES: usize = 72 + MIDDLES * size_of::<Complex64>();

    /// These, Hz.
    pub fn new(hz: Vec<f64>) -> Self {
        Self { hz, ..Self::default() }
    }

    /// Hz.
    pub fn hz(&self) -> &[f64] {
        &self.hz
    }

    /// The same less an offset, Hz.
    pub(super) fn less(&mut self, offset_hz: f64) -> &mut Self {
        self.shifted.take_if(|(known_hz, _)| *known_hz != offset_hz);
        let less = || Box::new(Self::new(self.hz.iter().map(|hz| hz - offset_hz).collect()));
        &mut self.shifted.get_or_insert_with(|| (offset_hz, less())).1
    }

    /// Reads the spectrum of a segment: of a sum over samples at this rate, Hz, the middle one so many of
    /// them after the emission.
    pub(super) fn read(&mut self, (sum, rate_hz, middle): (&Gridded, f64, f64), out: &mut [Complex64]) {
        self.of_segments.take_if(|of| of.rate_hz != rate_hz || !of.places.are_of(sum));
        let middle = (middle * PARTS).round() / PARTS;
        let turns = self.hz.iter().map(|f_hz| f_hz / rate_hz);
        let OfSegments { places, factors, .. } = self.of_segments.get_or_insert_with(|| OfSegments {
            rate_hz,
            places: Places::new(sum, turns.clone()),
            factors: Vec::new(),
        });
        let known = factors.iter().position(|(of, _)| *of == middle);
        let at = known.unwrap_or_else(|| {
            if factors.len() < MIDDLES {
                factors.push((middle, Vec::new()));
            }
            // Of more, the last makes room.
            let place = factors.len() - 1;
            let factor = |v: f64| phasor(-v * middle) * (response(v)[0] / rate_hz);
            let (of, own) = &mut factors[place];
            *of = middle;
            own.clear();
            own.extend(turns.map(factor));
            place
        });
        Variant::fastest().run(Read { places, sum, factors: &factors[at].1, out });
    }
}

struct Read<'a> {
    places: &'a Places,
    sum: &'a Gridded,
    factors: &'a [Complex64],
    out: &'a mut [Complex64],
}

impl Task for Read<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.places.read(self.sum, self.factors, self.out);
    }
}
