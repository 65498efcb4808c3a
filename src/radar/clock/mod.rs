//! Clocks: what a wrong oscillator does to delay, phase and window.
//!
//! A clock reads `t + x(t)` at the time `t` of the run, `x = x_0 + y_0 t + D t^2/2 + noise` (offset, drift,
//! ageing; [`noise`]). The transmitter sends pulse `n` and its carrier, the receiver opens its window `w`
//! later and mixes, each by its own clock. A scatterer with delay `tau` then has the phase `2 pi f_0` times
//! reading at emission less reading at reception, and begins in the window where the readings say: both are
//! those of a delay
//!
//! ```text
//! tau + d ,   d = x_R(t_n + w) - x_T(t_n) = x_R(t_n) + y_R w - x_T(t_n)
//! ```
//!
//! and the oscillator of the receiver turns on by `2 pi f_0 y_R i / fs` to sample `i`. So:
//!
//! * a window opens at `w - d` after the true emission, by the first pair in it, while `w` is what is
//!   recorded: no delay, however long, wraps;
//! * spectra of other pairs in that window get the linear phase of `d - d_first`, which must stay within half
//!   the guard of the window;
//! * every sample is multiplied by `e^(-j 2 pi f_0 (d + y_R i / fs))`.
//!
//! One clock for both ends leaves only what it does in between, `d = x(t_n + w) - x(t_n)`: `y w`, and of
//! noise faster than pulses the range-correlated part, whose spectrum is `S_x 4 sin^2(pi f w)`: variance
//! `h_0 w/2 + h_1 (f_h w)^2/2 + h_2 f_h^3 w^2/3` for `f_h w << 1`.
//!
//! Limits. Platforms are taken at the scheduled emission, not `x_T` earlier: `v x_T`, 0.2 mm for 222 m/s and
//! 1 us. Within a pulse the carrier is taken as steady, and the sample rate as nominal: relative errors of
//! `2 pi f_0 |y| T_c / sqrt(12)` and `pi B |y| W / sqrt(3)` (pulse `T_c`, window `W`, bandwidth `B`). A clock
//! for which their sum exceeds [`MOST_NEGLECTED`] anywhere in the run is refused ([`ClockFault::Fast`]); for
//! `y = 1e-9` in X band it is 1e-5 (-100 dB).
//!
//! ```
//! use nereus::radar::clock::{Oscillator, adev};
//! let rubidium = Oscillator::Rubidium.noise_h();
//! assert!((adev(&rubidium, 100.0, 100.0) / 2e-12 - 1.0).abs() < 1e-12);
//! ```

pub mod noise;

use std::f64::consts::TAU;

use num_complex::Complex64;
use rand_distr::{Distribution, StandardNormal};
use thiserror::Error;

use crate::radar::window::GUARD_SAMPLES;
use crate::rng::{Room, stream};
use crate::scene::Radar;
use crate::scene::clock::Clocks;
use crate::scene::radar::Pair;
use crate::time::PulseTimes;

pub use noise::{Oscillator, adev};

/// Greatest relative error by what is left out.
pub const MOST_NEGLECTED: f64 = 1e-2;
/// Most pulses of a run with noisy clocks, over all of them (512 MiB).
pub const MOST_VALUES: u64 = 1 << 25;
/// Marks the streams of noise between emission and reception.
const BETWEEN: u64 = 1 << 32;

