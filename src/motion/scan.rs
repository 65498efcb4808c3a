//! Scanning pedestals: azimuth and elevation as functions of time, and what an encoder reads of them.
//!
//! **Rotation** at a rate `w`: `az = az_0 + w t`.
//!
//! **Sector** from `a` to `b` at a rate `w`, `T = |b - a| / w`, with turns of `D`: sweep `n` begins at
//! `n (T + D)` and goes at the constant rate `w`, forth for even `n`, back for odd. In the turn that follows
//! it, `u` from 0 to 1, the rate falls through 0 to its opposite, and the elevation goes from that of the
//! sweep to that of the next:
//!
//! `az = b +- w D u (1 - u)`, `el = e_n + (e_n+1 - e_n) (3 u^2 - 2 u^3)`.
//!
//! So rates are continuous, and the pedestal runs past either end by `w D / 4`.
//!
//! **Steps** through `K` directions, each for `D`: number `floor(t / D) mod K`.
//!
//! **Encoder**: `reading = az + bias + noise`, rounded to `360 / 2^bits` degrees, in `[0, 360)`; the same
//! without the bias for the elevation. Numbers of the noise belong to the pulse.
//!
//! ```
//! use nereus::motion::scan::direction;
//! use nereus::scene::radar::ScanLaw;
//! let turn = ScanLaw::Rotation { rate_rad_per_s: 2.0, start_rad: 0.5, elevation_rad: 0.1 };
//! assert_eq!(direction(&turn, 3.0), [6.5, 0.1]);
//! ```

use std::f64::consts::TAU;

use rand_distr::{Distribution, StandardNormal};

use crate::rng::{Room, stream};
use crate::scene::radar::{Encoder, ScanLaw};

/// What instants may be early and still belong to the next direction, of a pulse.
const TIE_PULSES: f64 = 1e-3;

/// Azimuth and elevation so long after pulse 0, rad. The azimuth of a rotation is not reduced to a turn.
pub fn direction(law: &ScanLaw, t_s: f64) -> [f64; 2] {
    match *law {
        ScanLaw::Steps { ref directions_rad, dwell_pulses, dwell_s } => {
            let number = (t_s / dwell_s + TIE_PULSES / dwell_pulses.max(1) as f64).floor();
            let place = number.rem_euclid(directions_rad.len().max(1) as f64) as usize;
            directions_rad.get(place).copied().unwrap_or([0.0; 2])
        }
        ScanLaw::Rotation { rate_rad_per_s, start_rad, elevation_rad } => {
            [start_rad + rate_rad_per_s * t_s, elevation_rad]
        }
        ScanLaw::Sector { from_rad, to_rad, rate_rad_per_s, turn_s, ref elevations_rad } => {
            let (width_rad, sense) = ((to_rad - from_rad).abs(), (to_rad - from_rad).signum());
            let sweep_s = width_rad / rate_rad_per_s;
            let number = (t_s / (sweep_s + turn_s)).floor();
            let since_s = t_s - number * (sweep_s + turn_s);
            let is_back = number.rem_euclid(2.0) >= 1.0;
            let (begin_rad, rate) = if is_back { (to_rad, -sense) } else { (from_rad, sense) };
            let rate = rate * rate_rad_per_s;
            let elevation = |sweep: f64| {
                let place = sweep.rem_euclid(elevations_rad.len().max(1) as f64) as usize;
                elevations_rad.get(place).copied().unwrap_or(0.0)
            };
            if since_s <= sweep_s {
                return [begin_rad + rate * since_s, elevation(number)];
            }
            let u = ((since_s - sweep_s) / turn_s).clamp(0.0, 1.0);
            let [now, next] = [elevation(number), elevation(number + 1.0)];
            let past_rad = rate * turn_s * u * (1.0 - u);
            [begin_rad + rate * sweep_s + past_rad, now + (next - now) * u * u * (3.0 - 2.0 * u)]
        }
    }
}

