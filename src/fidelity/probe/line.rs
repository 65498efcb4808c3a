//! Upper bound on the error, and the power, of point scatterers along delay.
//!
//! Points keep their phases: two in one resolution cell may add up, or cancel, for a whole run. The **power**
//! of a pulse is the sum of amplitudes with their phases. Points within a cell of each other have the weight
//! `(1 - d^2)^2`, `d` in cells: nearly the `sinc` of a linear sweep.
//!
//! The upper bound on the error (or power) of a pulse, of moduli `m_i`, is
//!
//! `W = sum over i of m_i * sum over j of m_j` , `|tau_j - tau_i|` within [`REACH_CELLS`].
//!
//! * Sums go over some cells: the error of a pulse lies at its ends and at those of its band, and is alike
//!   over some cells. Two targets of equal Doppler off the mean, 1.26 cells apart, had 2.6 dB more than the
//!   sum of their powers.
//! * Where there is more than one point, `W` is multiplied by [`SIDE_LOBES`], for the range side lobes of
//!   others.
//! * `W` is no more than points of random phases add up to at their worst, each cell with an exponential law
//!   ([`worst`](crate::fidelity::worst)), times the largest ratio of an echo of the run to the sum of its
//!   powers: a plate flashes.

use num_complex::Complex64;

use crate::fidelity::worst::worst_of;

/// Most points whose phases count in the power of a pulse; of more, powers are added.
const MOST_COHERENT: usize = 4096;
/// The least that is left of points that cancel, of the sum of their powers.
const LEAST_COHERENT: f64 = 1e-9;
/// Cells within which what is left of two points may be in phase.
const REACH_CELLS: f64 = 3.0;
/// What other cells add, were the first side lobe of one in phase: -13.26 dB of a linear sweep.
const SIDE_LOBES: f64 = 1.22;

/// Points of a pulse and pair in the order of their delays: `(delay in cells, point)`.
pub(super) struct Line(Vec<(f64, usize)>);

impl Line {
    pub(super) fn new(delays_s: &[f64], cells_per_s: f64) -> Self {
        let mut line: Vec<_> = delays_s.iter().map(|delay_s| delay_s * cells_per_s).zip(0..).collect();
        line.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(line)
    }

    /// The most that moduli add up to in a pulse: random phases are taken so many deviations up, and at so
    /// much more as echoes of the run are coherent.
    pub(super) fn most(&self, [deviations, coherence]: [f64; 2], modulus: impl Fn(usize) -> f64) -> f64 {
        let terms: Vec<(f64, f64)> = self
            .0
            .iter()
            .map(|(cell, n)| (*cell, modulus(*n)))
            .filter(|(_, modulus)| *modulus > 0.0)
            .collect();
        if terms.len() < 2 {
            return terms.iter().map(|(_, modulus)| modulus * modulus).sum();
        }
        (SIDE_LOBES * in_phase(&terms)).min(coherence * of_random_phases(&terms, deviations))
    }

    /// Power of amplitudes with their phases.
    pub(super) fn power(&self, amplitude: impl Fn(usize) -> Complex64) -> f64 {
        let terms: Vec<(f64, Complex64)> = self
            .0
            .iter()
            .map(|(cell, n)| (*cell, amplitude(*n)))
            .filter(|(_, a)| a.norm_sqr() > 0.0)
            .collect();
        let each: f64 = terms.iter().map(|(_, a)| a.norm_sqr()).sum();
        if terms.len() > MOST_COHERENT {
            return each;
        }
        let mut both = 0.0;
        for (n, (cell, a)) in terms.iter().enumerate() {
            for (other, b) in terms[n + 1..].iter().take_while(|(other, _)| *other < cell + 1.0) {
                both += 2.0 * (a * b.conj()).re * (1.0 - (other - cell).powi(2)).powi(2);
            }
        }
        (each + both).max(LEAST_COHERENT * each)
    }
}

