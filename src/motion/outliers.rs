//! Fixes that do not belong to their neighbours.
//!
//! *Before* smoothing: each fix is held against the median of the straight lines through pairs of its
//! neighbours, up to [`REACH`] on either side (two wrong ones among eight do not reach the median). Its
//! distance d from there is an outlier when `d > GATE max(sigma, 1.4826 median |d|)`, the median over the
//! fixes near it, so that a turn, where all distances grow, rejects nothing (F. R. Hampel, *J. Am. Stat.
//! Assoc.* 69 (1974) 383).
//!
//! *After* smoothing: a rejected fix whose residual is below the bound comes back; a used fix whose residual
//! is above the bound and three times those of its neighbours (isolated) goes.

/// Neighbours on either side that are asked.
pub const REACH: usize = 4;
/// Standard deviations beyond which a fix is an outlier.
pub const GATE: f64 = 6.0;
/// Standard deviation of a normal distribution over its median absolute value.
const MEDIAN_TO_SIGMA: f64 = 1.482_6;
/// Fixes on either side that say how large a distance is usual there.
const NEIGHBOURHOOD: usize = 15;
/// Times the usual residual beside it that an isolated residual exceeds.
const ISOLATED: f64 = 3.0;

fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    let (_, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    if values.len() % 2 == 1 {
        return upper;
    }
    let lower = values[..middle].iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}

/// Distance of each fix from the lines through its neighbours, one coordinate.
pub(super) fn deviations(t_s: &[f64], z_m: &[f64]) -> Vec<f64> {
    let n = z_m.len();
    let mut lines = Vec::new();
    (0..n)
        .map(|i| {
            lines.clear();
            let near = i.saturating_sub(REACH)..(i + REACH + 1).min(n);
            for a in near.clone().filter(|&a| a != i) {
                let line = |b: usize| z_m[a] + (z_m[b] - z_m[a]) * (t_s[i] - t_s[a]) / (t_s[b] - t_s[a]);
                lines.extend((a + 1..near.end).filter(|&b| b != i).map(line));
            }
            if lines.is_empty() { 0.0 } else { z_m[i] - median(&mut lines) }
        })
        .collect()
}

/// Which fixes pass the bound, from their distances.
pub(super) fn gate(distance_m: &[f64], sigma_m: f64) -> Vec<bool> {
    let n = distance_m.len();
    let mut near = Vec::new();
    (0..n)
        .map(|i| {
            near.clear();
            near.extend_from_slice(
                &distance_m[i.saturating_sub(NEIGHBOURHOOD)..(i + NEIGHBOURHOOD + 1).min(n)],
            );
            distance_m[i] <= GATE * sigma_m.max(MEDIAN_TO_SIGMA * median(&mut near))
        })
        .collect()
}

/// Which fixes pass the bound after smoothing, from their residuals.
pub(super) fn regate(residual_m: &[f64], used: &[bool], sigma_m: f64) -> Vec<bool> {
    let n = residual_m.len();
    let mut all: Vec<f64> = residual_m.iter().zip(used).filter(|(_, used)| **used).map(|(r, _)| *r).collect();
    let limit = GATE * sigma_m.max(MEDIAN_TO_SIGMA * median(&mut all));
    let mut near = Vec::new();
    (0..n)
        .map(|i| {
            if residual_m[i] <= limit {
                return true;
            }
            near.clear();
            let window = i.saturating_sub(NEIGHBOURHOOD)..(i + NEIGHBOURHOOD + 1).min(n);
            near.extend(window.filter(|&j| used[j] && j != i).map(|j| residual_m[j]));
            used[i] && residual_m[i] <= ISOLATED * MEDIAN_TO_SIGMA * median(&mut near)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_are_found_and_turns_are_not() {
        let t: Vec<f64> = (0..60).map(f64::from).collect();
        // A turn of 4 m/s^2 starts at 30.
        let mut z: Vec<f64> = t.iter().map(|t| 100.0 * t + 2.0 * (t - 30.0).max(0.0).powi(2)).collect();
        let distances = |z: &[f64]| deviations(&t, z).iter().map(|d| d.abs()).collect::<Vec<_>>();
        assert!(gate(&distances(&z), 5.0).iter().all(|pass| *pass));
        for (at, jump) in [(0, 3000.0), (10, 9000.0), (11, 9000.0), (40, -500.0), (59, 1000.0)] {
            z[at] += jump;
        }
        let pass = gate(&distances(&z), 5.0);
        let rejected: Vec<usize> = (0..60).filter(|&i| !pass[i]).collect();
        assert_eq!(rejected, [0, 10, 11, 40, 59]);
    }

    #[test]
    fn medians() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&mut []), 0.0);
    }
}
