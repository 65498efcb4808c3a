//! Pictures of images.

use super::Image;
use crate::plot::canvas::Canvas;
use crate::plot::picture::{Axis, Limits, Picture, PictureError, Reduction};
use crate::processor::multilook::percentile;

/// What the colours of a picture are of.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Scale {
    /// Powers, dBW, so many decibels below the greatest.
    Decibels {
        /// Decibels that the colours span.
        span: f64,
    },
    /// Amplitudes, sqrt(W), up to that which a share of the pixels do not exceed.
    Amplitudes {
        /// The share, percent.
        percent: f64,
    },
}

impl Image {
    /// Draws means of power over `looks` by `looks` pixels, on a square of so many dots.
    ///
    /// # Errors
    /// An image without pixels.
    pub fn picture(
        &self,
        title: &str,
        looks: usize,
        scale: Scale,
        size_px: usize,
    ) -> Result<Canvas, PictureError> {
        let (power, cells) = self.power(looks);
        let (values, quantity, limits, reduction): (Vec<f64>, _, _, _) = match scale {
            Scale::Decibels { span } => {
                let values = power.iter().map(|p| 10.0 * p.log10()).collect();
                (values, "dBW", Limits::Below { percent: 100.0, span }, Reduction::MeanPower)
            }
            Scale::Amplitudes { percent } => {
                let values: Vec<f64> = power.iter().map(|p| p.sqrt()).collect();
                let top = percentile(&values, percent).unwrap_or(0.0);
                let limits = Limits::Fixed([0.0, top.max(f64::MIN_POSITIVE * 1e20)]);
                (values, "amplitude, sqrt(W)", limits, Reduction::Mean)
            }
        };
        let steps = [self.ground.step_x_m[0], self.ground.step_y_m[1]].map(|step| step * looks as f64);
        let axis = |axis: usize, label| {
            let [from, _] = self.ground.edges_m(axis);
            Axis { label, from, to: from + cells[axis] as f64 * steps[axis] }
        };
        let picture = Picture {
            title,
            x: axis(0, "East, m"),
            y: axis(1, "North, m"),
            quantity,
            limits,
            reduction,
            scale_bar: Some("m"),
            size_px,
            ..Picture::new(&values, cells)?
        };
        picture.draw()
    }
}
