//! What the pulses of a block have in common, and which of them receive which emissions.
//!
//! Scatterer paths are functions of the emission, grids are those of a pulse. Where a window holds more than
//! its own emission, emission `m` is spread on the grids of every pulse `n` that receives it, with its own
//! phase, amplitude and polarisation, `t_m - t_n` later than its delay says: whole cells and a rest, as
//! windows are displaced from pulse to pulse.

use std::ops::Range;

use num_complex::Complex64;

use super::Synth;
use super::grid::FAR_CELLS;
use super::scalar::Scalar;
use super::spread::Emitted;
use crate::echo::reference::of_window;
use crate::paths::block::SlowTime;

/// A pulse that receives an emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receives {
    /// Emission, from the first that is at hand.
    pub emission: usize,
    /// Pulse of the block.
    pub pulse: usize,
    /// From the emission of the pulse to this one, s.
    pub offset_s: f64,
}

impl Receives {
    /// When its window opens after the emission, s, by the windows of all pulses; none of an unknown pulse.
    pub(super) fn opens_s(&self, windows_s: &[f64]) -> Option<f64> {
        windows_s.get(self.pulse).map(|opens_s| opens_s - self.offset_s)
    }
}

/// What the pulses of a block have in common, whatever its scatterer paths, and the emissions at hand.
#[derive(Debug, Default)]
pub struct Frame {
    /// First sample of each pulse's windows, `[window][pulse]`: one for all pairs, or several.
    pub(super) windows_s: Vec<Vec<f64>>,
    /// `[layer][bin]`: from grid to spectrum.
    pub(super) replicas: Vec<Vec<Complex64>>,
    /// `[pair]`: mean Doppler `f0 r`, Hz.
    pub(super) mean_hz: Vec<f64>,
    /// When the emissions are.
    pub slow: SlowTime,
    /// By how much a carrier apart from the receiver's turns the first emission, and from one to the next,
    /// turns; 0 where intervals differ.
    pub carrier_turns: [f64; 2],
    /// The same of every emission, where intervals differ; empty where nothing turns them.
    pub emission_turns: Vec<f64>,
    /// Group of channels that each emission fills; empty where every one fills all.
    pub groups: Vec<u8>,
    /// Who receives them, emission by emission; empty where every pulse receives its own alone.
    pub receives: Vec<Receives>,
    /// Groups that each pulse fills, a bit for each; empty where every pulse fills all channels.
    filled: Vec<u64>,
}

impl Clone for Frame {
    fn clone(&self) -> Self {
        let mut own = Self::default();
        own.clone_from(self);
        own
    }

    /// Without allocating where there is room: exact pulses copy a frame for each of them.
    fn clone_from(&mut self, from: &Self) {
        let Self {
            windows_s,
            replicas,
            mean_hz,
            slow,
            carrier_turns,
            emission_turns,
            groups,
            receives,
            filled,
        } = from;
        self.windows_s.clone_from(windows_s);
        self.slow.clone_from(slow);
        self.carrier_turns = *carrier_turns;
        self.emission_turns.clone_from(emission_turns);
        self.groups.clone_from(groups);
        self.receives.clone_from(receives);
        self.filled.clone_from(filled);
        self.replicas.clone_from(replicas);
        self.mean_hz.clone_from(mean_hz);
    }
}

fn bit(group: u8) -> u64 {
    1 << (group % 64)
}

impl Frame {
    pub(super) fn with_room(pulses: usize, pairs: usize, layers: usize) -> Self {
        Self {
            windows_s: vec![Vec::with_capacity(pulses)],
            replicas: vec![Vec::new(); layers],
            mean_hz: vec![0.0; pairs],
            ..Self::default()
        }
    }

    /// Pulses of the block.
    pub fn pulses(&self) -> usize {
        self.windows_s.first().map_or(0, Vec::len)
    }

    /// Mean Doppler of each pair, Hz.
    pub fn mean_hz(&self) -> &[f64] {
        &self.mean_hz
    }

    /// Turns of the carrier so many mean intervals after the first emission.
    pub(super) fn turns_at(&self, slow: f64) -> f64 {
        self.carrier_turns[0] + self.carrier_turns[1] * slow
    }

    /// Other windows.
    pub(super) fn set_windows<W: AsRef<[f64]>>(&mut self, windows_s: &[W]) {
        self.windows_s.resize_with(windows_s.len(), Vec::new);
        for (own, given) in self.windows_s.iter_mut().zip(windows_s) {
            own.clear();
            own.extend_from_slice(given.as_ref());
        }
    }

    /// Every pulse receives its own emission alone, in all channels, at equal intervals, by its own carrier.
    pub(super) fn level(&mut self) {
        self.slow.level();
        self.carrier_turns = [0.0; 2];
        self.emission_turns.clear();
        self.groups.clear();
        self.receives.clear();
        self.filled.clear();
    }

