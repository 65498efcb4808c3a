//! From the mean error of a pulse to that of the worst of many.
//!
//! The terms `e_i` that facets add to an error `S = sum e_i` are means over their phases: in a pulse the
//! facets of a resolution cell `c` interfere, and another pulse has other facets there. A sample takes runs
//! of neighbours, a share `f` of all. With `S_tc` the sum of a run's facets in a cell, the error of a pulse
//! is spread about `S` by
//!
//! `v = (sum over c of (sum over t of S_tc)^2 - (1 - f) sum of S_tc^2) / S^2`:
//!
//! speckle, and facets that come and go; squares of runs count by their share, since the whole patch has
//! `1/f` times as many of them. It is next to nothing over hundreds of cells, and that of an exponential law,
//! `v = 1`, where one cell or facet decides. The worst of `n` pulses and channels is taken `z = sqrt(2 ln n)`
//! deviations up in a gamma law of that variance, by the cube of a normal variable (Wilson and Hilferty, PNAS
//! 17, 1931), of a sum to which two deviations are added of what the sample may have missed:
//!
//! `(S + 2 sqrt((1 - f) sum of S_tc^2)) (1 - v/9 + z sqrt(v)/3)^3`
//!
//! Limits: pulses near each other have nearly the same speckle, so `n` is rather too large; errors of single
//! facets have longer tails than a gamma law.
//!
//! ```
//! use nereus::fidelity::worst::{deviations_of, worst_of};
//! // Six cells of equal power, the worst of 66 pulses: 4 dB above the mean.
//! let worst = worst_of(1.0 / 6.0, deviations_of(66));
//! assert!((10.0 * worst.log10() - 4.15).abs() < 0.01);
//! ```

/// Most standard deviations of an error from pulse to pulse that are added: the worst of some ten thousand,
/// were it Gaussian.
pub const SIGMAS: f64 = 4.0;
/// Standard deviations of the sample itself that are added: it may have missed some of the few facets that
/// make most of an error.
const SAMPLE_SIGMAS: f64 = 2.0;
/// Most resolution cells along delay that are kept apart.
const MOST_CELLS: usize = 4096;

/// A sum of terms, all and those of each resolution cell. Terms of a run of neighbours are closed before
/// those of the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Sum {
    of: f64,
    /// Of every cell up to the last that has a term.
    cells: Vec<f64>,
    /// The cells of the run that is open, and the squares of those closed.
    open: Vec<(usize, f64)>,
    squares: f64,
}

impl Sum {
    pub(super) fn add(&mut self, term: f64, cell: usize) {
        self.of += term;
        let cell = cell.min(MOST_CELLS - 1);
        match self.open.iter_mut().find(|(own, _)| *own == cell) {
            Some((_, sum)) => *sum += term,
            None => self.open.push((cell, term)),
        }
    }

    /// Ends a run.
    pub(super) fn close(&mut self) {
        for (cell, own) in self.open.drain(..) {
            self.cells.resize(self.cells.len().max(cell + 1), 0.0);
            self.cells[cell] += own;
            self.squares += own * own;
        }
    }

    /// Takes over all closed terms of another.
    pub(super) fn join(&mut self, other: &Self) {
        self.of += other.of;
        self.squares += other.squares;
        self.cells.resize(self.cells.len().max(other.cells.len()), 0.0);
        self.cells.iter_mut().zip(&other.cells).for_each(|(own, other)| *own += other);
    }

    /// How many numbers it holds.
    pub(super) fn numbers(&self) -> usize {
        self.cells.len() + 2
    }

    /// The sum of the terms.
    pub(super) fn mean(&self) -> f64 {
        self.of
    }

    /// Of the worst of many pulses, `deviations` up, of a sample that is such a share of all.
    pub(super) fn worst(&self, share: f64, deviations: f64) -> f64 {
        if self.of <= 0.0 {
            return 0.0;
        }
        let missed = SAMPLE_SIGMAS * ((1.0 - share).max(0.0) * self.squares).sqrt();
        (self.of + missed) / self.of * self.worst_of_like(share, deviations)
    }