/// Why clocks cannot be emulated.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ClockFault {
    /// Too much noise to hold.
    #[error(
        "noise of {clocks} clocks over {pulses} pulses; allowed: at most {MOST_VALUES} values in all; a shorter run"
    )]
    TooLong {
        /// Noisy clocks.
        clocks: usize,
        /// Pulses of the run.
        pulses: u64,
    },
    /// A clock that runs too wrong for what is neglected.
    #[error(
        "clock of '{name}': its frequency is off by {y:.1e} of itself (drift, ageing, noise), by which echoes would be wrong by \
         {neglected:.1e} of themselves; allowed with these pulses and windows: a frequency off by {:.1e} at most",
        y * MOST_NEGLECTED / neglected
    )]
    Fast {
        /// Its name.
        name: String,
        /// Fractional frequency.
        y: f64,
        /// What would be left out.
        neglected: f64,
    },
    /// Receivers whose clocks are too far apart for one window.
    #[error(
        "clocks of pair {pair} and of the first in its window differ by {apart_s:.3e} s at pulse {pulse}; allowed: at most {allowed_s:.3e} s, \
         half the guard of the window"
    )]
    Apart {
        /// Place of the pair.
        pair: usize,
        /// When.
        pulse: u64,
        /// By how much.
        apart_s: f64,
        /// Most.
        allowed_s: f64,
    },
    /// A number that no clock has.
    #[error("clock of '{name}': {what} = {value} is not allowed: {allowed}")]
    Value {
        /// Its name.
        name: String,
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}

/// One clock, made for a run.
#[derive(Clone, Debug)]
struct Running {
    /// Offset, drift, ageing.
    known: [f64; 3],
    /// Noise of `x` and `y` at every pulse; empty without.
    noise: Vec<[f64; 2]>,
    /// Variance of what a time `w` adds between emission and reception: times `w`, and times `w^2`.
    between: [f64; 2],
    /// Place among clocks, for streams.
    place: u64,
}

/// What clocks make of the samples of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelClock {
    /// Delay in addition to that of the window's start, s.
    pub delay_s: f64,
    /// Phase of the first sample, turns.
    pub turns: f64,
    /// Change of phase from a sample to the next, turns.
    pub turns_per_sample: f64,
}

/// All clocks of a run.
#[derive(Clone, Debug)]
pub struct RunningClocks {
    clocks: Vec<Running>,
    seed: u64,
    times: PulseTimes,
    pairs: Vec<[Option<usize>; 2]>,
    /// Clocks of transmitters and of receivers, by their places.
    antennas: [Vec<Option<usize>>; 2],
    channel_pairs: Vec<usize>,
    /// Pairs whose clocks open windows ([`Radar::window_leads`]), and the window of each pair.
    leads: Vec<usize>,
    pair_windows: Vec<usize>,
    carrier_hz: f64,
    sample_rate_hz: f64,
}

impl RunningClocks {
    /// Makes the clocks of a radar for a run; `None` if it has none. `bandwidth_hz` and `pulse_s` are those
    /// of the waveform.
    ///
    /// # Errors
    /// Numbers without meaning, clocks too far off, runs too long.
    pub fn new(
        clocks: &Clocks,
        radar: &Radar,
        seed: u64,
        pulses: u64,
        bandwidth_hz: f64,
        pulse_s: f64,
    ) -> Result<Option<Self>, ClockFault> {
        if clocks.clocks.is_empty() {
            return Ok(None);
        }
        let times = &radar.emissions;
        let noisy = clocks.clocks.iter().filter(|c| c.clock.noise != [0.0; 5]).count();
        if (noisy as u64).saturating_mul(pulses) > MOST_VALUES {
            return Err(ClockFault::TooLong { clocks: noisy, pulses });
        }
        let window_s = radar.window.samples as f64 / radar.sample_rate_hz;
        let mut running = Vec::with_capacity(clocks.clocks.len());
        for (place, named) in clocks.clocks.iter().enumerate() {
            let clock = noise::check(named)?;
            let noise = noise::series(&clock, times, pulses, seed, place as u64);
            let known = [clock.offset_s, clock.drift, clock.ageing_per_s];
            let band_hz = clock.bandwidth_hz.unwrap_or(0.5 * times.mean_prf_hz());
            let [_, _, h0, h1, h2] = clock.noise;
            let between = [h0 / 2.0, h1 * band_hz.powi(2) / 2.0 + h2 * band_hz.powi(3) / 3.0];
            let made = Running { known, noise, between, place: place as u64 };
            // Drift and ageing are greatest at an end; noise anywhere.
            let ends = [0, pulses.saturating_sub(1)].map(|n| made.at(times, n)[1].abs());
            let noisy = made.noise.iter().enumerate().map(|(n, _)| made.at(times, n as u64)[1].abs());
            let y = noisy.chain(ends).fold(0.0, f64::max);
            let neglected = TAU * radar.carrier_hz * y * pulse_s / 12f64.sqrt()
                + 0.5 * TAU * bandwidth_hz * y * window_s / 3f64.sqrt();
            if neglected.is_nan() || neglected > MOST_NEGLECTED {
                return Err(ClockFault::Fast { name: named.name.clone(), y, neglected });
            }
            running.push(made);
        }
        let of = |list: &[Option<usize>], place: usize| list.get(place).copied().flatten();
        let radar_pairs = radar.pairs();
        let pairs: Vec<[Option<usize>; 2]> = radar_pairs
            .iter()
            .map(|p| [of(&clocks.transmitters, p.transmitter), of(&clocks.receivers, p.receiver)])
            .collect();
        let channel_pairs = radar.channels.iter().filter_map(|channel| {
            let wanted = Pair { transmitter: channel.transmitter, receiver: channel.receiver };
            radar_pairs.iter().position(|pair| *pair == wanted)
        });
        let place = |pair: &Pair| radar_pairs.iter().position(|own| own == pair).unwrap_or(0);
        let leads: Vec<usize> = radar.window_leads().iter().map(place).collect();
        let windows = |pair: &Pair| Radar::window_of(pair.receiver, leads.len());
        let pair_windows = radar_pairs.iter().map(windows).collect();
        let made = Self {
            clocks: running,
            seed,
            times: times.clone(),
            pairs,
            antennas: [clocks.transmitters.clone(), clocks.receivers.clone()],
            channel_pairs: channel_pairs.collect(),
            leads,
            pair_windows,
            carrier_hz: radar.carrier_hz,
            sample_rate_hz: radar.sample_rate_hz,
        };
        made.check_apart(pulses)?;
        Ok(Some(made))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.clocks.len()
    }

