//! The report of `nereus speckle`.

use std::fmt::Write as _;
use std::path::PathBuf;

use serde::Serialize;

use super::{Files, SpeckleArgs};
use crate::cli::counted;
use crate::cli::escape;
use crate::cli::json;
use crate::clutter::empirical::GRAZING_DEG;
use crate::clutter::fits::{Shape, Speckle};
use crate::clutter::image::Geometry;
use crate::clutter::regression::{self, Cosine};
use crate::clutter::{Kind, sea_shape};
use crate::config::Run;
use crate::plot::canvas::Canvas;
use crate::plot::chart::{Curve, Mark, Plot, PlotAxis, PlotError, Spacing};
use crate::scene::Sea;
use crate::scene::radar::Polarisation;

/// Curves of one colour each; the plot repeats them after so many.
const COLOURS: usize = 8;

/// One channel under one wind.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Azimuth {
    channel: String,
    /// From the look to where the wind blows: 0 downwind, 180 upwind.
    psi_deg: f64,
    grazing_deg: [f64; 3],
    /// Across the look and along it, m.
    cell_m: [f64; 2],
    facets_per_cell: f64,
    /// Span of the mean power over range, which was divided out, dB.
    trend_db: Option<f64>,
    /// Ward, Baker and Watts, for HH and VV of one place within their grazing angles.
    empirical: Option<f64>,
    #[serde(flatten)]
    speckle: Speckle,
}

/// `nu` over azimuth by one way to fit.
#[derive(Clone, Debug, Serialize)]
struct Over {
    channel: String,
    fit: &'static str,
    /// `a + b cos 2 psi`, of the azimuths at which `nu` is finite.
    a: f64,
    a_error: f64,
    b: f64,
    b_error: f64,
    azimuths: usize,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    scenario: String,
    pulses: u64,
    facets: usize,
    seconds: f64,
    azimuths: Vec<Azimuth>,
    cosines: Vec<Over>,
    out: Vec<PathBuf>,
    #[serde(skip)]
    channels: Vec<String>,
}

/// What a way to fit found of a K law.
type Found = fn(&Azimuth) -> Option<&Shape>;
/// The ways to fit.
const WAYS: [(&str, Found); 3] = [
    ("moments", |azimuth| azimuth.speckle.law(Kind::K).map(|fits| &fits.moments)),
    ("likelihood", |azimuth| azimuth.speckle.law(Kind::K).map(|fits| &fits.likelihood)),
    ("histogram", |azimuth| azimuth.speckle.law(Kind::K).map(|fits| &fits.histogram)),
];

impl Azimuth {
    pub fn new(run: &Run, sea: &Sea, geometry: Geometry, trend_db: Option<f64>, speckle: Speckle) -> Self {
        let wind_rad = run.scene.sea.as_ref().map_or(0.0, |sea| sea.water.wind.direction_rad);
        let row = &run.scene.radar.channels[geometry.channel];
        // From just below 0, so that downwind is not 360.
        let psi_deg = ((wind_rad - geometry.look_rad).to_degrees() + 1.0).rem_euclid(360.0) - 1.0;
        let [_, grazing_deg, _] = geometry.grazing_deg;
        let vertical = match (row.rx, row.tx) {
            (Polarisation::V, Polarisation::V) => Some(true),
            (Polarisation::H, Polarisation::H) => Some(false),
            _ => None,
        };
        let holds = geometry.monostatic && (GRAZING_DEG[0]..=GRAZING_DEG[1]).contains(&grazing_deg);
        let empirical = vertical
            .filter(|_| holds)
            .map(|vertical| sea_shape(grazing_deg, geometry.cell_m, psi_deg.to_radians(), vertical));
        Self {
            channel: row.name.clone(),
            // The look is known to 1e-3 degrees: the radar moves on while the echo returns.
            psi_deg: (1e2 * psi_deg).round() / 1e2 + 0.0,
            grazing_deg: geometry.grazing_deg,
            cell_m: geometry.cell_m,
            facets_per_cell: geometry.cell_m[0] * geometry.cell_m[1] / sea.patch.facet_m.powi(2),
            trend_db,
            empirical,
            speckle,
        }
    }
}

impl Report {
    pub fn new(
        args: &SpeckleArgs,
        run: &Run,
        channels: &[usize],
        azimuths: Vec<Azimuth>,
        seconds: f64,
        files: &Option<Files>,
    ) -> Self {
        let channels: Vec<String> =
            channels.iter().map(|place| run.scene.radar.channels[*place].name.clone()).collect();
        let mut cosines = Vec::new();
        for channel in &channels {
            for (fit, way) in WAYS {
                if let Some(Cosine { mean, mean_error, amplitude, amplitude_error, points }) =
                    cosine(&azimuths, channel, way)
                {
                    cosines.push(Over {
                        channel: channel.clone(),
                        fit,
                        a: mean,
                        a_error: mean_error,
                        b: amplitude,
                        b_error: amplitude_error,
                        azimuths: points,
                    });
                }
            }
        }
        Self {
            scenario: args.scenario.config.display().to_string(),
            pulses: run.scene.pulses,
            facets: run.scene.sea.as_ref().map_or(0, |sea| sea.patch.len()),
            seconds,
            azimuths,
            cosines,
            out: files.iter().flat_map(|files| json::all_legible(&files.paths)).collect(),
            channels,
        }
    }

