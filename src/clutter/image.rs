//! Images of the patch, a pixel a resolution cell, from pulses in memory.

use glam::{DVec2, DVec3};
use num_complex::Complex32;

use super::trend;
use crate::geometry::phase_path::{PhasePath, PhasePathError};
use crate::processor::backproject::{Aperture, PulseEcho, fast};
use crate::processor::point_target::Support;
use crate::processor::range_compress::{CompressError, Compressor, PulseShape, RangeFilter, oversampling};
use crate::processor::taper::Taper;
use crate::pulse::gathered::Gathered;
use crate::radar::waveform;
use crate::recording::ground::Ground;
use crate::scene::Radar;
use crate::scene::radar::Band;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Least cells along both sides.
const LEAST_CELLS: usize = 10;
/// Error of the interpolation between cells of a compressed pulse, dB.
const INTERPOLATION_DB: f64 = -60.0;

/// Why there is no image of the patch.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// No pulse to compress with.
    #[error(transparent)]
    Compress(#[from] CompressError),
    /// Positions or times that are none.
    #[error(transparent)]
    Path(#[from] PhasePathError),
    /// No cell across the look.
    #[error(
        "no cross-range from the pulses that left in its polarisation; allowed: at least two, from different places that see the patch at different angles"
    )]
    NoAperture,
    /// An image too small for statistics.
    #[error(
        "{} x {} resolution cells of {:.3} m x {:.3} m (across the look and along it) on the patch; allowed: at least {LEAST_CELLS} \
         cells along both: a larger scene.patch_size_m, a longer aperture, more bandwidth, or more --pixels",
        pixels[0], pixels[1], cell_m[0], cell_m[1]
    )]
    FewCells {
        /// Cells across the look and along it.
        pixels: [usize; 2],
        /// Their size, m.
        cell_m: [f64; 2],
    },
}

/// Where an image lies, and how large it may be.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Its middle, East and North, m.
    pub middle_m: [f64; 2],
    /// Size of the patch on which all pixels lie, m.
    pub patch_m: [f64; 2],
    /// Most pixels across the look and along it.
    pub most: [usize; 2],
}

/// From where a channel looks at the middle of its image, at the middle pulse.
#[derive(Clone, Copy, Debug)]
pub struct Geometry {
    /// Place of the channel.
    pub channel: usize,
    /// Direction in which the delay grows, counter-clockwise from East, rad.
    pub look_rad: f64,
    /// Mean grazing angle of both ends, degrees, at the near edge, in the middle, at the far edge.
    pub grazing_deg: [f64; 3],
    /// Whether both ends look along one direction, to a degree.
    pub monostatic: bool,
    /// Cells across the look and along it, m.
    pub cell_m: [f64; 2],
}

/// Powers of the pixels, the trend over range taken out.
pub struct Image {
    /// Row by row from the near edge, W.
    pub powers: Vec<f64>,
    /// Pixels across the look and along it.
    pub pixels: [usize; 2],
    /// Span of the trend, dB.
    pub trend_db: Option<f64>,
    /// How it is seen.
    pub geometry: Geometry,
}

