//! How the waves of a surface move a ship: heave, pitch and roll at any time of a run.
//!
//! At midship, which sails at `x = x_0 + v t` over the mean sea, every motion is
//!
//! `m(t) = sum over K of Re 2 a(K) M(K) e^{j (K.x_0 - w_e t)}` , `w_e = w(K) - K.v` ,
//!
//! over the very waves of the facets, with the transfer functions `M` of [`crate::sea::seakeeping`]. It is
//! summed at time samples so close that the fastest of these waves turns by half a radian, with rates and
//! accelerations, and quintic Hermite in between (off by 4e-7 of a wave). Waves that move no point of the
//! hull by more than [`LEAST`] of their height are left out.

use num_complex::Complex64;

use crate::paths::waves::{Component, Series, components, quintic};
use crate::scene::Ship;
use crate::scene::ship::{HullForm, ShipMotion};
use crate::sea::seakeeping::Seakeeping;
use crate::sea::surface::Surface;

/// Share of its height by which a wave that counts moves some end of the hull.
const LEAST: f64 = 1e-3;
/// Bound on rates, in deviations.
const DEVIATIONS: f64 = 6.0;

/// The waves of a run that ships ride.
#[derive(Clone, Copy, Debug)]
pub(in crate::paths) struct Seas<'a> {
    pub surface: &'a Surface,
    /// Last emission after pulse 0, s.
    pub last_s: f64,
}

/// A wave as a ship meets it: frequency, rad/s, and what it does at pulse 0: heave, m, pitch and roll, rad.
#[derive(Clone, Copy, Debug)]
struct Met {
    met: f64,
    moves: [Complex64; 3],
}

/// Heave, m, pitch, bow up, and roll, port up, rad; and their rates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moved {
    pub value: [f64; 3],
    pub rate: [f64; 3],
}

/// What moves one ship.
#[derive(Debug)]
pub(super) struct Motion {
    waves: Vec<Met>,
    /// Value, rate and acceleration of every motion.
    series: Series<[[f64; 3]; 3]>,
    /// Largest rates of the run, or so.
    rates: [f64; 3],
}

impl Motion {
    /// Of a ship that is asked to ride the waves, if there are any.
    pub fn of(ship: &Ship, seas: Option<Seas<'_>>) -> Option<Self> {
        let (ShipMotion::Waves { roll_period_s, form: Some(form) }, Some(seas)) = (ship.mesh.motion, seas)
        else {
            return None;
        };
        let hull = Seakeeping::new(&form, roll_period_s);
        let (sin, cos) = ship.heading_rad.sin_cos();
        let velocity = [ship.speed_mps * cos, ship.speed_mps * sin];
        let [x_m, y_m] = ship.position_m;
        let feels = |wave: Component| {
            let (k, met) = (wave.k, wave.met(velocity));
            let own = [k[0] * cos + k[1] * sin, k[1] * cos - k[0] * sin];
            let transfer = hull.transfer(own, wave.omega, met);
            if farthest(&form, &transfer) < LEAST {
                return None;
            }
            let here = wave.amplitude * Complex64::cis(k[0] * x_m + k[1] * y_m);
            Some(Met { met, moves: transfer.map(|moves| moves * here) })
        };
        let waves: Vec<Met> = components(seas.surface).filter_map(feels).collect();
        let fastest = waves.iter().map(|wave| wave.met.abs()).fold(0.0, f64::max);
        let rates = [0, 1, 2].map(|i| {
            let variance: f64 =
                waves.iter().map(|wave| 0.5 * wave.moves[i].norm_sqr() * wave.met.powi(2)).sum();
            DEVIATIONS * variance.sqrt()
        });
        Some(Self { series: Series::new(fastest, seas.last_s), waves, rates })
    }

    /// The motion at a time after pulse 0.
    pub fn at(&self, elapsed_s: f64) -> Moved {
        let (number, s) = self.series.before(elapsed_s);
        let [before, after] = [number, number + 1].map(|number| self.series.knot(number, |t| self.sum(t)));
        let h = self.series.apart_s();
        let of = [0, 1, 2].map(|i| quintic(h, s, before[i], after[i]));
        Moved { value: of.map(|[value, _]| value), rate: of.map(|[_, rate]| rate) }
    }

    /// No motion of the run is faster, or hardly: m/s, rad/s, rad/s.
    pub fn rates(&self) -> [f64; 3] {
        self.rates
    }

    fn sum(&self, time_s: f64) -> [[f64; 3]; 3] {
        let mut sums = [[0.0; 3]; 3];
        for Met { met, moves } in &self.waves {
            let turned = Complex64::cis(-met * time_s);
            for (sum, moves) in sums.iter_mut().zip(moves) {
                let wave = moves * turned;
                *sum = [sum[0] + wave.re, sum[1] + met * wave.im, sum[2] - met * met * wave.re];
            }
        }
        sums
    }
}

