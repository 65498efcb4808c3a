//! What every facet contributes to the echo of one emission.

use num_complex::Complex64;

use super::{PathGenerator, Workspace};
use crate::radar::fault::RadarError;
use crate::radar::window::Window;
use crate::scene::Patch;
use crate::time::TimeTag;

/// The facets of the sea as one emission illuminates them, whatever receive windows receive of it. Arrays
/// over facets are `[iy][ix]` over the patch. A facet is illuminated when both antennas of any pair see it;
/// whether it then scatters shows in its amplitude.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// The pulse.
    pub index: u64,
    /// Its emission.
    pub time: TimeTag,
    /// Start of its window after the emission, s: that of the first pair.
    pub window_start_s: f64,
    /// The facets.
    pub patch: Patch,
    /// `[facet]`: height above the mean surface, m.
    pub height_m: Vec<f64>,
    /// `[pair][facet]`: delay, s; NaN where the facet is not illuminated.
    pub delay_s: Vec<Vec<f64>>,
    /// `[pair][facet]`: d tau / dt; NaN where the facet is not illuminated.
    pub delay_rate: Vec<Vec<f64>>,
    /// `[channel][facet]`: amplitude without carrier phase, sqrt(W); zero where the facet is not illuminated.
    pub amplitude: Vec<Vec<Complex64>>,
    /// `[pair][facet]`: whether its echo reaches into the window of this pulse, or of a later one (taken as
    /// long after that pulse as this one's window).
    pub received: Vec<Vec<bool>>,
}

impl Snapshot {
    /// Elementary contributions in a channel, dBW; NaN where the facet is not illuminated.
    pub fn power_dbw(&self, channel: usize) -> Vec<f64> {
        let dbw = |a: &Complex64| if *a == Complex64::ZERO { f64::NAN } else { 10.0 * a.norm_sqr().log10() };
        self.amplitude[channel].iter().map(dbw).collect()
    }

    /// Facets that return something in any channel, and how many of them a window receives.
    pub fn counts(&self) -> (usize, usize) {
        let returns = |facet: &usize| self.amplitude.iter().any(|channel| channel[*facet].norm_sqr() > 0.0);
        let (mut illuminated, mut received) = (0, 0);
        for facet in (0..self.patch.len()).filter(returns) {
            illuminated += 1;
            received += usize::from(self.received.iter().any(|pair| pair[facet]));
        }
        (illuminated, received)
    }

    /// Powers of the strongest facet in a channel and of all, dBW; none where nothing returns.
    pub fn levels_dbw(&self, channel: usize) -> Option<[f64; 2]> {
        let power = self.amplitude[channel].iter().map(|a| a.norm_sqr());
        let (strongest, sum) = (power.clone().fold(0.0, f64::max), power.sum());
        (strongest > 0.0).then(|| [strongest, sum].map(|power: f64| 10.0 * power.log10()))
    }

