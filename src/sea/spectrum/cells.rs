//! Peaks of a spectrum and its means over cells of wave numbers.

use super::WaveVector;

/// Where a spectrum with one peak inside a band is largest, rad/m.
pub(super) fn peak_rad_m(s: impl Fn(f64) -> f64, [low, high]: [f64; 2]) -> f64 {
    const SCAN: usize = 200;
    let ratio = (high / low).ln() / SCAN as f64;
    let at = |i: f64| low * (i * ratio).exp();
    let mut best = (0, 0.0);
    for i in 0..=SCAN {
        let value = s(at(i as f64));
        if value > best.1 {
            best = (i, value);
        }
    }
    // Golden section in the step to either side.
    let (mut a, mut b) = (best.0 as f64 - 1.0, best.0 as f64 + 1.0);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    while b - a > 1e-9 {
        let (left, right) = (b - golden * (b - a), a + golden * (b - a));
        if s(at(left)) < s(at(right)) {
            a = left;
        } else {
            b = right;
        }
    }
    at(0.5 * (a + b))
}

/// Where S falls to half its peak, below and above; `[0, 0]` without a peak.
pub(super) fn half_power_band_rad_m(s: impl Fn(f64) -> f64, peak_rad_m: f64) -> [f64; 2] {
    let half = 0.5 * s(peak_rad_m);
    if half <= 0.0 {
        return [0.0; 2];
    }
    let edge = |step: f64| {
        let (mut inside, mut outside) = (peak_rad_m, peak_rad_m * step);
        // 1400 steps of 1 percent are six decades: a spectrum that has not fallen by then has no band.
        for _ in 0..1400 {
            if s(outside) < half {
                break;
            }
            inside = outside;
            outside *= step;
        }
        for _ in 0..100 {
            let middle = 0.5 * (inside + outside);
            if s(middle) < half {
                outside = middle;
            } else {
                inside = middle;
            }
        }
        0.5 * (inside + outside)
    };
    [edge(1.0 / 1.01), edge(1.01)]
}

/// Into how many parts a side of the cell at K must be cut for a smooth spectrum, K^-4 at its steepest
/// beyond the peak; 0 where the value at the centre does (beyond 32 cells from the origin it is within
/// `16/24/32^2 = 7e-4` of the mean).
pub(super) fn divisions(k: WaveVector, dk_rad_m: [f64; 2]) -> usize {
    match k.magnitude() / dk_rad_m[0].max(dk_rad_m[1]) {
        r if r < 3.0 => 8,
        r if r < 8.0 => 3,
        r if r < 32.0 => 1,
        _ => 0,
    }
}

/// Mean over a cell by the 3 x 3 rule of Gauss in each of `divisions^2` parts; the centre's value for 0.
/// Nodes are symmetric, so the means at K and -K of a half-circle spectrum add up to twice the mean of
/// the symmetric one, exactly.
pub(super) fn cell_mean(
    psi: impl Fn(WaveVector) -> f64,
    k: WaveVector,
    dk_rad_m: [f64; 2],
    divisions: usize,
) -> f64 {
    if divisions == 0 {
        return psi(k);
    }
    // Nodes and weights on [-1, 1].
    let nodes = [(-0.6f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)];
    let n = divisions as f64;
    let mut sum = 0.0;
    for i in 0..divisions {
        for j in 0..divisions {
            for (u, weight_u) in nodes {
                for (v, weight_v) in nodes {
                    // Offsets in half cells.
                    let du = (2.0 * i as f64 + 1.0 + u - n) / n;
                    let dv = (2.0 * j as f64 + 1.0 + v - n) / n;
                    let at = WaveVector::new(
                        k.x_rad_m + 0.5 * du * dk_rad_m[0],
                        k.y_rad_m + 0.5 * dv * dk_rad_m[1],
                    );
                    sum += weight_u * weight_v * psi(at);
                }
            }
        }
    }
    sum / (4.0 * n * n)
}
