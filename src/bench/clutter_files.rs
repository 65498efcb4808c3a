//! Statistics of clutter over the azimuth of the wind as files: a table, and a picture.

use std::fmt::Write as _;

use super::clutter::{Azimuth, WAYS, cosine};
use crate::clutter::Kind;
use crate::clutter::fits::Shape;
use crate::plot::canvas::Canvas;
use crate::plot::chart::{Curve, Mark, Plot, PlotAxis, PlotError, Spacing};

/// Curves of one colour each; the plot repeats them after so many.
const COLOURS: usize = 8;

/// The table. Its first word must stay the first: by it the file is recognised.
pub(crate) fn csv(azimuths: &[Azimuth]) -> String {
    let mut csv = "psi_deg,channel,grazing_deg,cell_across_m,cell_along_m,facets_per_cell,pixels,trend_db,mean_power_dbw,contrast,contrast_error,\
        nu_moments,nu_moments_error,nu_likelihood,nu_likelihood_error,inverse_nu_error,inverse_nu_block_error,nu_histogram,nu_histogram_error,\
        weibull_moments,weibull_moments_error,weibull_likelihood,weibull_likelihood_error,weibull_histogram,weibull_histogram_error,test_pixels"
        .to_owned();
    for kind in Kind::ALL {
        let _ = write!(csv, ",ks_{0},ks_{0}_p", kind.name());
    }
    csv += ",nu_empirical\n";
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.5e}"));
    for azimuth in azimuths {
        let speckle = &azimuth.speckle;
        let _ = write!(
            csv,
            "{:.2},{},{:.4},{:.4},{:.4},{:.3},{},{},{:.3},{:.5},{:.5}",
            azimuth.psi_deg,
            azimuth.channel,
            azimuth.grazing_deg[1],
            azimuth.cell_m[0],
            azimuth.cell_m[1],
            azimuth.facets_per_cell,
            speckle.pixels,
            azimuth.trend_db.map_or(String::new(), |db| format!("{db:.2}")),
            speckle.mean_power_dbw,
            speckle.contrast,
            speckle.contrast_error
        );
        // An infinite shape is a word that any reader of CSV takes for what it is.
        let shape = |shape: &Shape| {
            let shape_text = shape.shape.map_or("inf".to_owned(), |nu| format!("{nu:.5e}"));
            format!(",{shape_text},{}", shape.error.map_or("inf".to_owned(), |error| format!("{error:.3e}")))
        };
        if let Some(fits) = speckle.law(Kind::K) {
            csv += &shape(&fits.moments);
            csv += &shape(&fits.likelihood);
            let _ = write!(
                csv,
                ",{},{}",
                number(fits.likelihood.inverse_error),
                number(speckle.inverse_block_error)
            );
            csv += &shape(&fits.histogram);
        }
        if let Some(fits) = speckle.law(Kind::Weibull) {
            for found in [&fits.moments, &fits.likelihood, &fits.histogram] {
                csv += &shape(found);
            }
        }
        let _ = write!(csv, ",{}", speckle.test_pixels);
        for fits in &speckle.laws {
            let _ = write!(
                csv,
                ",{:.5},{}",
                fits.distance,
                fits.probability.map_or(String::new(), |p| format!("{p:.4}"))
            );
        }
        let _ = writeln!(csv, ",{}", number(azimuth.empirical));
    }
    csv
}

/// `nu` by likelihood over azimuth, the cosine through it, and the empirical law.
///
/// # Errors
/// Figures that cannot be drawn.
pub(crate) fn picture(azimuths: &[Azimuth], channels: &[String]) -> Result<Canvas, PlotError> {
    let of = |channel: &String, value: &dyn Fn(&Azimuth) -> Option<f64>| -> Vec<[f64; 2]> {
        let own = azimuths.iter().filter(|azimuth| azimuth.channel == *channel);
        own.filter_map(|azimuth| Some([azimuth.psi_deg, value(azimuth)?])).collect()
    };
    let likely = |azimuth: &Azimuth| azimuth.speckle.law(Kind::K).and_then(|fits| fits.likelihood.shape);
    let degrees = |law: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
        (0..=180).map(|i| 2.0 * f64::from(i)).map(|psi| [psi, law(psi.to_radians())]).collect()
    };
    let mut named: Vec<(String, Vec<[f64; 2]>, Mark)> = Vec::new();
    for channel in channels {
        named.push((channel.clone(), of(channel, &likely), Mark::Dots));
    }
    // Lines in the colour of their dots: colours come again after eight.
    named.resize_with(named.len().next_multiple_of(COLOURS), || (String::new(), Vec::new(), Mark::Line));
    for channel in channels {
        let line = match cosine(azimuths, channel, WAYS[1].1) {
            Some(fit) => degrees(&|psi| fit.at(psi)),
            None => Vec::new(),
        };
        let name = if line.is_empty() { String::new() } else { format!("{channel} a + b cos 2psi") };
        named.push((name, line, Mark::Line));
    }
    named.resize_with(named.len().next_multiple_of(COLOURS), || (String::new(), Vec::new(), Mark::Line));
    for channel in channels {
        // From one azimuth to all others as Watts and Wicks have it: cos 2 psi / 3 in the logarithm.
        let first = of(channel, &|azimuth| azimuth.empirical).first().copied();
        let law = first.map_or_else(Vec::new, |[at_deg, nu]| {
            let at = (2.0 * at_deg.to_radians()).cos();
            degrees(&|psi| nu * 10f64.powf((at - (2.0 * psi).cos()) / 3.0))
        });
        let name = if law.is_empty() { String::new() } else { format!("{channel} Ward, Baker, Watts") };
        named.push((name, law, Mark::Line));
    }
    let curves: Vec<Curve> =
        named.iter().map(|(name, points, mark)| Curve { name, points, mark: *mark }).collect();
    let title = azimuths.first().map_or_else(String::new, |first| {
        format!(
            "Shape of the K law, {:.2} m x {:.2} m, grazing angle {:.2} degrees",
            first.cell_m[0], first.cell_m[1], first.grazing_deg[1]
        )
    });
    let label = "wind from the look, degrees: 0 downwind, 180 upwind";
    Plot {
        title: &title,
        x: PlotAxis { label, spacing: Spacing::Linear, limits: Some([-10.0, 370.0]) },
        y: PlotAxis { label: "nu by likelihood", spacing: Spacing::Logarithmic, limits: None },
        curves: &curves,
        size_px: [720, 480],
    }
    .draw()
}