    /// Reading less time of a clock at a pulse, s, and its derivative.
    pub fn reading(&self, clock: usize, pulse: u64) -> [f64; 2] {
        self.clocks.get(clock).map_or([0.0; 2], |clock| clock.at(&self.times, pulse))
    }

    /// The delay that the clocks of a pair add to a pulse whose window opens `after_s` after its emission,
    /// and the fractional frequency of the receiver.
    fn of_pair(&self, pair: usize, pulse: u64, after_s: f64) -> [f64; 2] {
        self.of_ends(self.pairs.get(pair).copied().unwrap_or_default(), pulse, after_s)
    }

    /// Reading of a receiver's clock less that of a transmitter's (without one: less the time) at one
    /// instant, `after_s` after the emission of a pulse, s, and its derivative: zero for a clock that both
    /// share.
    pub fn apart(&self, transmitter: Option<usize>, receiver: usize, pulse: u64, after_s: f64) -> [f64; 2] {
        let of = |list: &[Option<usize>], place: usize| list.get(place).copied().flatten();
        let [transmitters, receivers] = &self.antennas;
        let (sends, receives) =
            (transmitter.and_then(|place| of(transmitters, place)), of(receivers, receiver));
        if sends == receives {
            return [0.0; 2];
        }
        let reading = |end: Option<usize>| end.map_or([0.0; 2], |clock| self.reading(clock, pulse));
        let ([x_t, y_t], [x_r, y_r]) = (reading(sends), reading(receives));
        [x_r - x_t + (y_r - y_t) * after_s, y_r - y_t]
    }

    fn of_ends(&self, ends: [Option<usize>; 2], pulse: u64, after_s: f64) -> [f64; 2] {
        match ends {
            [Some(one), Some(other)] if one == other => {
                let [_, y] = self.reading(one, pulse);
                [y * after_s + self.clocks[one].between(self.seed, pulse, after_s), y]
            }
            [transmitter, receiver] => {
                let reading = |end: Option<usize>| end.map_or([0.0; 2], |clock| self.reading(clock, pulse));
                let ([x_t, _], [x_r, y_r]) = (reading(transmitter), reading(receiver));
                [x_r + y_r * after_s - x_t, y_r]
            }
        }
    }