    /// Power of the received facets along the edge of the patch over that of all received facets, dB, in the
    /// worst channel: what comes and goes when the patch moves by one row. Negative infinity where nothing is
    /// received.
    ///
    /// `pair_of` is the pair of each channel; `moves`: along which axes (East, North) the patch moves at
    /// all.
    pub fn edge_db(&self, pair_of: &[usize], moves: [bool; 2]) -> f64 {
        let [nx, ny] = self.patch.facets;
        let channels = self.amplitude.iter().zip(pair_of);
        channels
            .map(|(amplitude, &pair)| {
                let (mut edge, mut all) = (0.0, 0.0);
                for (facet, a) in
                    amplitude.iter().enumerate().filter(|&(facet, _)| self.received[pair][facet])
                {
                    let (ix, iy) = (facet % nx, facet / nx);
                    all += a.norm_sqr();
                    if moves[0] && (ix == 0 || ix + 1 == nx) || moves[1] && (iy == 0 || iy + 1 == ny) {
                        edge += a.norm_sqr();
                    }
                }
                if edge > 0.0 { 10.0 * f64::log10(edge / all) } else { f64::NEG_INFINITY }
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

impl PathGenerator {
    /// Whether an echo of pulse `index` is received in a window like `window` of that pulse or a later one.
    fn received_later(&self, index: u64, window: &Window, delay_s: f64) -> bool {
        let from = self.first_emission(index, delay_s - window.close_s - window.guard_s).max(index);
        let to = self.first_emission(index, delay_s + window.pulse_s - window.open_s + window.guard_s);
        (from..=to.max(from))
            .any(|later| window.touches(delay_s - self.radar.emissions.interval_s(index, later)))
    }

    /// The facets as the emission of pulse `index` illuminates them; `None` for a scene without sea.
    ///
    /// # Errors
    /// A pulse outside of the run, or that its tracks do not cover; a sea or shadows that cannot be found at
    /// it.
    pub fn snapshot(&self, index: u64, workspace: &mut Workspace) -> Result<Option<Snapshot>, RadarError> {
        if index >= self.pulses {
            return Err(RadarError::NoSuchPulse { index, pulses: self.pulses });
        }
        let Workspace { own, sea: work, costs, .. } = workspace;
        let Some(sea) = &self.sea else { return Ok(None) };
        let Some(work) = self.sea_work(sea, work) else { return Ok(None) };
        self.evaluate(index, own)?;
        let mut windows = Vec::new();
        self.windows_at(index, &mut windows)?;
        let windows: Vec<Window> = self.plans.iter().map(|plan| windows[plan.window]).collect();
        let window_start_s = windows.first().map_or(0.0, |window| window.open_s);
        let reception = self.reception(index, index, own, &[]);
        let facets = sea.patch.len();
        let patch = sea
            .patch_at(&reception.surroundings, reception.elapsed_s)
            .map_err(|f| self.track_error(index, f))?;
        let mut snapshot = Snapshot {
            index,
            time: reception.t,
            window_start_s,
            patch,
            height_m: Vec::new(),
            delay_s: vec![vec![f64::NAN; facets]; self.pairs.len()],
            delay_rate: vec![vec![f64::NAN; facets]; self.pairs.len()],
            amplitude: vec![vec![Complex64::ZERO; facets]; self.radar.channels.len()],
            received: vec![vec![false; facets]; self.pairs.len()],
        };
        sea.visit(&reception, work, costs, |chunk| {
            for (place, &facet) in chunk.index.iter().enumerate() {
                for (pair, columns) in chunk.pairs.iter().enumerate() {
                    let delay_s = columns.delay_s[place];
                    snapshot.delay_s[pair][facet] = delay_s;
                    snapshot.delay_rate[pair][facet] = columns.delay_rate[place];
                    snapshot.received[pair][facet] = self.received_later(index, &windows[pair], delay_s);
                }
                for (column, amplitude) in snapshot.amplitude.iter_mut().zip(&chunk.amplitude) {
                    column[facet] = amplitude[place];
                }
            }
        })
        .map_err(|failure| self.sea_error(index, failure))?;
        snapshot.height_m = work.heights_m().to_vec();
        Ok(Some(snapshot))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_edges_that_move_come_and_go() {
        // 4 x 3 facets of power 1, but for those of the corners, which return nothing; one that the window
        // does not receive.
        let one = Complex64::ONE;
        let mut amplitude = vec![one; 12];
        for corner in [0, 3, 8, 11] {
            amplitude[corner] = Complex64::ZERO;
        }
        let mut received = vec![true; 12];
        received[1] = false;
        let snapshot = Snapshot {
            index: 0,
            time: TimeTag::default(),
            window_start_s: 0.0,
            patch: Patch::new([4.0, 3.0], 1.0, [0.0, 0.0]).unwrap(),
            height_m: vec![0.0; 12],
            delay_s: vec![vec![0.0; 12]],
            delay_rate: vec![vec![0.0; 12]],
            amplitude: vec![amplitude],
            received: vec![received],
        };
        // 7 are received: 2 in the outer columns, 3 in the outer rows, 2 within.
        let share = |moves: [bool; 2]| 10f64.powf(snapshot.edge_db(&[0], moves) / 10.0) * 7.0;
        assert_eq!(snapshot.edge_db(&[0], [false, false]), f64::NEG_INFINITY);
        for (moves, facets) in [([true, false], 2.0), ([false, true], 3.0), ([true, true], 5.0)] {
            assert!((share(moves) - facets).abs() < 1e-12, "{moves:?}");
        }
    }
}
