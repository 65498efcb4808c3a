//! The fast way: runs of pixels, delay and phase as cubics, samples in f32.
//!
//! For a pulse and a run of up to 32 pixels along x, the delay of the run's middle and its first three
//! derivatives along the run come from f64; phase then goes in whole steps of `2^-32` turn (no rounding
//! grows), the cell in f32. Left out:
//!
//! * the fourth derivative of the range, at most `3/R^3` a leg: `h^4/(8 R^3)` for half a run `h`. Runs are
//!   32, 16, 8 or 1 pixels, the longest for which that stays below 5e-5 turns, 3e-4 rad (`MOST_TURNS`);
//! * the receiver's path while echoes of the image arrive (microseconds) is straight: `v^2 dt^2/2R`, 4e-9 m
//!   for 10 us in orbit;
//! * linear interpolation between cells:
//!   [`interpolation_error_db`](crate::processor::range_compress::interpolation_error_db), which dominates
//!   the rest;
//! * f32: cells are counted from a whole one near the middle of the run, so its place in the window costs
//!   nothing: `2^-24` of the cells that a run spans, a few hundred. Sums of hundreds of pulses: -120 dB of
//!   the largest term.
//!
//! Pulses are compressed up to 64 at a time, and fewer where their cells would take more than 256 MiB.
//!
//! Through a [gate](super::Gate) the place in the band is a quadratic along the run; runs outside the band
//! are passed over.
//!
//! Tiles are shared out to the threads of the pool in use; every pixel adds its pulses in their order, so the
//! image is the same for any number of threads.

use glam::DVec3;
use num_complex::Complex32;
use rayon::prelude::*;

use super::Aperture;
use super::gate::{Table, closing};
use crate::cpu::{Task, Variant};
use crate::geometry::phase_path::delay_s;
use crate::recording::ground::Ground;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Most pulses that are compressed at a time.
const MOST_AT_A_TIME: usize = 64;
/// Memory of the cells of compressed pulses, bytes; one pulse may take more.
const MOST_CELL_BYTES: usize = 256 << 20;
/// Beyond so many cells from a run's middle, or from the window's start, nothing is received: whole numbers
/// then fit i32 in any sum of two.
const FAR_CELLS: i32 = 1 << 29;
/// Pixels of a tile along x and y.
const TILE: [usize; 2] = [64, 16];
/// Longest run of pixels.
const LONGEST: usize = 32;
/// Phase that cubics may miss, turns.
const MOST_TURNS: f64 = 5e-5;
const C: f64 = SPEED_OF_LIGHT_MPS;

/// Where a pulse was sent from and received, as one image needs it.
#[derive(Clone, Copy)]
struct Sight {
    from: DVec3,
    from_mps: DVec3,
    /// Receiver when the echo of the middle of the image arrives.
    to: DVec3,
    to_mps: DVec3,
    /// That delay, s.
    middle_s: f64,
    window_start_s: f64,
    /// Doppler of the aim, Hz; not used without a gate.
    aim_hz: f64,
}

/// One tile of one image.
#[derive(Clone, Copy)]
struct Tile {
    ground: usize,
    first: [usize; 2],
    size: [usize; 2],
}

/// The images of several grounds; `done` is called with the pulses that are in. Compression is shared.
pub fn fast(aperture: &Aperture, grounds: &[Ground], done: &(dyn Fn(usize) + Sync)) -> Vec<Vec<Complex32>> {
    in_batches(aperture, grounds, done, batch(aperture.compressor.cells()))
}

/// Pulses of so many cells to compress at a time.
fn batch(cells: usize) -> usize {
    (MOST_CELL_BYTES / (cells.max(1).saturating_mul(size_of::<Complex32>()))).clamp(1, MOST_AT_A_TIME)
}