/// How far a wave of unit height moves some end of a hull.
fn farthest(form: &HullForm, [heave, pitch, roll]: &[Complex64; 3]) -> f64 {
    heave.norm() + 0.5 * form.length_m * pitch.norm() + 0.5 * form.beam_m * roll.norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::cases::sized;
    use crate::scene::ship::{HullGiven, ShipMesh};
    use crate::scene::water::{Development, Dispersion, WindProfile};
    use crate::sea::spectrum::{Elfouhaily, Spectrum, WaveVector};
    use crate::sea::surface::{Averaging, Grid};
    use crate::sea::wind::Wind;

    const FORM: HullForm = HullForm { length_m: 30.0, beam_m: 7.0, draught_m: 2.2, block: 0.6 };
    const SPEED_MPS: f64 = 3.0;
    const HEADING_RAD: f64 = 0.8;

    fn ship(motion: ShipMotion) -> Ship {
        Ship {
            name: "tug".to_owned(),
            hull: HullGiven::Wigley { beam_m: 7.0, draught_m: 2.2 },
            length_m: Some(30.0),
            position_m: [12.0, -7.0],
            heading_rad: HEADING_RAD,
            speed_mps: SPEED_MPS,
            kelvin: None,
            turbulent: None,
            echo: false,
            mesh: ShipMesh { motion, ..ShipMesh::default() },
            trajectory: None,
            panels: Default::default(),
        }
    }

    fn waves() -> ShipMotion {
        ShipMotion::Waves { roll_period_s: Some(6.0), form: Some(FORM) }
    }

    fn spectrum() -> Elfouhaily {
        let wind = Wind::from_speed(9.0, 10.0, WindProfile::Cardone, 0.2).unwrap();
        Elfouhaily::new(&wind, Development::InverseWaveAge(0.84)).unwrap()
    }

    fn surface(seed: u64) -> Surface {
        let grid = Grid::new(64, 64, 4.0).unwrap();
        Surface::synthesise(grid, &spectrum(), Dispersion::default(), seed, Averaging::Points).unwrap()
    }

    /// Mean square of heave, pitch and roll over ten minutes and some seas: the integral of the response
    /// squared over the spectrum, as a sum over the grid of wave numbers, within four of its deviations.
    #[test]
    fn variances_are_integrals_over_the_spectrum() {
        let (hull, spectrum) = (Seakeeping::new(&FORM, Some(6.0)), spectrum());
        let (sin, cos) = HEADING_RAD.sin_cos();
        let dk = std::f64::consts::TAU / 256.0;
        let (mut wanted, mut squares) = ([0.0; 3], [0.0; 3]);
        for (mx, my) in (-31..32).flat_map(|mx| (-31..32).map(move |my| (mx, my))).filter(|m| *m != (0, 0)) {
            let k = [f64::from(mx) * dk, f64::from(my) * dk];
            let omega = (9.81 * k[0].hypot(k[1])).sqrt();
            let ahead = k[0] * cos + k[1] * sin;
            let answer = hull.transfer([ahead, k[1] * cos - k[0] * sin], omega, omega - SPEED_MPS * ahead);
            let variance = spectrum.wave_m4(WaveVector::new(k[0], k[1])) * dk * dk;
            for (i, answer) in answer.iter().enumerate() {
                let own = variance * answer.norm_sqr();
                (wanted[i], squares[i]) = (wanted[i] + own, squares[i] + own * own);
            }
        }
        let (seas, instants) = (sized(24u32, 12), 300u32);
        let mut found = [0.0; 3];
        for seed in 0..seas {
            let surface = surface(u64::from(seed));
            let motion = Motion::of(&ship(waves()), Some(Seas { surface: &surface, last_s: 600.0 })).unwrap();
            for n in 0..instants {
                let moved = motion.at(2.0 * f64::from(n));
                found = [0, 1, 2].map(|i| found[i] + moved.value[i].powi(2) / f64::from(seas * instants));
            }
        }
        for i in 0..3 {
            // A wave's power is exponential from sea to sea; over the run others beat with it, some ten of
            // its periods apart, which adds as much again at most.
            let deviation = (2.0 * squares[i] / f64::from(seas)).sqrt() / wanted[i];
            let off = found[i] / wanted[i] - 1.0;
            println!("{i}: rms {:.4}, off by {off:.3}, deviation {deviation:.3}", wanted[i].sqrt());
            assert!(off.abs() < 4.0 * deviation && deviation < 0.2, "{i}: {off} {deviation}");
        }
        assert!(wanted[0].sqrt() > 0.1 && wanted[2].sqrt() > 0.01, "{wanted:?}");
    }

    /// Rates are those of the values, between time samples too; so is the sum itself.
    #[test]
    fn rates_are_those_of_the_values() {
        let surface = surface(5);
        let motion = Motion::of(&ship(waves()), Some(Seas { surface: &surface, last_s: 20.0 })).unwrap();
        assert!(motion.series.apart_s() <= 0.2);
        for n in 0..400 {
            // Beyond the time samples that are kept as well.
            let (t, h) = (0.0731 * f64::from(n), 1e-4);
            let [before, now, after] = [t, t + h, t + 2.0 * h].map(|t| motion.at(t));
            let exact = motion.sum(t + h);
            for (i, [value, rate, _]) in exact.into_iter().enumerate() {
                let slope = (after.value[i] - before.value[i]) / (2.0 * h);
                assert!((slope - now.rate[i]).abs() < 1e-6, "{t} {i}: {slope} {}", now.rate[i]);
                assert!((value - now.value[i]).abs() < 1e-6, "{t} {i}");
                assert!((rate - now.rate[i]).abs() < 2e-5, "{t} {i}");
                assert!(now.rate[i].abs() < motion.rates()[i]);
            }
        }
    }

    /// A ship that is level, and one where there is no sea, do not move.
    #[test]
    fn level_ships_do_not_move() {
        let surface = surface(1);
        assert!(
            Motion::of(&ship(ShipMotion::Level), Some(Seas { surface: &surface, last_s: 1.0 })).is_none()
        );
        assert!(Motion::of(&ship(waves()), None).is_none());
    }
}
