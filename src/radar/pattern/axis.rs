//! Regular axes of a pattern.

use num_complex::Complex64;

/// How far a coordinate may lie off the regular grid, in steps: files round to a few decimals.
pub(super) const OFF_GRID_STEPS: f64 = 0.01;

/// What a file gives on a grid.
pub(super) struct Gridded {
    pub azimuth: Axis,
    pub elevation: Axis,
    /// `[elevation][azimuth]`; `None` where the file says nothing.
    pub field: Vec<Option<Complex64>>,
}

/// A regular axis, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    pub first_deg: f64,
    pub step_deg: f64,
    pub len: usize,
}

impl Axis {
    /// The axis through the distinct values (within 1e-6 degrees, far below any measured step).
    pub fn through(values: impl Iterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup_by(|later, earlier| *later - *earlier < 1e-6);
        let len = sorted.len();
        let first_deg = sorted.first().copied().unwrap_or(0.0);
        // From the median step, made finer by every value that fits: neither the rounding of a file's
        // decimals nor a stray value corrupts it.
        let mut steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let Some(&median) = steps.get(steps.len() / 2) else {
            return Self { first_deg, step_deg: 0.0, len };
        };
        let (mut step_deg, mut last) = (median, 1);
        for value in sorted {
            let place = ((value - first_deg) / step_deg).round();
            let off = (value - first_deg - place * step_deg).abs();
            if place >= 1.0 && off <= OFF_GRID_STEPS * step_deg {
                step_deg = (value - first_deg) / place;
                last = place as usize;
            }
        }
        Self { first_deg, step_deg, len: last.saturating_add(1) }
    }

    /// Place of a value on the axis, `None` off the grid.
    pub fn place(&self, value_deg: f64) -> Option<usize> {
        let x = (value_deg - self.first_deg) / self.step_deg;
        let place = x.round() as usize;
        ((x - x.round()).abs() <= OFF_GRID_STEPS && place < self.len).then_some(place)
    }

    pub fn value_deg(&self, place: usize) -> f64 {
        self.first_deg + place as f64 * self.step_deg
    }
}