    /// How much earlier than nominal a window opens after the true emission, s: the delay of the pair by
    /// which it is found.
    pub fn window_shift_s(&self, window: usize, pulse: u64, after_s: f64) -> f64 {
        self.of_pair(self.leads.get(window).copied().unwrap_or(0), pulse, after_s)[0]
    }

    /// What becomes of every channel of a pulse whose windows open nominally so long after its emission, s.
    pub fn channels(&self, pulse: u64, starts_s: &[f64], channels: &mut Vec<ChannelClock>) {
        channels.clear();
        channels.extend(self.channel_pairs.iter().map(|pair| {
            let window = self.pair_windows[*pair];
            let after_s = starts_s.get(window).or(starts_s.first()).copied().unwrap_or(0.0);
            let shift_s = self.window_shift_s(window, pulse, after_s);
            let [delay_s, y] = self.of_pair(*pair, pulse, after_s);
            let turns = -(self.carrier_hz * delay_s).rem_euclid(1.0);
            let turns_per_sample = -self.carrier_hz * y / self.sample_rate_hz;
            ChannelClock { delay_s: delay_s - shift_s, turns, turns_per_sample }
        }));
    }

    /// Whether one window does for all pairs that have it, at every pulse.
    fn check_apart(&self, pulses: u64) -> Result<(), ClockFault> {
        let allowed_s = 0.5 * GUARD_SAMPLES as f64 / self.sample_rate_hz;
        if self.pairs.windows(2).all(|pair| pair[0] == pair[1]) {
            return Ok(());
        }
        let noisy = self.clocks.iter().any(|clock| !clock.noise.is_empty());
        // Without noise differences are parabolas: greatest at an end or where they turn, near which one of
        // many looks is.
        let step = if noisy { 1 } else { (pulses / 65_536).max(1) };
        let mut pulse = 0;
        while pulse < pulses {
            for pair in 0..self.pairs.len() {
                let apart_s = self.of_pair(pair, pulse, 0.0)[0]
                    - self.window_shift_s(self.pair_windows[pair], pulse, 0.0);
                if apart_s.is_nan() || apart_s.abs() > allowed_s {
                    return Err(ClockFault::Apart { pair, pulse, apart_s, allowed_s });
                }
            }
            let last = pulses - 1;
            pulse = if pulse < last { pulse.saturating_add(step).min(last) } else { pulses };
        }
        Ok(())
    }
}

impl Running {
    fn at(&self, times: &PulseTimes, pulse: u64) -> [f64; 2] {
        let t_s = times.interval_s(0, pulse);
        let [offset_s, drift, ageing] = self.known;
        let place = usize::try_from(pulse).unwrap_or(usize::MAX).min(self.noise.len().saturating_sub(1));
        let [x, y] = self.noise.get(place).copied().unwrap_or_default();
        [offset_s + t_s * (drift + 0.5 * ageing * t_s) + x, drift + ageing * t_s + y]
    }

    /// What noise adds between emission and reception, s.
    fn between(&self, seed: u64, pulse: u64, after_s: f64) -> f64 {
        let variance = self.between[0] * after_s.abs() + self.between[1] * after_s * after_s;
        if variance == 0.0 {
            return 0.0;
        }
        let number: f64 = StandardNormal.sample(&mut stream(seed, Room::Clock, BETWEEN | self.place, pulse));
        number * variance.sqrt()
    }
}

impl ChannelClock {
    /// Gives a spectrum its part of the delay.
    pub(super) fn delay(&self, bins: &mut [Complex64], frequency_hz: impl Fn(usize) -> f64) {
        if self.delay_s == 0.0 {
            return;
        }
        for (k, bin) in bins.iter_mut().enumerate() {
            *bin *= Complex64::cis(-TAU * (frequency_hz(k) * self.delay_s).fract());
        }
    }

    /// Turns samples.
    pub(super) fn turn(&self, samples: &mut [Complex64]) {
        for (i, sample) in samples.iter_mut().enumerate() {
            *sample *= Complex64::cis(TAU * (self.turns + self.turns_per_sample * i as f64).fract());
        }
    }
}