fn in_batches(
    aperture: &Aperture,
    grounds: &[Ground],
    done: &(dyn Fn(usize) + Sync),
    batch: usize,
) -> Vec<Vec<Complex32>> {
    let variant = Variant::fastest();
    let sights: Vec<Vec<Sight>> = grounds.iter().map(|ground| sights(aperture, ground)).collect();
    let runs: Vec<usize> = grounds
        .iter()
        .zip(&sights)
        .map(|(ground, sights)| run_pixels(aperture.carrier_hz, ground, sights))
        .collect();
    let tiles: Vec<Tile> = grounds.iter().enumerate().flat_map(|(i, ground)| tiles(i, ground)).collect();
    let mut sums: Vec<Sum> = tiles
        .iter()
        .map(|tile| {
            let pixels = tile.size[0] * tile.size[1];
            Sum {
                value: vec![Complex32::ZERO; pixels],
                weight: vec![0.0; if aperture.gate.is_some() { pixels } else { 0 }],
            }
        })
        .collect();
    let table = aperture.gate.as_ref().map(|gate| (gate.bandwidth_hz, gate.table()));
    let scale = 1.0 / aperture.weights();
    for (part, pulses) in aperture.pulses.chunks(batch).enumerate() {
        let cells: Vec<Vec<Complex32>> = pulses
            .par_iter()
            .map(|pulse| {
                let doppler_hz = aperture.doppler_hz(pulse, aperture.centre_m);
                let mut cells = aperture.compressor.compress(pulse.samples, pulse.number, doppler_hz);
                let weight = (pulse.weight * scale) as f32;
                cells.iter_mut().for_each(|cell| *cell *= weight);
                cells
            })
            .collect();
        let from = part * batch;
        let weights: Vec<f32> = pulses.iter().map(|pulse| (pulse.weight * scale) as f32).collect();
        sums.par_iter_mut().zip(&tiles).for_each(|(sum, tile)| {
            let work = TileTask {
                carrier_hz: aperture.carrier_hz,
                cell_rate_hz: aperture.compressor.cell_rate_hz(),
                ground: &grounds[tile.ground],
                sights: &sights[tile.ground][from..from + pulses.len()],
                weights: &weights,
                cells: &cells,
                gate: table.as_ref().map(|(bandwidth_hz, table)| (*bandwidth_hz, table)),
                tile: *tile,
                sum,
            };
            match runs[tile.ground] {
                32 => variant.run(Runs::<32>(work)),
                16 => variant.run(Runs::<16>(work)),
                8 => variant.run(Runs::<8>(work)),
                _ => variant.run(Runs::<1>(work)),
            }
        });
        done(from + pulses.len());
    }
    let mut images: Vec<Vec<Complex32>> =
        grounds.iter().map(|ground| vec![Complex32::ZERO; ground.len()]).collect();
    for (tile, sum) in tiles.iter().zip(&mut sums) {
        let columns = grounds[tile.ground].pixels[0];
        for (value, weight) in sum.value.iter_mut().zip(&sum.weight) {
            *value = if *weight == 0.0 { Complex32::ZERO } else { *value / *weight };
        }
        for (j, row) in sum.value.chunks_exact(tile.size[0]).enumerate() {
            let at = (tile.first[1] + j) * columns + tile.first[0];
            images[tile.ground][at..at + row.len()].copy_from_slice(row);
        }
    }
    images
}

fn sights(aperture: &Aperture, ground: &Ground) -> Vec<Sight> {
    let middle_m = ground.centre_m();
    aperture
        .pulses
        .iter()
        .enumerate()
        .map(|(place, pulse)| {
            let leaves_s = aperture.middle_s(pulse);
            let tau_s = delay_s(aperture.transmitter, aperture.receiver, leaves_s, middle_m);
            let (to, to_mps) = aperture.receiver.state(leaves_s + tau_s);
            let (from, from_mps) = aperture.transmitter.state(leaves_s);
            let gate = aperture.gate.as_ref();
            Sight {
                from,
                from_mps,
                to,
                to_mps,
                middle_s: tau_s,
                window_start_s: pulse.window_start_s,
                aim_hz: gate.and_then(|gate| gate.aim_hz.get(place).copied()).unwrap_or(f64::NAN),
            }
        })
        .collect()
}