    /// The first word must stay the first: it marks the file as one of these.
    pub fn csv(&self) -> String {
        let mut csv = "psi_deg,channel,grazing_deg,cell_across_m,cell_along_m,facets_per_cell,pixels,trend_db,mean_power_dbw,contrast,contrast_error,\
            nu_moments,nu_moments_error,nu_likelihood,nu_likelihood_error,inverse_nu_error,inverse_nu_block_error,nu_histogram,nu_histogram_error,\
            weibull_moments,weibull_moments_error,weibull_likelihood,weibull_likelihood_error,weibull_histogram,weibull_histogram_error,test_pixels"
            .to_owned();
        for kind in Kind::ALL {
            let _ = write!(csv, ",ks_{0},ks_{0}_p", kind.name());
        }
        csv += ",nu_empirical\n";
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.5e}"));
        for azimuth in &self.azimuths {
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
                format!(
                    ",{shape_text},{}",
                    shape.error.map_or("inf".to_owned(), |error| format!("{error:.3e}"))
                )
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

    pub fn text(&self) -> String {
        let mut text = format!(
            "{}: {}, {} for each wind; {:.0} s\n",
            self.scenario,
            counted(self.facets, "facet"),
            counted(self.pulses, "pulse"),
            self.seconds
        );
        if let Some(first) = self.azimuths.first() {
            let [near, middle, far] = first.grazing_deg;
            let _ = writeln!(
                text,
                "{} pixels of {:.3} m across the look and {:.3} m along it, {:.2} facets each (N facets lower <I^2>/<I>^2 by 1/N); \
                 grazing angle {middle:.3} degrees, {near:.3} to {far:.3}",
                first.speckle.pixels, first.cell_m[0], first.cell_m[1], first.facets_per_cell
            );
        }
        let _ = writeln!(
            text,
            "   psi channel    dBW  contrast  nu moments      nu likelihood   blocks   nu histogram    KS K      p     Weibull    p     Rayleigh   p     law"
        );
        for azimuth in &self.azimuths {
            let speckle = &azimuth.speckle;
            let _ = write!(
                text,
                "{:6.1} {:7} {:6.1} {:9.3}",
                azimuth.psi_deg, azimuth.channel, speckle.mean_power_dbw, speckle.contrast
            );
            if let Some(fits) = speckle.law(Kind::K) {
                let block =
                    fits.likelihood.shape.zip(speckle.inverse_block_error).map(|(nu, error)| nu * nu * error);
                let _ = write!(
                    text,
                    "  {}  {}  {:>7}  {}",
                    fits.moments,
                    fits.likelihood,
                    block.map_or("-".to_owned(), |error| format!("{error:.3}")),
                    fits.histogram
                );
            }
            for fits in &speckle.laws {
                let p = fits.probability.map_or("-".to_owned(), |p| format!("{p:.2}"));
                let _ = write!(text, "  {:.4}  {p:>4}", fits.distance);
            }
            let _ = writeln!(text, "  {}", azimuth.empirical.map_or("-".to_owned(), |nu| format!("{nu:.4}")));
        }
        if !self.cosines.is_empty() {
            let _ = writeln!(text, "nu = a + b cos 2 psi");
        }
        for over in &self.cosines {
            let _ = writeln!(
                text,
                "{:7} {:10}  a = {:.4} +- {:.4}, b = {:+.4} +- {:.4}  ({} azimuths)",
                over.channel, over.fit, over.a, over.a_error, over.b, over.b_error, over.azimuths
            );
        }
        for path in &self.out {
            let _ = writeln!(text, "{}", escape::path(path));
        }
        text
    }

    /// `nu` by likelihood over azimuth, the cosine through it, and the empirical law.
    pub fn draw(&self) -> Result<Canvas, PlotError> {
        let of = |channel: &String, value: &dyn Fn(&Azimuth) -> Option<f64>| -> Vec<[f64; 2]> {
            let own = self.azimuths.iter().filter(|azimuth| azimuth.channel == *channel);
            own.filter_map(|azimuth| Some([azimuth.psi_deg, value(azimuth)?])).collect()
        };
        let likely = |azimuth: &Azimuth| azimuth.speckle.law(Kind::K).and_then(|fits| fits.likelihood.shape);
        let degrees = |law: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
            (0..=180).map(|i| 2.0 * f64::from(i)).map(|psi| [psi, law(psi.to_radians())]).collect()
        };
        let mut named: Vec<(String, Vec<[f64; 2]>, Mark)> = Vec::new();
        for channel in &self.channels {
            named.push((channel.clone(), of(channel, &likely), Mark::Dots));
        }
        // Lines in the colour of their dots: colours come again after eight.
        named.resize_with(named.len().next_multiple_of(COLOURS), || (String::new(), Vec::new(), Mark::Line));
        for channel in &self.channels {
            let line = match cosine(&self.azimuths, channel, WAYS[1].1) {
                Some(fit) => degrees(&|psi| fit.at(psi)),
                None => Vec::new(),
            };
            let name = if line.is_empty() { String::new() } else { format!("{channel} a + b cos 2psi") };
            named.push((name, line, Mark::Line));
        }
        named.resize_with(named.len().next_multiple_of(COLOURS), || (String::new(), Vec::new(), Mark::Line));
        for channel in &self.channels {
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
        let title = self.azimuths.first().map_or_else(String::new, |first| {
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
}

fn cosine(azimuths: &[Azimuth], channel: &str, way: Found) -> Option<Cosine> {
    let own = azimuths.iter().filter(|azimuth| azimuth.channel == channel);
    let (psi_rad, shapes): (Vec<f64>, Vec<f64>) = own
        .map(|azimuth| {
            (azimuth.psi_deg.to_radians(), way(azimuth).and_then(|shape| shape.shape).unwrap_or(f64::NAN))
        })
        .unzip();
    regression::cosine(&psi_rad, &shapes)
}
