//! Images of the patch, a pixel a resolution cell, from pulses in memory.

use glam::DVec2;
use num_complex::Complex32;

use crate::bench::gather::Gathered;
use crate::cli::focus::watched;
use crate::cli::speckle::error::SpeckleError;
use crate::clutter::trend;
use crate::config::Run;
use crate::geometry::phase_path::PhasePath;
use crate::processor::backproject::{Aperture, PulseEcho};
use crate::processor::point_target::Support;
use crate::processor::range_compress::{Compressor, PulseShape, RangeFilter, oversampling};
use crate::processor::taper::Taper;
use crate::radar::waveform;
use crate::recording::ground::Ground;
use crate::scene::Sea;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Least cells along both sides.
const LEAST_CELLS: usize = 10;
/// Error of the interpolation between cells of a compressed pulse, dB.
const INTERPOLATION_DB: f64 = -60.0;

/// How large an image may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixels {
    /// Most pixels across the look and along it.
    pub most: [usize; 2],
}

/// From where a channel looks at the middle of its image, at the middle pulse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Geometry {
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
pub(super) struct Image {
    pub powers: Vec<f64>,
    pub pixels: [usize; 2],
    /// Span of the trend, dB.
    pub trend_db: Option<f64>,
    pub geometry: Geometry,
}

/// The images of some channels.
pub(super) fn images(
    run: &Run,
    sea: &Sea,
    gathered: &Gathered,
    replica: &[Complex32],
    channels: &[usize],
    middle_m: [f64; 2],
    pixels: Pixels,
) -> Result<Vec<Image>, SpeckleError> {
    let radar = &run.scene.radar;
    let compress = |source| SpeckleError::Compress { path: run.path.clone(), source };
    let pulse = waveform::from_description(&radar.waveform);
    let (bandwidth_hz, pulse_s) =
        pulse.map_or((0.0, 0.0), |pulse| (pulse.bandwidth_hz(), pulse.duration_s()));
    let shape = PulseShape { replica, sample_rate_hz: radar.sample_rate_hz, bandwidth_hz, pulse_s };
    let cells = oversampling(bandwidth_hz, radar.sample_rate_hz, INTERPOLATION_DB);
    // Flat within the band: the response is then a sinc that is zero a cell away, whatever the pulse.
    let compressor = Compressor::new(shape, radar.window.samples, RangeFilter::Flat, Taper::Uniform, cells)
        .map_err(compress)?;
    channels.iter().map(|channel| one(run, sea, gathered, &compressor, *channel, middle_m, pixels)).collect()
}

fn one(
    run: &Run,
    sea: &Sea,
    gathered: &Gathered,
    compressor: &Compressor,
    channel: usize,
    middle_m: [f64; 2],
    pixels: Pixels,
) -> Result<Image, SpeckleError> {
    let radar = &run.scene.radar;
    let row = &radar.channels[channel];
    let illuminated: Vec<usize> = (0..gathered.samples.len())
        .filter(|pulse| gathered.tx_pol[*pulse] == 0 || gathered.tx_pol[*pulse] == row.tx.code())
        .collect();
    let path = |place: usize| {
        let points = gathered.phase_centre_m.iter().map(|all| all[place]).collect();
        PhasePath::new(gathered.emission_s.clone(), points)
            .map_err(|source| SpeckleError::Path { path: run.path.clone(), source })
    };
    let (transmitter, receiver) = (path(row.transmitter)?, path(radar.transmitters.len() + row.receiver)?);
    let samples = radar.window.samples;
    let echo = |pulse: &usize| PulseEcho {
        emission_s: gathered.emission_s[*pulse],
        window_start_s: gathered.window_start_s[*pulse],
        weight: 1.0,
        samples: &gathered.samples[*pulse][channel * samples..(channel + 1) * samples],
    };
    let centre_m = [middle_m[0], middle_m[1], 0.0];
    let aperture = Aperture {
        carrier_hz: radar.carrier_hz,
        compressor,
        transmitter: &transmitter,
        receiver: &receiver,
        pulses: illuminated.iter().map(echo).collect(),
        centre_m,
        gate: None,
    };
    let nowhere = || SpeckleError::NoAperture { path: run.path.clone(), channel: row.name.clone() };
    let support = Support::of(&aperture, centre_m).ok_or_else(nowhere)?;
    let [(along, along_m), (across, across_m)] = support.cuts();
    let cell_m = [across_m, along_m];
    if !cell_m.iter().all(|cell| cell.is_finite() && *cell > 0.0) {
        return Err(nowhere());
    }
    let pixels = fitting(sea.patch.size_m(), [across, along], cell_m, pixels.most);
    if pixels.iter().any(|n| *n < LEAST_CELLS) {
        let (path, channel, least) = (run.path.clone(), row.name.clone(), LEAST_CELLS);
        return Err(SpeckleError::FewPixels { path, channel, pixels, cell_m, least });
    }
    let step = |direction: [f64; 2], cell: f64| [direction[0] * cell, direction[1] * cell, 0.0];
    let (step_x_m, step_y_m) = (step(across, across_m), step(along, along_m));
    let half = pixels.map(|n| 0.5 * (n as f64 - 1.0));
    let ground = Ground {
        first_m: std::array::from_fn(|k| centre_m[k] - half[0] * step_x_m[k] - half[1] * step_y_m[k]),
        step_x_m,
        step_y_m,
        pixels,
    };
    let image = watched(&aperture, &ground);
    let mut powers: Vec<f64> =
        image.iter().map(|z| f64::from(z.re).powi(2) + f64::from(z.im).powi(2)).collect();
    let middle = &aperture.pulses[aperture.pulses.len() / 2];
    let range_m =
        |j: usize| 0.5 * SPEED_OF_LIGHT_MPS * aperture.delay_s(middle, ground.point_m(half[0], j as f64));
    let ranges_m: Vec<f64> = (0..pixels[1]).map(range_m).collect();
    let trend_db = trend::remove(&mut powers, pixels[0], &ranges_m);
    // Seen from a point of the image.
    let ends = |point: [f64; 3]| {
        let at = [&transmitter, &receiver].map(|path| glam::DVec3::from(path.at(middle.emission_s)));
        at.map(|end| (end - glam::DVec3::from(point)).normalize_or_zero())
    };
    let grazing_deg = |j: f64| {
        let [t, r] = ends(ground.point_m(half[0], j));
        0.5 * (t.z.asin() + r.z.asin()).to_degrees()
    };
    let [t, r] = ends(centre_m);
    let geometry = Geometry {
        channel,
        look_rad: DVec2::from(support.range).to_angle(),
        grazing_deg: [0.0, half[1], 2.0 * half[1]].map(grazing_deg),
        monostatic: t.dot(r) > 1f64.to_radians().cos(),
        cell_m,
    };
    Ok(Image { powers, pixels, trend_db, geometry })
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
