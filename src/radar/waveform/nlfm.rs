//! Nonlinear frequency modulation: a sweep that dwells where its power spectrum is to be high.
//!
//! A taper `W(f) = 1 + 2 sum_m F_m cos(2 pi m f/B)` over the band `|f| <= B/2` is to be the power spectrum,
//! so that the compressed pulse has the side lobes of `W` although its amplitude is constant. By the
//! principle of stationary phase the sweep then spends a time in proportion to `W` at every frequency: with
//! `x = f/B` and `y = t/Tc - 1/2` the instantaneous frequency `B x(y)` and the phase `theta` of a rising
//! sweep are
//!
//! ```text
//! y(x) = x + sum_m F_m sin(2 pi m x)/(pi m) ,   y(+-1/2) = +-1/2
//! theta = 2 pi B Tc [x y - x^2/2 + sum_m F_m (cos(2 pi m x) - 1)/(2 pi^2 m^2)] ,   p(t) = e^{j theta}
//! ```
//!
//! `theta` is the Legendre transform of the integral of `y`, so `dtheta/dy = 2 pi B Tc x` exactly. A falling
//! sweep is the conjugate. Side lobes come near to those of the taper from `B Tc` of some hundreds on; below,
//! the edges of the pulse decide.
//!
//! | taper | `F_m` | side lobes |
//! | --- | --- | --- |
//! | Hamming | `F_1 = 0.46/1.08` | -42.7 dB |
//! | Taylor | of the least order from `2 A^2 + 1/2` on, `A = acosh(10^(dB/20))/pi` | as asked |
//!
//! There is no closed form of `P`. From `-F` to `F` it is read from a table of 16 entries per `1/Tc`, made by
//! Gauss's rule of 16 points on parts of the pulse over which `e^{j theta - j 2 pi f t}` turns by 16 rad at
//! most; interpolated as [`Sampled`](super::Sampled) has it. Beyond, both ends of the pulse are what is left,
//! by parts:
//!
//! ```text
//! int g e^{j h} dt = [e^{j h} sum_n u_n] ,   u_0 = 1/(j h'), u_{n+1} = -u_n'/(j h') ,   h = theta - 2 pi f t
//! ```
//!
//! in powers of `f` about the band's edge, where `y(x)` has a series and `t` is a function of `x`. `F` is the
//! first of `B`, `1.5 B`, `2 B`, ... at which both agree to 1e-11 of `sqrt(Tc/B)`.
//!
//! Source: Cook and Bernfeld, *Radar Signals* (1967), chapter 3; Taylor, IRE Trans. AP-3 (1955) 16.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::table::{self, OVERSAMPLING, POINTS};
use super::{Waveform, WaveformError};
use crate::radar::phasor::phasor;
use crate::radar::taper::taylor;
use crate::scene::radar::{Sweep, Taper};
use crate::units::GAUSS_16;

/// Largest time-bandwidth product: the table takes some tens of MB.
pub const MAX_NONLINEAR: f64 = 20_000.0;
/// Least: what is shorter has no band to be tapered.
pub const MIN_NONLINEAR: f64 = 4.0;
/// Side lobes that a Taylor taper may have, dB.
pub const SIDELOBES_DB: [f64; 2] = [20.0, 60.0];

/// Terms of the expansion at either end.
const TERMS: usize = 8;
/// Turns of the fastest part over half a piece, rad.
const TURN_RAD: f64 = 8.0;
/// What expansion and quadrature may differ by, of `sqrt(Tc/B)`.
const APART: f64 = 1e-11;

/// A nonlinear sweep of unit amplitude.
#[derive(Clone, Debug)]
pub struct Nlfm {
    bandwidth_hz: f64,
    duration_s: f64,
    sweep: Sweep,
    /// `F_m`, `m = 1 ..`.
    terms: Vec<f64>,
    /// Phase at either end, turns.
    edge_turns: f64,
    /// Entry of `f = 0` in the table.
    origin: f64,
    /// `P(f) e^{j pi f Tc}` of the rising sweep at multiples of `1/(16 Tc)`, s.
    table: Vec<Complex64>,
}