/// What the encoder of an antenna reads at a pulse where it points so: azimuth in `[0, 360)` and elevation,
/// degrees. Antennas count as in a recording.
pub fn reading_deg(
    encoder: &Encoder,
    direction_rad: [f64; 2],
    seed: u64,
    (pulse, antenna): (u64, usize),
) -> [f64; 2] {
    let Encoder { bias_rad, noise_rad, bits } = *encoder;
    let mut noise = [0.0; 2];
    if noise_rad > 0.0 {
        let mut numbers = stream(seed, Room::Encoder, pulse, antenna as u64);
        noise = noise.map(|_| noise_rad * Distribution::<f64>::sample(&StandardNormal, &mut numbers));
    }
    let [az, el] = [direction_rad[0] + bias_rad + noise[0], direction_rad[1] + noise[1]];
    let step = bits.map(|bits| TAU / f64::from(1u32 << bits));
    let [az, el] = [az, el].map(|angle| step.map_or(angle, |step| (angle / step).round() * step));
    let az_deg = az.rem_euclid(TAU).to_degrees();
    [if az_deg < 360.0 { az_deg } else { 0.0 }, el.to_degrees()]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECTOR: [f64; 4] = [0.3, -0.9, 0.5, 0.2];

    fn sector(elevations_rad: Vec<f64>) -> ScanLaw {
        let [from_rad, to_rad, rate_rad_per_s, turn_s] = SECTOR;
        ScanLaw::Sector { from_rad, to_rad, rate_rad_per_s, turn_s, elevations_rad }
    }

    #[test]
    fn a_sector_is_swept_to_and_fro_and_its_rate_does_not_jump() {
        let law = sector(vec![0.0, 0.1, 0.2]);
        let [from, to, rate, turn_s] = SECTOR;
        let sweep_s = (to - from).abs() / rate;
        let period_s = sweep_s + turn_s;
        for (t_s, az, el) in [
            (0.0, from, 0.0),
            (sweep_s, to, 0.0),
            (period_s, to, 0.1),
            (period_s + sweep_s, from, 0.1),
            (2.0 * period_s, from, 0.2),
            (3.0 * period_s, to, 0.0),
            (6.0 * period_s + 0.4, from - 0.2, 0.0),
            // Before the run it swept already.
            (-period_s, to, 0.2),
            (-turn_s, from, 0.2),
        ] {
            let found = direction(&law, t_s);
            assert!((found[0] - az).abs() < 1e-12 && (found[1] - el).abs() < 1e-12, "{t_s}: {found:?}");
        }
        let h = 1e-6;
        let rate_at = |t_s: f64| {
            let [a, b] = [t_s, t_s + h].map(|t| direction(&law, t));
            [0, 1].map(|axis| (b[axis] - a[axis]) / h)
        };
        let mut before = rate_at(0.0);
        for step in 1..20_000 {
            let now = rate_at(f64::from(step) * 1e-3);
            // The greatest acceleration: that of a turn, 2 w / D, and 6 de / D^2.
            assert!((now[0] - before[0]).abs() < 1.1e-3 * 2.0 * rate / turn_s, "{step}");
            assert!((now[1] - before[1]).abs() < 1.1e-3 * 6.0 * 0.2 / (turn_s * turn_s), "{step}");
            before = now;
        }
    }

    #[test]
    fn steps_stay_and_jump_at_their_pulses() {
        let directions_rad = vec![[0.1, 0.0], [0.2, -0.1], [0.3, 0.0]];
        let pri_s = 1.0 / 3.0e3;
        let law =
            ScanLaw::Steps { directions_rad: directions_rad.clone(), dwell_pulses: 7, dwell_s: 7.0 * pri_s };
        for pulse in (0..2000u64).chain(3_000_000_000..3_000_000_050) {
            let wanted = directions_rad[(pulse / 7 % 3) as usize];
            assert_eq!(direction(&law, pulse as f64 * pri_s), wanted, "{pulse}");
        }
        assert_eq!(direction(&law, -pri_s), directions_rad[2]);
    }

    #[test]
    fn an_encoder_reads_bias_noise_and_steps() {
        let plain = Encoder::default();
        assert_eq!(reading_deg(&plain, [-0.5 * TAU / 360.0, 0.0], 1, (0, 0)), [359.5, 0.0]);
        let coarse = Encoder { bias_rad: 1f64.to_radians(), noise_rad: 0.0, bits: Some(12) };
        let [az, _] = reading_deg(&coarse, [10f64.to_radians(), 0.0], 1, (0, 0));
        assert!((az / (360.0 / 4096.0)).fract() < 1e-9 && (az - 11.0).abs() <= 180.0 / 4096.0, "{az}");
        let noisy = Encoder { noise_rad: 0.1f64.to_radians(), ..plain };
        let errors: Vec<f64> = (0..4000)
            .map(|pulse| reading_deg(&noisy, [1.0, 0.0], 1, (pulse, 2))[0] - 1f64.to_degrees())
            .collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 4000.0).sqrt();
        // The standard error of an rms of 4000 is 1.1 %.
        assert!((rms / 0.1 - 1.0).abs() < 0.05, "{rms}");
        assert_eq!(
            reading_deg(&coarse, [f64::from_bits(TAU.to_bits() - 1), 0.0], 1, (0, 0))[0].to_bits() >> 63,
            0
        );
    }
}