/// The most that terms in the order of their places add up to, all within reach in phase.
fn in_phase(terms: &[(f64, f64)]) -> f64 {
    let (mut from, mut to, mut near, mut sum) = (0, 0, 0.0, 0.0);
    for (n, (cell, modulus)) in terms.iter().enumerate() {
        while terms.get(to).is_some_and(|(other, _)| *other < cell + REACH_CELLS) {
            near += terms[to].1;
            to += 1;
        }
        while from < n && terms[from].0 <= cell - REACH_CELLS {
            near -= terms[from].1;
            from += 1;
        }
        sum += modulus * f64::max(near, *modulus);
    }
    sum
}

/// The most that they add up to with random phases: an exponential law in every cell.
fn of_random_phases(terms: &[(f64, f64)], deviations: f64) -> f64 {
    let (mut all, mut squares) = (0.0, 0.0);
    for cell in terms.chunk_by(|a, b| a.0.floor() == b.0.floor()) {
        let own: f64 = cell.iter().map(|(_, modulus)| modulus * modulus).sum();
        (all, squares) = (all + own, squares + own * own);
    }
    all * worst_of(squares / (all * all), deviations)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_within_reach_add_in_phase() {
        // Alone, three within reach, and a chain of which only neighbours are.
        for (terms, wanted) in [
            (vec![(7.0, 3.0)], 9.0),
            (vec![(7.0, 2.0), (7.2, 1.0), (7.9, 3.0)], 36.0),
            (vec![(0.0, 1.0), (2.0, 1.0), (4.0, 1.0)], 2.0 + 3.0 + 2.0),
            (vec![(0.0, 1.0), (3.0, 1.0), (9.0, 2.0)], 6.0),
            (vec![], 0.0),
        ] {
            assert!((in_phase(&terms) - wanted).abs() < 1e-12, "{terms:?}");
        }
        // Places that f64 no longer resolves.
        assert!(in_phase(&[(1e300, 1.0), (1e300, 1.0), (f64::INFINITY, 1.0)]).is_finite());
    }

    #[test]
    fn many_points_do_not_all_add_up() {
        let line = |count: usize, per_cell: f64| {
            let delays_s: Vec<f64> = (0..count).map(|n| n as f64 / per_cell).collect();
            Line::new(&delays_s, 1.0)
        };
        // Two may; of a thousand in ten cells each cell has an exponential law.
        assert!((line(2, 10.0).most([4.0, 1.0], |_| 1.0) - 4.0 * SIDE_LOBES).abs() < 1e-12);
        assert!((line(1000, 100.0).most([4.0, 1.0], |_| 1.0) / 1000.0 - worst_of(0.1, 4.0)).abs() < 1e-9);
        assert_eq!(line(1, 1.0).most([4.0, 1.0], |_| 3.0), 9.0);
        assert_eq!(line(0, 1.0).most([4.0, 1.0], |_| 3.0), 0.0);
    }

    #[test]
    fn phases_count_in_the_power() {
        let of = |places: &[f64], amplitudes: &[f64]| {
            Line::new(places, 1.0).power(|n| Complex64::new(amplitudes[n], 0.0))
        };
        assert_eq!(of(&[3.0, 3.0], &[1.0, 1.0]), 4.0);
        assert_eq!(of(&[3.0, 4.0], &[1.0, -1.0]), 2.0);
        // Within one per cent of 2 - 2 sinc(0.1) in power, and never nothing.
        let sinc = |d: f64| (std::f64::consts::PI * d).sin() / (std::f64::consts::PI * d);
        assert!((of(&[3.0, 3.1], &[1.0, 1.0]) - (2.0 + 2.0 * sinc(0.1))).abs() < 0.01);
        assert_eq!(of(&[3.0, 3.0], &[1.0, -1.0]), 2.0 * LEAST_COHERENT);
        assert_eq!(of(&[], &[]), 0.0);
    }
}