/// The longest run whose cubics are good enough.
fn run_pixels(carrier_hz: f64, ground: &Ground, sights: &[Sight]) -> usize {
    let corner = |i: usize, j: usize| {
        DVec3::from(ground.point_m((i * (ground.pixels[0] - 1)) as f64, (j * (ground.pixels[1] - 1)) as f64))
    };
    let middle = DVec3::from(ground.centre_m());
    let reach = [(0, 0), (0, 1), (1, 0), (1, 1)]
        .into_iter()
        .map(|(i, j)| corner(i, j).distance(middle))
        .fold(0.0, f64::max);
    let normal = DVec3::from(ground.step_x_m).cross(DVec3::from(ground.step_y_m)).normalize_or_zero();
    let least_m = sights
        .iter()
        .flat_map(|sight| [sight.from, sight.to])
        .map(|end| (end.distance(middle) - reach).max((end - middle).dot(normal).abs()))
        .fold(f64::INFINITY, f64::min)
        .max(1e-3);
    let step_m = DVec3::from(ground.step_x_m).length();
    let missed = |run: usize| {
        let half_m = 0.5 * run as f64 * step_m;
        carrier_hz / C * half_m.powi(4) / (4.0 * least_m.powi(3))
    };
    [LONGEST, 16, 8].into_iter().find(|run| missed(*run) <= MOST_TURNS).unwrap_or(1)
}

fn tiles(ground: usize, of: &Ground) -> impl Iterator<Item = Tile> + use<> {
    let [columns, rows] = of.pixels;
    (0..rows).step_by(TILE[1]).flat_map(move |j| {
        (0..columns).step_by(TILE[0]).map(move |i| Tile {
            ground,
            first: [i, j],
            size: [TILE[0].min(columns - i), TILE[1].min(rows - j)],
        })
    })
}

struct TileTask<'a> {
    carrier_hz: f64,
    cell_rate_hz: f64,
    ground: &'a Ground,
    sights: &'a [Sight],
    /// Weights of the pulses, of which the cells have theirs already.
    weights: &'a [f32],
    cells: &'a [Vec<Complex32>],
    /// Bandwidth, Hz, and taper.
    gate: Option<(f64, &'a Table)>,
    tile: Tile,
    sum: &'a mut Sum,
}

/// What a tile has taken so far.
struct Sum {
    value: Vec<Complex32>,
    /// Weights of every pixel; empty without a gate.
    weight: Vec<f32>,
}

struct Runs<'a, const RUN: usize>(TileTask<'a>);

impl<const RUN: usize> Task for Runs<'_, RUN> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let work = self.0;
        let [width, _] = work.tile.size;
        let half = (RUN / 2) as f64;
        let Sum { value, weight } = work.sum;
        for ((sight, cells), share) in work.sights.iter().zip(work.cells).zip(work.weights) {
            for (j, row) in value.chunks_exact_mut(width).enumerate() {
                let y = (work.tile.first[1] + j) as f64;
                for (r, run) in row.chunks_mut(RUN).enumerate() {
                    let x = (work.tile.first[0] + r * RUN) as f64 + half;
                    let mut taken = [1f32; RUN];
                    if let Some((bandwidth_hz, table)) = work.gate {
                        let place = sight.place(work.ground, x, y, work.carrier_hz, bandwidth_hz);
                        if !gated::<RUN>(place, table, &mut taken) {
                            continue;
                        }
                        let at = j * width + r * RUN;
                        for (sum, taken) in weight.iter_mut().skip(at).zip(&taken[..run.len()]) {
                            *sum += taken * share;
                        }
                    }
                    let (carrier_hz, cell_rate_hz) = (work.carrier_hz, work.cell_rate_hz);
                    add::<RUN>(
                        sight.cubic(work.ground, x, y),
                        sight.window_start_s,
                        carrier_hz,
                        cell_rate_hz,
                        cells,
                        &taken,
                        run,
                    );
                }
            }
        }
    }
}