    /// Pulses fill channels of these groups; none: all.
    pub fn fill_own(&mut self, groups: &[u8]) {
        self.filled.clear();
        self.filled.extend(groups.iter().map(|group| bit(*group)));
    }

    /// And those of the emissions at hand that they receive.
    pub fn fill_received(&mut self) {
        for Receives { emission, pulse, .. } in &self.receives {
            if let (Some(own), Some(group)) = (self.filled.get_mut(*pulse), self.groups.get(*emission)) {
                *own |= bit(*group);
            }
        }
    }

    /// Whether a pulse fills channels of a group.
    pub(super) fn fills(&self, pulse: usize, group: u8) -> bool {
        self.filled.get(pulse).is_none_or(|own| own & bit(group) != 0)
    }

    /// Start of a window after its emission from which places count, s: of one in the middle of those that
    /// receive some of the emissions.
    pub(super) fn reference_s(&self, windows_s: &[f64], emissions: Range<usize>) -> f64 {
        let middle = self.received(emissions.clone()).len() / 2;
        let opens_s = |own: Receives| own.opens_s(windows_s);
        let first = || self.received(emissions.clone()).find_map(opens_s);
        self.received(emissions.clone()).skip(middle).find_map(opens_s).or_else(first).unwrap_or(0.0)
    }

    /// Who receives some of the emissions.
    pub(super) fn received(&self, emissions: Range<usize>) -> impl ExactSizeIterator<Item = Receives> {
        let at = |emission: usize| self.receives.partition_point(|own| own.emission < emission);
        let alone = self.receives.is_empty();
        let range = if alone { emissions } else { at(emissions.start)..at(emissions.end) };
        range.map(move |n| match self.receives.get(n) {
            Some(own) if !alone => *own,
            _ => Receives { emission: n, pulse: n, offset_s: 0.0 },
        })
    }
}

impl<T: Scalar> Synth<T> {
    /// Windows of a pair, pulse by pulse.
    pub(super) fn windows_of<'a>(&self, frame: &'a Frame, pair: usize) -> &'a [f64] {
        of_window(&frame.windows_s, &self.windows, pair).map_or(&[], Vec::as_slice)
    }

    /// Where and when some of the emissions at hand are spread, `time` (by their number among these) from the
    /// instants from which phases and amplitudes count: those of a group together, and of these those that
    /// are received as many pulses later, so that neighbours go to grids of their own; by windows that are
    /// one of those of the frame. Returns the start of a window after its emission that all places count
    /// from, s.
    pub(super) fn fill_emitted(
        &self,
        (frame, windows_s): (&Frame, &[f64]),
        emissions: Range<usize>,
        time: impl Fn(usize) -> [f64; 2],
        emitted: &mut Vec<Emitted<T>>,
    ) -> f64 {
        emitted.clear();
        let reference_s = frame.reference_s(windows_s, emissions.clone());
        let uneven = !frame.slow.uneven().is_empty();
        emitted.extend(frame.received(emissions.clone()).filter_map(|own| {
            let cells = (reference_s - own.opens_s(windows_s)?) * self.cells_per_s;
            let cells = cells.clamp(-FAR_CELLS, FAR_CELLS);
            let whole = cells.round();
            let shift = (whole as i32, T::round_from(cells - whole));
            let row = own.emission - emissions.start;
            let turns =
                frame.emission_turns.get(own.emission).map_or_else(T::Turns::default, |n| T::turns(*n));
            Some(Emitted { turns, ..Emitted::new(shift, time(row), (row, own.pulse), uneven) })
        }));
        let groups = frame.groups.get(emissions.clone()).unwrap_or_default();
        if !(groups.is_empty() && frame.receives.is_empty()) {
            let later = |own: &Emitted<T>| own.grid.wrapping_sub(emissions.start + own.row) as isize;
            emitted.sort_unstable_by_key(|own| (groups.get(own.row), later(own), own.row));
        }
        reference_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_fill_what_they_receive() {
        let mut frame = Frame { windows_s: vec![vec![0.0; 2]], ..Frame::default() };
        assert!(frame.fills(0, 3) && frame.fills(1, u8::MAX));
        frame.fill_own(&[0, 1]);
        assert!(frame.fills(0, 0) && !frame.fills(0, 1) && !frame.fills(1, 0) && frame.fills(1, 1));
        // Emission 1 is that of the first pulse, and the second receives it as well.
        frame.groups = vec![1, 0];
        let hears = |emission, pulse| Receives { emission, pulse, offset_s: 0.0 };
        frame.receives = vec![hears(0, 0), hears(1, 0), hears(1, 1)];
        frame.fill_received();
        assert!([0, 1].iter().all(|pulse| frame.fills(*pulse, 0) && frame.fills(*pulse, 1)));
        assert_eq!(frame.received(1..2).map(|own| own.pulse).collect::<Vec<_>>(), [0, 1]);
        frame.level();
        assert_eq!(frame.received(0..2).map(|own| own.pulse).collect::<Vec<_>>(), [0, 1]);
    }
}
