//! Evaluates the fields of a surface at a time, into the caller's buffers, without allocating.
//!
//! ```
//! use nereus::scene::water::{Dispersion, WindProfile};
//! use nereus::sea::spectrum::FungLee;
//! use nereus::sea::surface::{Averaging, Evaluator, Fields, Grid, Selection, Surface};
//! use nereus::sea::wind::Wind;
//! let spectrum = FungLee::new(&Wind::from_speed(6.0, 10.0, WindProfile::Cardone, 0.0)?);
//! let grid = Grid::new(16, 16, 4.0)?;
//! let surface = Surface::synthesise(grid, &spectrum, Dispersion::default(), 1, Averaging::Automatic)?;
//! let mut evaluator = Evaluator::<f32>::new(&surface);
//! let mut fields = Fields::new(&grid, Selection::HEIGHT);
//! for block in 0..3 {
//!     evaluator.evaluate(f64::from(block) * 0.072, &mut fields)?;
//! }
//! assert!(evaluator.evaluate(f64::NAN, &mut fields).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::fields::Real;
use super::{Fields, Pair, Phasors, Surface, SurfaceError, Transform};

/// Furthest time from t = 0, s: there the phases of waves of 1 m are still good to 1e-6 rad.
pub const MAX_TIME_S: f64 = 1e9;

/// Evaluates one surface, in f32 or f64.
#[derive(Clone)]
pub struct Evaluator<T: Real> {
    facets: usize,
    flat: bool,
    phasors: Phasors<T>,
    transform: Transform<T>,
}

impl<T: Real> Evaluator<T> {
    /// For a surface.
    pub fn new(surface: &Surface) -> Self {
        Self {
            facets: surface.grid().len(),
            flat: surface.is_flat(),
            phasors: Phasors::new(surface),
            transform: Transform::new(surface),
        }
    }

    /// The same with short waves that relax at a rate, 1/s ([`modulation`](super::modulation)).
    pub fn with_relaxation(mut self, rate_per_s: f64) -> Self {
        self.transform.relax(rate_per_s);
        self
    }

    /// Fills every field that is not empty, at a time in seconds from t = 0.
    ///
    /// # Errors
    /// Fields of another grid, or a time that is not finite.
    pub fn evaluate(&mut self, time_s: f64, fields: &mut Fields<T>) -> Result<(), SurfaceError> {
        self.evaluate_from([0; 2], time_s, fields)
    }

    /// The same with some column and row of the grid as the first of the fields, which go round it.
    pub fn evaluate_from(
        &mut self,
        column_row: [usize; 2],
        time_s: f64,
        fields: &mut Fields<T>,
    ) -> Result<(), SurfaceError> {
        self.transform.begin_at(column_row);
        if !time_s.is_finite() || time_s.abs() > MAX_TIME_S {
            return Err(SurfaceError::Time { time_s });
        }
        let Fields {
            height_m,
            slope,
            velocity_mps: [ux, uy, uz],
            acceleration_mps2: [ax, ay, az],
            displacement_m,
            slope_rate_per_s,
            modulation,
            stretch,
            area: _,
        } = fields;
        let [slope_x, slope_y] = slope;
        let [dx, dy] = displacement_m;
        let [rate_x, rate_y] = slope_rate_per_s;
        let [along_x, along_y, shear] = modulation;
        let [stretch_x, stretch_y, stretch_xy] = stretch;
        // The height goes with the acceleration, or, where that is not wanted, with the vertical velocity.
        let (pair, beside, rest): (_, &mut [T], &mut [T]) =
            if az.is_empty() { (Pair::Rise, uz, az) } else { (Pair::Height, az, uz) };
        let pair = if beside.is_empty() { Pair::Height } else { pair };
        // Two fields of their own are one pair where both are wanted.
        let (both, shear, with, alone): (_, &mut [T], &mut [T], &mut [T]) =
            if shear.is_empty() || stretch_xy.is_empty() {
                (Pair::ModulationShear, shear, &mut [], stretch_xy)
            } else {
                (Pair::Shears, shear, stretch_xy, &mut [])
            };
        let pairs: [(Pair, &mut [T], &mut [T]); 11] = [
            (pair, height_m, beside),
            (Pair::Slope, slope_x, slope_y),
            (Pair::HorizontalVelocity, ux, uy),
            (Pair::VerticalVelocity, rest, &mut []),
            (Pair::HorizontalAcceleration, ax, ay),
            (Pair::Displacement, dx, dy),
            (Pair::SlopeRate, rate_x, rate_y),
            (Pair::Modulation, along_x, along_y),
            (both, shear, with),
            (Pair::Stretch, stretch_x, stretch_y),
            (Pair::StretchShear, alone, &mut []),
        ];
        for found in pairs.iter().flat_map(|(_, first, second)| [first.len(), second.len()]) {
            if found != 0 && found != self.facets {
                return Err(SurfaceError::FieldSize { found, needed: self.facets });
            }
        }
        if !self.flat {
            self.phasors.turn_to(time_s);
        }
        for (pair, first, second) in pairs {
            if first.is_empty() && second.is_empty() {
                continue;
            }
            if self.flat {
                first.fill(T::default());
                second.fill(T::default());
            } else {
                self.transform.run(&self.phasors, pair, first, second);
            }
        }
        Ok(())
    }
}
