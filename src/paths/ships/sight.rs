//! What of a ship antennas see, at knots of the run.
//!
//! Knots are [`EVERY_S`] apart. Antennas are taken straight on from the knot before (live navigation knows
//! nothing later), so what is seen at a knot depends on nothing but the tracks up to the one before, and joins
//! there. Every knot is found once, and the last ones are kept: a bit for each antenna and element.

use std::sync::Arc;

use super::EVERY_S;
use super::body::Body;
use crate::frames::SceneFrame;
use crate::motion::pointing::PhaseCentre;
use crate::paths::kept::Kept;

/// What antennas see: bits, `[antenna][element]`.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    words: usize,
    bits: Box<[u64]>,
}

impl Seen {
    /// Whether an antenna sees an element.
    pub fn has(&self, antenna: usize, element: usize) -> bool {
        self.bits.get(antenna * self.words + element / 64).is_some_and(|word| word >> (element % 64) & 1 == 1)
    }
}

/// What antennas see at the knots of a run.
#[derive(Debug, Default)]
pub(super) struct Knots {
    antennas: usize,
    /// They come first.
    transmitters: usize,
    kept: Kept<Seen>,
}

impl Knots {
    pub fn new([transmitters, receivers]: [usize; 2]) -> Self {
        Self { antennas: transmitters + receivers, transmitters, kept: Kept::default() }
    }

    /// The same knots, with nothing known.
    pub fn renewed(&self) -> Self {
        Self { kept: Kept::default(), ..*self }
    }

    /// What is seen at the knots about a time, and how far it is from the first to the second.
    pub fn about<E>(
        &self,
        bodies: &[Body],
        frame: &SceneFrame,
        elapsed_s: f64,
        centre: impl Fn(usize, f64) -> Result<PhaseCentre, E>,
    ) -> Result<([Arc<Seen>; 2], f64), E> {
        let at = (elapsed_s / EVERY_S).max(0.0);
        // Runs are shorter than 2^53 knots.
        let number = at.floor() as u64;
        let [before, after] = [number, number + 1].map(|number| self.knot(number, bodies, frame, &centre));
        Ok(([before?, after?], at.fract()))
    }

    fn knot<E>(
        &self,
        number: u64,
        bodies: &[Body],
        frame: &SceneFrame,
        centre: impl Fn(usize, f64) -> Result<PhaseCentre, E>,
    ) -> Result<Arc<Seen>, E> {
        let time_s = number as f64 * EVERY_S;
        let known_s = number.saturating_sub(1) as f64 * EVERY_S;
        let mut places_m = Vec::with_capacity(self.antennas);
        for antenna in 0..self.antennas {
            let PhaseCentre { position, velocity, .. } = centre(antenna, known_s)?;
            places_m.push((position + velocity * (time_s - known_s)).raw());
        }
        Ok(self.kept.get(number, || {
            let elements: usize = bodies.iter().map(|body| body.elements().len()).sum();
            let words = elements.div_ceil(64);
            let mut bits = vec![0u64; words * self.antennas].into_boxed_slice();
            let mut element = 0;
            for body in bodies {
                let pose = body.sailing().pose(frame, time_s);
                let from_m: Vec<_> = places_m
                    .iter()
                    .map(|place_m| pose.axes.transpose() * (*place_m - pose.origin_m))
                    .collect();
                for own in body.elements() {
                    for (antenna, from_m) in from_m.iter().enumerate() {
                        if body.sees(own, *from_m, antenna < self.transmitters) {
                            bits[antenna * words + element / 64] |= 1 << (element % 64);
                        }
                    }
                    element += 1;
                }
            }
            Seen { words, bits }
        }))
    }
}