impl Nlfm {
    /// A sweep over `bandwidth_hz` in `duration_s`.
    ///
    /// # Errors
    /// A bandwidth, a length, their product or a level of side lobes out of range.
    pub fn new(
        bandwidth_hz: f64,
        duration_s: f64,
        sweep: Sweep,
        taper: Taper,
    ) -> Result<Self, WaveformError> {
        if !(bandwidth_hz > 0.0 && bandwidth_hz.is_finite()) {
            return Err(WaveformError::Bandwidth { bandwidth_hz });
        }
        if !(duration_s > 0.0 && duration_s.is_finite()) {
            return Err(WaveformError::Duration { duration_s });
        }
        let product = bandwidth_hz * duration_s;
        if !(MIN_NONLINEAR..=MAX_NONLINEAR).contains(&product) {
            return Err(WaveformError::Nonlinear { product });
        }
        let terms = match taper {
            Taper::Hamming => vec![0.46 / 1.08],
            Taper::Taylor { sidelobe_db } => {
                if !(SIDELOBES_DB[0]..=SIDELOBES_DB[1]).contains(&sidelobe_db) {
                    return Err(WaveformError::Sidelobe { sidelobe_db });
                }
                taylor(sidelobe_db)
            }
        };
        let mut own =
            Self { bandwidth_hz, duration_s, sweep, terms, edge_turns: 0.0, origin: 0.0, table: Vec::new() };
        own.edge_turns = own.turns(0.5);
        own.tabulate();
        Ok(own)
    }

    /// `y(x)`, and `dy/dx`, which is the taper.
    fn place(&self, x: f64) -> (f64, f64) {
        let (mut y, mut slope) = (x, 1.0);
        for (m, term) in (1..).zip(&self.terms) {
            let turn = phasor(f64::from(m) * x);
            y += term * turn.im / (PI * f64::from(m));
            slope += 2.0 * term * turn.re;
        }
        (y, slope)
    }

    /// `x(y)`, by Newton's rule within an interval that shrinks.
    fn frequency(&self, y: f64) -> f64 {
        let (mut low, mut high) = (-0.5, 0.5);
        let mut x = y.clamp(low, high);
        for _ in 0..60 {
            let (found, slope) = self.place(x);
            let off = found - y;
            *(if off > 0.0 { &mut high } else { &mut low }) = x;
            let next = x - off / slope;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            if (next - x).abs() <= 1e-16 {
                return next;
            }
            x = next;
        }
        x
    }

    /// `theta / (2 pi)` where the frequency is `B x`.
    fn turns(&self, x: f64) -> f64 {
        let mut sum = x * self.place(x).0 - 0.5 * x * x;
        for (m, term) in (1..).map(f64::from).zip(&self.terms) {
            sum += term * (phasor(m * x).re - 1.0) / (2.0 * PI * PI * m * m);
        }
        self.bandwidth_hz * self.duration_s * sum
    }

    /// Makes the table as wide as it must be.
    fn tabulate(&mut self) {
        let product = self.bandwidth_hz * self.duration_s;
        let peak_s = (self.duration_s / self.bandwidth_hz).sqrt();
        let mut reach = 1.0;
        loop {
            // Entries to either side of f = 0.
            let half = (OVERSAMPLING as f64 * reach * product).ceil() as usize + POINTS;
            self.table = self.quadrature(half);
            self.origin = half as f64;
            let from = half - half / 16 - POINTS / 2;
            let apart = |m: usize| {
                let f_hz = m as f64 / (OVERSAMPLING as f64 * self.duration_s);
                (self.table[half + m] - self.beyond(f_hz)).norm() / peak_s
            };
            let worst = (from..half - POINTS / 2).map(apart).fold(0.0, f64::max);
            if worst <= APART || reach >= 64.0 {
                return;
            }
            reach += 0.5;
        }
    }

    /// Centred spectrum at `m/(16 Tc)`, `m = -half ..= half`, s.
    fn quadrature(&self, half: usize) -> Vec<Complex64> {
        let product = self.bandwidth_hz * self.duration_s;
        // Fastest turn, in turns per pulse.
        let fastest = half as f64 / OVERSAMPLING as f64 + 0.5 * product;
        let pieces = ((PI * fastest / TURN_RAD).ceil() as usize).max(4).next_power_of_two();
        let period = OVERSAMPLING * pieces;
        let plan = nereus_fft::forward(period);
        let mut sums = vec![Complex64::ZERO; 2 * half + 1];
        let mut values = vec![Complex64::ZERO; period];
        for (node, weight) in GAUSS_16.iter().flat_map(|(x, w)| [(-x, *w), (*x, *w)]) {
            let within = 0.5 * (1.0 + node);
            values.fill(Complex64::ZERO);
            for (k, value) in values.iter_mut().take(pieces).enumerate() {
                let x = self.frequency((k as f64 + within) / pieces as f64 - 0.5);
                *value = phasor(self.turns(x)) * (0.5 * weight / pieces as f64 * self.duration_s);
            }
            plan.process(&mut values);
            for (m, sum) in (-(half as i64)..).zip(sums.iter_mut()) {
                let bin = m.rem_euclid(period as i64) as usize;
                *sum += values[bin] * phasor(-(m as f64) * within / period as f64);
            }
        }
        // About the middle of the pulse.
        let centred = |(m, sum): (i64, Complex64)| sum * phasor(m as f64 / (2 * OVERSAMPLING) as f64);
        (-(half as i64)..).zip(sums).map(centred).collect()
    }