/// The image of a channel of a radar, from its pulses and its replica; `done` is called with the pulses that
/// are in it, and those of the channel.
///
/// # Errors
/// No pulse to compress with, no cross-range, fewer than 10 cells along a side.
pub fn image(
    radar: &Radar,
    gathered: &Gathered,
    replica: &[Complex32],
    channel: usize,
    place: Place,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Result<Image, ImageError> {
    let compressor = compressor(radar, replica)?;
    let row = &radar.channels[channel];
    let illuminated = (0..gathered.samples.len())
        .filter(|pulse| gathered.tx_pol[*pulse] == 0 || gathered.tx_pol[*pulse] == row.tx.code());
    let path = |end: usize| {
        let points = gathered.phase_centre_m.iter().map(|all| all[end]).collect();
        PhasePath::new(gathered.emission_s.clone(), points)
    };
    let (transmitter, receiver) = (path(row.transmitter)?, path(radar.transmitters.len() + row.receiver)?);
    let samples = radar.window.samples;
    let echo = |pulse: usize| PulseEcho {
        emission_s: gathered.emission_s[pulse],
        number: gathered.numbers[pulse],
        window_start_s: match gathered.window_starts_s[pulse].as_slice() {
            [all] => *all,
            each => each[row.receiver],
        },
        weight: 1.0,
        samples: &gathered.samples[pulse][channel * samples..(channel + 1) * samples],
    };
    let [x, y] = place.middle_m;
    let aperture = Aperture {
        carrier_hz: radar.carrier_hz,
        compressor: &compressor,
        transmitter: &transmitter,
        receiver: &receiver,
        pulses: illuminated.map(echo).collect(),
        centre_m: [x, y, 0.0],
        gate: None,
    };
    let support = Support::of(&aperture, aperture.centre_m).ok_or(ImageError::NoAperture)?;
    let [(_, along_m), (_, across_m)] = support.cuts();
    let cell_m = [across_m, along_m];
    let ground = ground(&support, place)?;
    let pixels = ground.pixels;
    let count = aperture.pulses.len();
    let made = fast(&aperture, std::slice::from_ref(&ground), &|passed| done(passed, count));
    let power = |z: &Complex32| f64::from(z.re).powi(2) + f64::from(z.im).powi(2);
    let mut powers: Vec<f64> = made.iter().flatten().map(power).collect();
    let half = pixels.map(|n| 0.5 * (n as f64 - 1.0));
    let middle = &aperture.pulses[count / 2];
    let range_m =
        |j: usize| 0.5 * SPEED_OF_LIGHT_MPS * aperture.delay_s(middle, ground.point_m(half[0], j as f64));
    let ranges_m: Vec<f64> = (0..pixels[1]).map(range_m).collect();
    let trend_db = trend::remove(&mut powers, pixels[0], &ranges_m);
    // Seen from a point of the image.
    let ends = |point: [f64; 3]| {
        let at = [&transmitter, &receiver].map(|path| DVec3::from(path.at(middle.emission_s)));
        at.map(|end| (end - DVec3::from(point)).normalize_or_zero())
    };
    let grazing_deg = |j: f64| {
        let [t, r] = ends(ground.point_m(half[0], j));
        0.5 * (t.z.asin() + r.z.asin()).to_degrees()
    };
    let [t, r] = ends(aperture.centre_m);
    let geometry = Geometry {
        channel,
        look_rad: DVec2::from(support.range).to_angle(),
        grazing_deg: [0.0, half[1], 2.0 * half[1]].map(grazing_deg),
        monostatic: t.dot(r) > 1f64.to_radians().cos(),
        cell_m,
    };
    Ok(Image { powers, pixels, trend_db, geometry })
}

fn compressor(radar: &Radar, replica: &[Complex32]) -> Result<Compressor, CompressError> {
    let pulse = waveform::from_description(&radar.waveform);
    let (band, pulse_s) =
        pulse.map_or((Band::about(0.0, 0.0), 0.0), |pulse| (pulse.band(), pulse.duration_s()));
    let turns = radar.waveform.turns();
    let shape = PulseShape { replica, turns, sample_rate_hz: radar.sample_rate_hz, band, pulse_s };
    let cells = oversampling(2.0 * band.reach_hz(), radar.sample_rate_hz, INTERPOLATION_DB);
    // Flat within the band: the response is then a sinc that is zero a cell away, whatever the pulse.
    let filter = if turns > 1 { RangeFilter::Matched } else { RangeFilter::Flat };
    Compressor::new(shape, radar.window.samples, filter, Taper::Uniform, cells)
}

/// A grid of cells across the look and along it.
fn ground(support: &Support, place: Place) -> Result<Ground, ImageError> {
    let [(along, along_m), (across, across_m)] = support.cuts();
    let cell_m = [across_m, along_m];
    if !cell_m.iter().all(|cell| cell.is_finite() && *cell > 0.0) {
        return Err(ImageError::NoAperture);
    }
    let pixels = fitting(place.patch_m, [across, along], cell_m, place.most);
    if pixels.iter().any(|n| *n < LEAST_CELLS) {
        return Err(ImageError::FewCells { pixels, cell_m });
    }
    let step = |direction: [f64; 2], cell: f64| [direction[0] * cell, direction[1] * cell, 0.0];
    let (step_x_m, step_y_m) = (step(across, across_m), step(along, along_m));
    let half = pixels.map(|n| 0.5 * (n as f64 - 1.0));
    let [x, y] = place.middle_m;
    let centre_m = [x, y, 0.0];
    let first_m = std::array::from_fn(|k| centre_m[k] - half[0] * step_x_m[k] - half[1] * step_y_m[k]);
    Ok(Ground { first_m, step_x_m, step_y_m, pixels })
}

/// Cells across the look and along it that lie on the patch: as many as may be, then both sides by one
/// factor.
fn fitting(
    size_m: [f64; 2],
    [across, along]: [[f64; 2]; 2],
    cell_m: [f64; 2],
    most: [usize; 2],
) -> [usize; 2] {
    let side = |direction: [f64; 2], cell: f64, most: usize| {
        let fit = (0..2)
            .map(|axis| size_m[axis] / (direction[axis].abs() * cell).max(1e-12))
            .fold(f64::INFINITY, f64::min);
        fit.min(most as f64)
    };
    let sides = [side(across, cell_m[0], most[0]), side(along, cell_m[1], most[1])];
    let share = (0..2)
        .map(|axis| {
            let length = sides[0] * cell_m[0] * across[axis].abs() + sides[1] * cell_m[1] * along[axis].abs();
            size_m[axis] / length.max(1e-12)
        })
        .fold(1.0, f64::min);
    // Looks are never quite across the patch, for the radar moves on while the echo returns: a tenth of a
    // cell may hang over.
    sides.map(|side| (side * share + 0.1) as usize)
}