impl Sight {
    /// Delay at a pixel (s) and its first, half its second, a sixth of its third derivative over the number
    /// of the pixel along x.
    #[inline(always)]
    fn cubic(&self, ground: &Ground, x: f64, y: f64) -> [f64; 4] {
        let point =
            DVec3::from(ground.first_m) + DVec3::from(ground.step_x_m) * x + DVec3::from(ground.step_y_m) * y;
        let step = DVec3::from(ground.step_x_m);
        let square = step.length_squared();
        let leg = |end: DVec3| {
            let away = point - end;
            let range = away.length().max(1e-3);
            let unit = away / range;
            let first = unit.dot(step);
            let second = (square - first * first) / range;
            (unit, [range, first, 0.5 * second, -0.5 * first * second / range])
        };
        let (_, out) = leg(self.from);
        let (unit, back) = leg(self.to);
        // The receiver goes on by v (tau - middle): its range changes by -rho (tau - middle), rho along the
        // way to the point.
        let rho = self.to_mps.dot(unit);
        let share = 1.0 / (C + rho);
        let tau = (out[0] + back[0] + rho * self.middle_s) * share;
        let rho_step = (self.to_mps.dot(step) - rho * back[1]) / back[0];
        let first = (out[1] + back[1] - rho_step * (tau - self.middle_s)) * share;
        [tau, first, (out[2] + back[2]) * share, (out[3] + back[3]) * share]
    }
}

impl Sight {
    /// Place in the Doppler band of a pixel, and its first and half its second derivative over the number of
    /// the pixel along x.
    #[inline(always)]
    fn place(&self, ground: &Ground, x: f64, y: f64, carrier_hz: f64, bandwidth_hz: f64) -> [f64; 3] {
        let point =
            DVec3::from(ground.first_m) + DVec3::from(ground.step_x_m) * x + DVec3::from(ground.step_y_m) * y;
        let step = DVec3::from(ground.step_x_m);
        let out = closing(self.from_mps, point - self.from, step);
        let back = closing(self.to_mps, point - self.to, step);
        let scale = carrier_hz / (C * bandwidth_hz);
        let [value, first, half] = std::array::from_fn(|i| (out[i] + back[i]) * scale);
        [value - self.aim_hz / bandwidth_hz, first, half]
    }
}

/// Weights of a run in a band, from the place of its middle and its derivatives; whether there is any.
#[inline(always)]
fn gated<const RUN: usize>(place: [f64; 3], table: &Table, taken: &mut [f32; RUN]) -> bool {
    let half = (RUN / 2) as f64;
    let reach = half * (place[1].abs() + half * place[2].abs());
    // No number where there is no aim.
    if place[0].is_nan() || place[0].abs() - reach > 0.5 {
        return false;
    }
    let [u, first, second] = place.map(|p| p as f32);
    for (k, taken) in taken.iter_mut().enumerate() {
        let x = k as f32 - half as f32;
        *taken = table.weight(u + x * (first + x * second));
    }
    true
}

/// Steps of `2^-32` turn of a number of turns, its whole part left out.
#[inline(always)]
fn steps(turns: f64) -> i32 {
    ((turns - turns.floor()) * 4_294_967_296.0) as u64 as u32 as i32
}

