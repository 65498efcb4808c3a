//! Noise of an oscillator with a power-law spectrum of its fractional frequency.
//!
//! `S_y(f) = h_-2 f^-2 + h_-1 f^-1 + h_0 + h_1 f + h_2 f^2`, one-sided; of the time error
//! `S_x = S_y/(2 pi f)^2`. Stepped from pulse to pulse, exactly for every interval `dt`:
//!
//! | term | what is stepped | variance |
//! | --- | --- | --- |
//! | `h_-2` random walk of y | y, and x as its integral | `q dt`, `q dt^2/2`, `q dt^3/3`, `q = 2 pi^2 h_-2` |
//! | `h_-1` flicker of y | a sum of Ornstein-Uhlenbeck processes, times apart by 4, and x as their integrals | each `h_-1 ln 4` |
//! | `h_0` white y | x, a walk | `h_0 dt/2` |
//! | `h_1` flicker of x up to `f_h` | the same sum, of x | each `h_1 ln 4/(4 pi^2)` |
//! | `h_2` white x up to `f_h` | x, new at every pulse | `h_2 f_h/(4 pi^2)` |
//!
//! Such a sum with processes `r` apart is flicker with a ripple of `2 sech(pi^2/ln r)`, 0.3 % for 4. Its
//! times run from 1/64 of the mean interval (1/(pi `f_h`) for `h_1`) by as many processes as it takes reach
//! 1e6 s, whatever the length of the run. Walk and flicker begin at zero: offset and drift are those of pulse
//! 0.
//!
//! Allan variance (D. W. Allan, *Proc. IEEE* 54 (1966) 221; IEEE 1139):
//! `h_-2 (2 pi^2/3) tau + h_-1 2 ln 2 + h_0/(2 tau) + h_1 (1.038 + 3 ln(2 pi f_h tau))/(4 pi^2 tau^2) +
//! 3 h_2 f_h/(4 pi^2 tau^2)`.
//!
//! ```
//! use nereus::radar::clock::noise::{Oscillator, adev};
//! // The flicker floor of an ovenised crystal is level.
//! let ocxo = Oscillator::Ocxo.noise_h();
//! assert!((adev(&ocxo, 1.0, 100.0) - 2e-12).abs() < 1e-24 && (adev(&ocxo, 50.0, 100.0) - 2e-12).abs() < 1e-24);
//! ```

use std::f64::consts::{LN_2, PI, TAU};

use rand_distr::{Distribution, StandardNormal};

use super::ClockFault;
use crate::rng::{Room, stream};
use crate::scene::clock::{Clock, NamedClock};
use crate::time::PulseTimes;

/// Ratio of neighbouring times of the processes that make flicker.
const RATIO: f64 = 4.0;
/// The longest of these times is at least this, s.
const LONGEST_S: f64 = 1e6;
/// Shortest of these times, of a mean interval.
const SHORTEST: f64 = 1.0 / 64.0;

/// A kind of oscillator, with its typical Allan deviation at 1 s; others are beside it within a factor of three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Oscillator {
    /// Ovenised crystal: 2e-12, flickering in frequency.
    Ocxo,
    /// Temperature-compensated crystal: 1e-9, flickering in frequency.
    Tcxo,
    /// Disciplined by satellites: 1e-11, white in frequency.
    Gpsdo,
    /// Rubidium: 2e-11, white in frequency.
    Rubidium,
}

impl Oscillator {
    /// Its noise, `h_-2` to `h_2`.
    pub fn noise_h(self) -> [f64; 5] {
        let flicker = |sigma: f64| [0.0, sigma * sigma / (2.0 * LN_2), 0.0, 0.0, 0.0];
        let white = |sigma: f64| [0.0, 0.0, 2.0 * sigma * sigma, 0.0, 0.0];
        match self {
            Self::Ocxo => flicker(2e-12),
            Self::Tcxo => flicker(1e-9),
            Self::Gpsdo => white(1e-11),
            Self::Rubidium => white(2e-11),
        }
    }
}

/// Allan deviation at an averaging time, for phase noise up to `bandwidth_hz`; where the logarithm has lost
/// its meaning (`2 pi f_h tau < 1`) flicker of phase counts by its constant.
pub fn adev(noise: &[f64; 5], tau_s: f64, bandwidth_hz: f64) -> f64 {
    let [walk, flicker, white, flicker_phase, white_phase] = *noise;
    let log = 3.0 * (TAU * bandwidth_hz * tau_s).max(1.0).ln();
    let phase = flicker_phase * (1.038 + log) + white_phase * 3.0 * bandwidth_hz;
    (walk * 2.0 * PI * PI / 3.0 * tau_s
        + flicker * 2.0 * LN_2
        + white / (2.0 * tau_s)
        + phase / (TAU * tau_s).powi(2))
    .sqrt()
}

/// The clock, if its numbers have a meaning.
pub(super) fn check(named: &NamedClock) -> Result<Clock, ClockFault> {
    let Clock { offset_s, drift, ageing_per_s, noise, bandwidth_hz } = named.clock;
    let refuse =
        |what, value, allowed| Err(ClockFault::Value { name: named.name.clone(), what, value, allowed });
    for (what, value) in [("offset", offset_s), ("drift", drift), ("ageing", ageing_per_s)] {
        if !value.is_finite() {
            return refuse(what, value, "a finite number");
        }
    }
    if let Some(value) = noise.into_iter().find(|h| !(h.is_finite() && *h >= 0.0)) {
        return refuse("noise", value, "finite numbers, not negative");
    }
    match bandwidth_hz.filter(|hz| !(hz.is_finite() && *hz > 0.0)) {
        Some(value) => refuse("bandwidth", value, "a finite number above 0"),
        None => Ok(named.clock),
    }
}