    /// The same without what the sample may have missed: of an echo that is compared with its own mean.
    pub(super) fn worst_of_like(&self, share: f64, deviations: f64) -> f64 {
        if self.of <= 0.0 {
            return 0.0;
        }
        let cells = self.cells.iter().map(|cell| cell * cell).sum::<f64>();
        let spread = ((cells - self.squares).max(0.0) + share * self.squares) / (self.of * self.of);
        self.of * worst_of(spread, deviations)
    }
}

/// How far a positive quantity of mean 1 and some variance is off so many deviations up: Wilson's and
/// Hilferty's cube of a normal variable, for a gamma law.
pub fn worst_of(variance: f64, deviations: f64) -> f64 {
    (1.0 - variance / 9.0 + deviations * variance.sqrt() / 3.0).powi(3).max(1.0)
}

/// Deviations up at which the largest of so many normal variables is about expected, [`SIGMAS`] at most.
pub fn deviations_of(draws: u64) -> f64 {
    (2.0 * (draws.max(1) as f64).ln()).sqrt().min(SIGMAS)
}

/// Resolution cells along delay.
#[derive(Clone, Copy)]
pub(super) struct Cells {
    pub(super) from_s: f64,
    pub(super) per_s: f64,
}

impl Cells {
    pub(super) fn of(self, delay_s: f64) -> usize {
        ((delay_s - self.from_s) * self.per_s) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_of_an_exponential_law() {
        // Its quantile at the normal deviation z is -ln Q(z): Q(2) = 0.02275, Q(3) = 0.0013499, Q(4) =
        // 3.1671e-5. For a law as skew as this the cube is off by 0.5, 2 and 6 %; for all others by less.
        for (z, above) in [(2.0, 0.022_750_f64), (3.0, 0.001_349_9), (4.0, 3.167_1e-5)] {
            let (found, expected) = (worst_of(1.0, z), -above.ln());
            assert!((found / expected - 1.0).abs() < 0.08, "{z}: {found} {expected}");
        }
        assert_eq!(worst_of(0.0, 4.0), 1.0);
    }

    #[test]
    fn cells_and_facets_that_decide() {
        let of = |terms: &[(f64, usize)], share| {
            let mut sum = Sum::default();
            for (term, cell) in terms {
                sum.add(*term, *cell);
                sum.close();
            }
            sum.worst(share, 3.0)
        };
        // One facet, or many in one cell: an exponential law. The same in many cells: hardly more than the
        // mean.
        let together: Vec<_> = (0..400).map(|_| (1.0 / 400.0, 7)).collect();
        let apart: Vec<_> = (0..400).map(|n| (1.0 / 400.0, n)).collect();
        assert!((of(&[(1.0, 3)], 1.0) / worst_of(1.0, 3.0) - 1.0).abs() < 1e-12);
        assert!((of(&together, 1.0) / worst_of(1.0, 3.0) - 1.0).abs() < 1e-9);
        assert!((of(&apart, 1.0) / worst_of(1.0 / 400.0, 3.0) - 1.0).abs() < 1e-9);
        // Of a small sample what it may have missed counts: two deviations of 400 terms are a tenth.
        assert!((of(&apart, 0.0) - 1.1).abs() < 1e-9);
        // Sums of two samples of the same.
        let (mut both, mut other) = (Sum::default(), Sum::default());
        for (sum, cell) in [(&mut both, 3), (&mut other, 3)] {
            sum.add(0.5, cell);
            sum.close();
        }
        both.join(&other);
        assert_eq!((both.mean(), both.worst_of_like(1.0, 3.0)), (1.0, worst_of(1.0, 3.0)));
        // A crest that fills a run in one cell is one term of many like it.
        let mut crest = Sum::default();
        (0..256).for_each(|_| crest.add(1.0 / 256.0, 7));
        crest.close();
        assert!((crest.worst_of_like(0.01, 3.0) / worst_of(0.01, 3.0) - 1.0).abs() < 1e-9);
        // Cells beyond all, and nothing at all.
        assert!(of(&[(1.0, usize::MAX)], 1.0).is_finite());
        assert_eq!(of(&[], 0.0), 0.0);
        assert_eq!((deviations_of(0), deviations_of(1), deviations_of(u64::MAX)), (0.0, 0.0, SIGMAS));
    }
}