/// Adds a pulse to a run of pixels.
#[inline(always)]
fn add<const RUN: usize>(
    delay: [f64; 4],
    window_start_s: f64,
    carrier_hz: f64,
    cell_rate_hz: f64,
    cells: &[Complex32],
    taken: &[f32; RUN],
    run: &mut [Complex32],
) {
    let half = (RUN / 2) as i32;
    let phase = delay.map(|d| steps(carrier_hz * d));
    // Counted from a whole cell, so that f32 holds only what a run spans.
    let middle = (delay[0] - window_start_s) * cell_rate_hz;
    let base = middle.floor();
    let mut place = delay.map(|d| (cell_rate_hz * d) as f32);
    place[0] = (middle - base) as f32;
    // Clamped as a whole number: a run that far away gets nothing, see below.
    let far = i64::from(FAR_CELLS);
    let base = (base as i64).clamp(-2 * far, 2 * far) as i32;
    let last = cells.len().saturating_sub(2).min(FAR_CELLS as usize) as i32;
    let (mut re, mut im) = ([0f32; RUN], [0f32; RUN]);
    let (mut at, mut part) = ([0u32; RUN], [0f32; RUN]);
    for k in 0..RUN {
        let i = k as i32 - half;
        let turn = phase[3].wrapping_mul(i).wrapping_add(phase[2]).wrapping_mul(i).wrapping_add(phase[1]);
        let (cos, sin) = cos_sin(turn.wrapping_mul(i).wrapping_add(phase[0]));
        let x = i as f32;
        let away = place[0] + x * (place[1] + x * (place[2] + x * place[3]));
        // Floor, which not every processor has as an instruction.
        let whole = away as i32;
        let whole = whole - i32::from((whole as f32) > away);
        let cell = base.wrapping_add(whole);
        let rest = away - whole as f32;
        // The last cell is the upper end of the last pair.
        let end = cell == last + 1 && rest == 0.0;
        let inside = away.abs() <= FAR_CELLS as f32 && cell >= 0 && (cell <= last || end);
        at[k] = if inside { cell.min(last) } else { 0 } as u32;
        part[k] = if end { 1.0 } else { rest };
        let weight = if inside { taken[k] } else { 0.0 };
        re[k] = weight * cos;
        im[k] = weight * sin;
    }
    for (k, sum) in run.iter_mut().enumerate() {
        let at = at[k] as usize;
        let Some([low, high]) = cells.get(at..at + 2) else { continue };
        let value_re = low.re + (high.re - low.re) * part[k];
        let value_im = low.im + (high.im - low.im) * part[k];
        sum.re += value_re * re[k] - value_im * im[k];
        sum.im += value_re * im[k] + value_im * re[k];
    }
}

/// Cosine and sine of a phase in steps of `2^-32` turn, to 1.2e-7 and rounding: Taylor series to the eleventh
/// order within a quarter turn.
#[inline(always)]
fn cos_sin(phase: i32) -> (f32, f32) {
    let turns = phase as f32 * (1.0 / 4_294_967_296.0);
    let away = turns.abs();
    let folded = if away > 0.25 { 0.5f32.copysign(turns) - turns } else { turns };
    (sine(0.25 - away), sine(folded))
}