/// A process of flicker: its rate (1/s) and its value.
#[derive(Clone, Copy, Debug)]
struct Relaxing {
    rate: f64,
    value: f64,
}

fn relaxing(shortest_s: f64) -> Vec<Relaxing> {
    let count = ((LONGEST_S / shortest_s).ln() / RATIO.ln()).ceil().max(1.0) as i32 + 1;
    (0..count).map(|k| Relaxing { rate: 1.0 / (shortest_s * RATIO.powi(k)), value: 0.0 }).collect()
}

/// Covariance, over the variance of the process, of what a step adds to value and integral (s, s^2).
fn added(rate: f64, dt: f64) -> [f64; 3] {
    let z = rate * dt;
    let fall = -(-z).exp_m1();
    let value = -(-2.0 * z).exp_m1();
    let cross = fall * fall / rate;
    let square = if z < 0.1 {
        // 2z - 3 + 4 e^-z - e^-2z: the first terms cancel.
        let series = 2.0 / 3.0 + z * (-0.5 + z * (7.0 / 30.0 + z * (-1.0 / 12.0 + z * 31.0 / 1260.0)));
        z * z * z * series
    } else {
        2.0 * z - 3.0 + 4.0 * (-z).exp() - (-2.0 * z).exp()
    };
    [value, cross, square / (rate * rate)]
}

/// Noise of `x` (s) and `y` at every pulse, from pulse 0; empty without noise.
pub(super) fn series(clock: &Clock, times: &PulseTimes, pulses: u64, seed: u64, place: u64) -> Vec<[f64; 2]> {
    if clock.noise == [0.0; 5] {
        return Vec::new();
    }
    let [walk, flicker, white, flicker_phase, white_phase] = clock.noise;
    let mean_s = 1.0 / times.mean_prf_hz();
    let band_hz = clock.bandwidth_hz.unwrap_or(0.5 / mean_s);
    let of = |h: f64, shortest_s: f64| if h > 0.0 { relaxing(shortest_s) } else { Vec::new() };
    let mut frequency = of(flicker, SHORTEST * mean_s);
    // So the sum has the variance of flicker that is cut at the bandwidth.
    let mut phase = of(flicker_phase, RATIO.sqrt() / (TAU * band_hz));
    let sigma_y = (flicker * RATIO.ln()).sqrt();
    let sigma_x = (flicker_phase * RATIO.ln()).sqrt() / TAU;
    let sigma_new = (white_phase * band_hz).sqrt() / TAU;
    let diffusion = 2.0 * PI * PI * walk;
    // Time error without phase noise; frequency of the walk; what walk and flicker began with.
    let (mut x, mut y_walk, mut begin_y, mut begin_x) = (0.0, 0.0, 0.0, 0.0);
    let mut before_s = 0.0;
    (0..pulses)
        .map(|pulse| {
            let mut numbers = stream(seed, Room::Clock, place, pulse);
            let mut draw = || -> f64 { StandardNormal.sample(&mut numbers) };
            let t_s = times.interval_s(0, pulse);
            let dt = t_s - before_s;
            before_s = t_s;
            let fresh = draw() * sigma_new;
            let (a, b, c) = (draw(), draw(), draw());
            if pulse == 0 {
                for of_y in &mut frequency {
                    of_y.value = sigma_y * draw();
                    begin_y += of_y.value;
                }
                for of_x in &mut phase {
                    of_x.value = sigma_x * draw();
                    begin_x += of_x.value;
                }
            } else {
                x += (0.5 * white * dt).sqrt() * c;
                // Value and integral of a walk: the integral is y dt, half of what is new, and a part of its
                // own.
                let step = (diffusion * dt).sqrt() * a;
                x += dt * (y_walk + 0.5 * step) + (diffusion * dt * dt * dt / 12.0).sqrt() * b;
                y_walk += step;
                x -= begin_y * dt;
                for of_y in &mut frequency {
                    let [value, cross, square] = added(of_y.rate, dt);
                    let (m, n) = (draw(), draw());
                    let root = value.sqrt();
                    let own = (square - cross * cross / value).max(0.0).sqrt();
                    x += of_y.value * -(-of_y.rate * dt).exp_m1() / of_y.rate
                        + sigma_y * (cross / root * m + own * n);
                    of_y.value = of_y.value * (-of_y.rate * dt).exp() + sigma_y * root * m;
                }
                for of_x in &mut phase {
                    let [value, ..] = added(of_x.rate, dt);
                    of_x.value = of_x.value * (-of_x.rate * dt).exp() + sigma_x * value.sqrt() * draw();
                }
            }
            let slow = phase.iter().map(|p| p.value).sum::<f64>() - begin_x;
            let y = y_walk + frequency.iter().map(|p| p.value).sum::<f64>() - begin_y;
            [x + slow + fresh, y]
        })
        .collect()
}
