//! What of a ship antennas see past the ship itself and land, at time samples of the run.
//!
//! Time samples are [`EVERY_S`] apart. Antennas are taken straight on from the time sample before (live
//! navigation knows nothing later), so what is seen at a time sample depends on nothing but the tracks up to
//! the one before, and joins there. Every time sample is found once, and the last ones are kept: a bit for
//! each antenna and element.

use glam::DVec3;

use super::EVERY_S;
use super::body::Body;
use crate::frames::SceneFrame;
use crate::motion::pointing::PhaseCentre;
use crate::paths::hidden::{Hills, Skyline};
use crate::paths::kept::Kept;

/// Knots that are kept: those of 16 s.
const KEPT: usize = 64;

/// What antennas see: bits, `[antenna][element]`.
#[derive(Debug)]
pub(super) struct Seen {
    words: usize,
    bits: Box<[u64]>,
    /// Where antennas are, in the scene and in the axes of a ship, with the land between.
    places_m: Vec<DVec3>,
    from_m: Vec<(DVec3, Option<Skyline>)>,
}

impl Seen {
    fn new(antennas: usize, elements: usize) -> Self {
        let words = elements.div_ceil(64);
        let (places_m, from_m) = (Vec::with_capacity(antennas), Vec::with_capacity(antennas));
        Self { words, bits: vec![0; words * antennas].into(), places_m, from_m }
    }

    /// Bits of the elements that an antenna sees.
    pub fn words(&self, antenna: usize) -> &[u64] {
        self.bits.get(antenna * self.words..(antenna + 1) * self.words).unwrap_or_default()
    }

    /// Whether an antenna sees an element.
    pub fn has(&self, antenna: usize, element: usize) -> bool {
        self.bits.get(antenna * self.words + element / 64).is_some_and(|word| word >> (element % 64) & 1 == 1)
    }
}

/// What antennas see at the time samples of a run.
#[derive(Debug)]
pub(super) struct Knots {
    antennas: usize,
    /// They come first.
    transmitters: usize,
    elements: usize,
    kept: Kept<i64, Seen>,
}

impl Knots {
    /// Of so many transmitters and receivers, and elements of all ships.
    pub fn new([transmitters, receivers]: [usize; 2], elements: usize) -> Self {
        let antennas = transmitters + receivers;
        Self { antennas, transmitters, elements, kept: Self::nothing(antennas, elements) }
    }

    fn nothing(antennas: usize, elements: usize) -> Kept<i64, Seen> {
        Kept::new(if elements > 0 { KEPT } else { 0 }, || Seen::new(antennas, elements))
    }

    /// The same time samples, with nothing known.
    pub fn renewed(&self) -> Self {
        Self { kept: Self::nothing(self.antennas, self.elements), ..*self }
    }

    /// The time sample before a time after pulse 0, and how far it is from there to the next.
    pub fn before(elapsed_s: f64) -> (i64, f64) {
        let at = (elapsed_s / EVERY_S).max(0.0);
        // Runs are shorter than 2^53 time samples.
        (at.floor() as i64, at.fract())
    }

    /// Hands over what is seen at a time sample; `centre` is where an antenna is at a time after pulse 0.
    ///
    /// # Errors
    /// Those of `centre`.
    pub fn at<E>(
        &self,
        number: i64,
        bodies: &[Body],
        (frame, hills): (&SceneFrame, Option<&Hills>),
        centre: impl Fn(usize, f64) -> Result<PhaseCentre, E>,
        each: impl FnOnce(&Seen),
    ) -> Result<(), E> {
        let time_s = number as f64 * EVERY_S;
        let known_s = (number - 1).max(0) as f64 * EVERY_S;
        let find = |Seen { words, bits, places_m, from_m }: &mut Seen| {
            places_m.clear();
            for antenna in 0..self.antennas {
                let PhaseCentre { position, velocity, .. } = centre(antenna, known_s)?;
                places_m.push((position + velocity * (time_s - known_s)).raw());
            }
            bits.fill(0);
            let mut element = 0;
            for body in bodies {
                let pose = body.sailing().pose(frame, time_s);
                let scene_m = |own_m: DVec3| pose.origin_m + pose.axes * own_m;
                from_m.clear();
                from_m.extend(places_m.iter().map(|place_m| {
                    let skyline = hills.and_then(|hills| hills.along(body.ends_m(), scene_m, *place_m));
                    (pose.axes.transpose() * (*place_m - pose.origin_m), skyline)
                }));
                for own in body.elements() {
                    for (antenna, (from_m, skyline)) in from_m.iter().enumerate() {
                        let sends = antenna < self.transmitters;
                        let passes = |skyline: &Skyline| {
                            let at_m = body.at_m(own, sends);
                            skyline.passes(at_m.x, scene_m(at_m).z)
                        };
                        if skyline.as_ref().is_none_or(passes) && body.sees(own, *from_m, sends) {
                            bits[antenna * *words + element / 64] |= 1 << (element % 64);
                        }
                    }
                    element += 1;
                }
            }
            Ok(())
        };
        self.kept.with(number, find, each)
    }
}