/// Sine of up to a quarter turn either way.
#[inline(always)]
fn sine(turns: f32) -> f32 {
    let x = turns * std::f32::consts::TAU;
    let s = x * x;
    let series = -2.505_210_8e-8 * s + 2.755_731_9e-6;
    let series = series * s - 1.984_127e-4;
    let series = series * s + 8.333_333e-3;
    let series = series * s - 0.166_666_67;
    x + x * s * series
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::phase_path::PhasePath;
    use crate::processor::backproject::PulseEcho;
    use crate::processor::range_compress::{Compressor, PulseShape, RangeFilter};
    use crate::processor::taper::Taper;
    use crate::scene::radar::Band;

    #[test]
    fn cosines_and_sines_of_all_turns() {
        for i in 0..100_000u32 {
            let phase = i.wrapping_mul(2_654_435_761);
            let exact = f64::from(phase) / 4_294_967_296.0 * std::f64::consts::TAU;
            let (cos, sin) = cos_sin(phase as i32);
            // (pi/2)^13/13! = 5.7e-8 is left out of the series; some roundings of 6e-8.
            assert!((f64::from(cos) - exact.cos()).abs() < 4e-7, "{phase}");
            assert!((f64::from(sin) - exact.sin()).abs() < 4e-7, "{phase}");
        }
    }

    #[test]
    fn batches_keep_the_budget_and_do_not_change_a_bit() {
        // 768 samples of 16 cells; a million of them, 128 MB a pulse; more than the budget.
        assert_eq!([767 * 16 + 1, 16_000_000, usize::MAX].map(batch), [64, 2, 1]);
        let times_s: Vec<f64> = (0..10).map(|i| f64::from(i) / 500.0).collect();
        let points = times_s.iter().map(|t| [200.0 * t, -900.0, 300.0]).collect();
        let path = PhasePath::new(times_s.clone(), points).unwrap();
        let replica: Vec<Complex32> = (0..20).map(|i| Complex32::cis(0.05 * (i * i) as f32)).collect();
        let shape = PulseShape {
            replica: &replica,
            turns: 1,
            sample_rate_hz: 1e8,
            band: Band::about(0.0, 6e7),
            pulse_s: 2e-7,
        };
        let compressor = Compressor::new(shape, 128, RangeFilter::Matched, Taper::Uniform, 8).unwrap();
        let samples: Vec<Complex32> = (0..128).map(|i| Complex32::cis((i * i) as f32)).collect();
        let echo = |t: &f64| PulseEcho {
            emission_s: *t,
            number: 0,
            window_start_s: 6.1e-6,
            weight: 1.0 + 10.0 * t,
            samples: &samples,
        };
        let aperture = Aperture {
            carrier_hz: 1e10,
            compressor: &compressor,
            transmitter: &path,
            receiver: &path,
            pulses: times_s.iter().map(echo).collect(),
            centre_m: [0.0; 3],
            gate: None,
        };
        let ground = Ground::map([0.0; 3], [40.0, 20.0], 1.0).unwrap();
        let image = |batch: usize| in_batches(&aperture, &[ground], &|_| (), batch).remove(0);
        let whole = image(64);
        assert!(whole.iter().all(|z| z.norm() > 0.0));
        for batch in [1, 3, 9] {
            assert_eq!(image(batch), whole, "{batch}");
        }
    }

    #[test]
    fn cubics_meet_exact_light_time() {
        // X band; an aeroplane, a satellite, a small boat 60 m away.
        for (start, velocity, other, other_mps, pixel_m) in [
            ([0.0, -4200.0, 3000.0], [222.0, 0.0, 0.0], [-900.0, -3000.0, 15.0], [0.0; 3], 1.0),
            ([-4e5, 0.0, 8e5], [0.0, 7500.0, 0.0], [-4.4e5, 3e3, 7.9e5], [0.0, 7400.0, 60.0], 2.0),
            ([0.0, -60.0, 12.0], [3.0, 1.0, 0.0], [10.0, -55.0, 4.0], [2.0, 0.0, 0.0], 0.25),
        ] {
            let times_s: Vec<f64> = (0..64).map(|i| f64::from(i) / 500.0).collect();
            let line = |from: [f64; 3], v: [f64; 3]| {
                let points = times_s.iter().map(|t| std::array::from_fn(|i| from[i] + v[i] * t)).collect();
                PhasePath::new(times_s.clone(), points).unwrap()
            };
            let (transmitter, receiver) = (line(start, velocity), line(other, other_mps));
            let ground = Ground::map([0.0; 3], [200.0 * pixel_m, 150.0 * pixel_m], pixel_m).unwrap();
            let leaves_s = 0.05;
            let middle_s = delay_s(&transmitter, &receiver, leaves_s, ground.centre_m());
            let (to, to_mps) = receiver.state(leaves_s + middle_s);
            let (from, from_mps) = transmitter.state(leaves_s);
            let sight = Sight { from, from_mps, to, to_mps, middle_s, window_start_s: 0.0, aim_hz: 0.0 };
            let run = run_pixels(10e9, &ground, &[sight]);
            let mut worst = 0.0f64;
            for (i, j) in [(0, 0), (199, 0), (17, 149), (198, 149), (100, 75)] {
                let x = f64::from(i);
                let delay = sight.cubic(&ground, x, f64::from(j));
                let half = (run / 2) as i32;
                for k in [-half, -half / 2, 0, half / 2] {
                    let d = f64::from(k);
                    let cubic = delay[0] + d * (delay[1] + d * (delay[2] + d * delay[3]));
                    let exact =
                        delay_s(&transmitter, &receiver, leaves_s, ground.point_m(x + d, f64::from(j)));
                    worst = worst.max((10e9 * (cubic - exact)).abs());
                }
            }
            println!("runs of {run}: {worst:.1e} turns");
            // The bound of the runs, and rounding of 2e-16 x 6e7 turns in orbit. 1e-3 rad are 1.6e-4 turns.
            assert!(worst < MOST_TURNS + 5e-8, "{worst}");
        }
    }
}
