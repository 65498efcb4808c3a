//! A pulse that is being put together.

use glam::DQuat;
use num_complex::Complex32;

use crate::frames::{Body, Enu, Point, Rotation, Vector};
use crate::pulse::{PlatformRecord, Pulse, Samples};
use crate::recording::header::Header;

use super::context::State;

/// A pulse that is being put together.
#[derive(Debug)]
pub(super) struct Open {
    /// Time of the first sample.
    pub(super) first_ps: i128,
    /// That of every channel, where receivers have windows of their own and these are known.
    pub(super) firsts_ps: Vec<i128>,
    /// Whether its number is known: a state has come.
    pub(super) known: bool,
    pub(super) states: Vec<bool>,
    /// A bit for every sample, channels one after the other.
    got: Vec<u64>,
    /// Words of `got` that are not all 0 lie within: a long window is not wiped for every datagram.
    touched: std::ops::Range<usize>,
    missing: usize,
    pub(super) pulse: Box<Pulse>,
}

impl Open {
    pub(super) fn new(header: &Header) -> Self {
        let layout = &header.layout;
        let total = layout.channels * layout.samples;
        Self {
            first_ps: 0,
            firsts_ps: Vec::new(),
            known: false,
            states: vec![false; layout.platforms],
            got: vec![0; total.div_ceil(64)],
            touched: 0..0,
            missing: total,
            pulse: Box::new(Pulse::new(layout)),
        }
    }

    pub(super) fn begin(&mut self, first_ps: i128, total: usize) {
        self.first_ps = first_ps;
        self.firsts_ps.clear();
        self.known = false;
        self.states.fill(false);
        if let Some(words) = self.got.get_mut(std::mem::take(&mut self.touched)) {
            words.fill(0);
        }
        self.missing = total;
    }

    pub(super) fn has(&self, at: usize) -> bool {
        self.got.get(at / 64).is_some_and(|word| word >> (at % 64) & 1 == 1)
    }

    /// Whether states and samples have come. One that has but one kind makes no others late.
    pub(super) fn is_sound(&self) -> bool {
        self.known && !self.touched.is_empty()
    }

    pub(super) fn is_complete(&self) -> bool {
        self.missing == 0 && self.known && self.states.iter().all(|&came| came)
    }

    /// Copies the samples of a packet to `at..`; counts those that are new.
    pub(super) fn fill(&mut self, at: usize, count: usize, payload: &[u8]) {
        let words = at / 64..(at + count).div_ceil(64);
        self.touched = match self.touched.is_empty() {
            true => words,
            false => self.touched.start.min(words.start)..self.touched.end.max(words.end),
        };
        for k in at..at + count {
            if let Some(word) = self.got.get_mut(k / 64) {
                let bit = 1 << (k % 64);
                self.missing -= usize::from(*word & bit == 0);
                *word |= bit;
            }
        }
        match &mut self.pulse.samples {
            Samples::Cf32(all) => {
                for (sample, bytes) in all.iter_mut().skip(at).zip(payload.chunks_exact(8)) {
                    let part = |from: usize| {
                        bytes
                            .get(from..from + 4)
                            .and_then(|b| b.try_into().ok())
                            .map_or(0.0, f32::from_be_bytes)
                    };
                    *sample = Complex32::new(part(0), part(4));
                }
            }
            Samples::Ci16(all) => {
                for (sample, bytes) in all.iter_mut().skip(at).zip(payload.chunks_exact(4)) {
                    let part = |from: usize| {
                        bytes
                            .get(from..from + 2)
                            .and_then(|b| b.try_into().ok())
                            .map_or(0, i16::from_be_bytes)
                    };
                    *sample = [part(0), part(2)];
                }
            }
        }
    }

    /// Whether a state is of the pulse that an earlier one has named.
    pub(super) fn agrees(&self, state: &State) -> bool {
        let Pulse { index, time, window_start_s, ref receiver_window_start_s, .. } = *self.pulse;
        let named = (index, time, window_start_s.to_bits());
        let same = |(one, other): (&f64, &f64)| one.to_bits() == other.to_bits();
        let starts_s = receiver_window_start_s.iter().zip(&state.additions);
        !self.known
            || (named == (state.index, state.time(), state.window_start_s.to_bits()) && { starts_s }
                .all(same))
    }

    /// Takes a state; `arms` are platform and lever arm of every antenna, `scanning` those that scan.
    pub(super) fn state(&mut self, state: &State, arms: &[(usize, Vector<Body>)], scanning: &[usize]) {
        let pulse = &mut *self.pulse;
        if !self.known {
            pulse.index = state.index;
            pulse.time = state.time();
            pulse.window_start_s = state.window_start_s;
            let starts_s = pulse.receiver_window_start_s.iter_mut().zip(&state.additions);
            starts_s.for_each(|(to, start_s)| *to = *start_s);
            let readings = state.additions.get(pulse.receiver_window_start_s.len()..).unwrap_or_default();
            for (antenna, reading_deg) in scanning.iter().zip(readings.as_chunks::<2>().0) {
                if let Some(antenna) = pulse.antennas.get_mut(*antenna) {
                    antenna.encoder_deg = Some(*reading_deg);
                }
            }
            pulse.flags = state.flags;
            pulse.tx_pol = state.tx_pol;
            self.known = true;
        }
        let platform = state.platform[0] as usize;
        if let (Some(record), Some(came)) =
            (pulse.nav_reported.get_mut(platform), self.states.get_mut(platform))
        {
            *came = true;
            *record = PlatformRecord {
                position_m: state.position_m,
                velocity_mps: state.velocity_mps,
                attitude_quat: state.attitude_quat,
                age_s: state.age_s,
                flags: state.platform_flags,
            };
        }
        let [w, x, y, z] = state.attitude_quat;
        let attitude = Rotation::<Body, Enu>::from_raw(DQuat::from_xyzw(x, y, z, w));
        let [east_m, north_m, up_m] = state.position_m;
        for (antenna, (carrier, arm)) in pulse.antennas.iter_mut().zip(arms) {
            if *carrier == platform {
                let centre = Point::new(east_m, north_m, up_m) + attitude * *arm;
                antenna.reported_phase_centre_m = centre.to_array();
            }
        }
    }
}