    /// Centred spectrum of the rising sweep far from its band, s.
    fn beyond(&self, f_hz: f64) -> Complex64 {
        let half_turns = 0.5 * f_hz * self.duration_s;
        let edge = phasor(self.edge_turns);
        // At the end the frequency is B/2, at the begin -B/2: mirrored, the same with f reversed.
        (self.end(f_hz) * phasor(-half_turns) + self.end(-f_hz) * phasor(half_turns)) * edge
    }

    /// `sum_n u_n` at the end of the pulse, s.
    fn end(&self, f_hz: f64) -> Complex64 {
        // In powers of s = x - 1/2: dt/dx = Tc W, and h' = 2 pi B (1/2 + s - f/B).
        let mut taper = [0.0; TERMS];
        taper[0] = 1.0;
        for (m, term) in (1..).map(f64::from).zip(&self.terms) {
            let sign = if m % 2.0 == 0.0 { 2.0 } else { -2.0 };
            let mut power = sign * term;
            for (n, of) in taper.iter_mut().enumerate() {
                // cos(2 pi m s) has even powers alone.
                if n % 2 == 0 {
                    *of += power;
                    power *= -(2.0 * PI * m).powi(2) / ((n + 1) * (n + 2)) as f64;
                }
            }
        }
        let off = 0.5 - f_hz / self.bandwidth_hz;
        // 1/h' in units of 1/(2 pi B), 1/(h' W): by the power series of a quotient.
        let mut slow = [0.0; TERMS];
        (0..TERMS).for_each(|n| slow[n] = (-1.0f64).powi(n as i32) / off.powi(n as i32 + 1));
        let mut step = slow;
        for n in 0..TERMS {
            let known: f64 = (1..=n).map(|k| taper[k] * step[n - k]).sum();
            step[n] = (step[n] - known) / taper[0];
        }
        let scale = 1.0 / (2.0 * PI * self.bandwidth_hz);
        let ratio = scale / self.duration_s;
        // u_n j^(n+1), real.
        let (mut u, mut sum) = (slow, Complex64::ZERO);
        let mut factor = -Complex64::I * scale;
        for n in 0..TERMS {
            sum += factor * u[0];
            // -(1/(j h')) d/dt = j (1/h' W Tc) d/dx.
            factor *= Complex64::I * ratio;
            let mut next = [0.0; TERMS];
            for (k, of) in next.iter_mut().enumerate().take(TERMS - 1 - n) {
                *of = (0..=k).map(|i| (i + 1) as f64 * u[i + 1] * step[k - i]).sum();
            }
            u = next;
        }
        sum
    }
}

impl Waveform for Nlfm {
    fn name(&self) -> &str {
        match self.sweep {
            Sweep::Up => "nlfm up",
            Sweep::Down => "nlfm down",
        }
    }

    fn duration_s(&self) -> f64 {
        self.duration_s
    }

    fn bandwidth_hz(&self) -> f64 {
        self.bandwidth_hz
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        let place = self.origin + f_hz * self.duration_s * OVERSAMPLING as f64;
        let margin = (POINTS / 2) as f64;
        let within = place >= margin && place <= (self.table.len() - 1) as f64 - margin;
        // Even in f, for the pulse is symmetric about its middle.
        let centred = if within { table::at(&self.table, place) } else { self.beyond(f_hz) };
        let centred = match self.sweep {
            Sweep::Up => centred,
            Sweep::Down => centred.conj(),
        };
        centred * phasor(-0.5 * f_hz * self.duration_s)
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        if !(0.0..self.duration_s).contains(&t_s) {
            return Complex64::ZERO;
        }
        let turns = self.turns(self.frequency(t_s / self.duration_s - 0.5));
        match self.sweep {
            Sweep::Up => phasor(turns),
            Sweep::Down => phasor(-turns),
        }
    }
}
