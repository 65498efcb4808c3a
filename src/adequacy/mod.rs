//! What the sea of a scene will be, and where its patch, facets and window do not fit the radar: reported
//! before a run.
//!
//! Nothing here is refused. The rules:
//!
//! * A patch should be as long as the actual spectrum asks ([`sampling::least_length_m`]).
//! * A resolution cell should hold [`sampling::LEAST_FACETS_PER_CELL`] facets of random phase or one of
//!   Gaussian amplitude, and no facet should be longer than it. Along ground range the cell is
//!   `c / (B |g|)`, with `g` the horizontal gradient of the path over the first pair at the centre of the
//!   patch: `c / (2 B sin theta)` for one antenna looking down at an incidence of theta. How fine a processor
//!   makes the cell in azimuth is what `scene.azimuth_resolution_m` says.
//! * Of facets of Gaussian amplitude at grazing angles, modes of the tilts should be [`GRAZING_MODES`].
//! * The window should hold the patch, and every antenna should see it: on a curved earth it lies before the
//!   [`horizon`].
//! * Waves of a ship should be long enough for the facets and the band limit, and the ship should cross the
//!   patch.
//! * Above 25 m/s at 10 m the laws of wind and waves are extrapolations, and waves steepen beyond a linear
//!   sea.
//!
//! Geometry is taken at the first, middle and last pulse, on a lattice of [`LATTICE`] x [`LATTICE`] points
//! over the patch, without the motion during the echo and without waves. How strong the facets are that enter
//! and leave a following patch ([`edge_db`]) is evaluated only on request, because it needs every facet.
//!
//! `B` is the bandwidth (Hz), `c` the speed of light, theta from the vertical.

pub mod description;
pub mod hidden_targets;
pub mod emitter_budget;
pub mod link_budget;
pub mod polarisation;
mod pulse_length;
mod ships;

use serde::Serialize;

pub use ships::{DENSITY_KGPM3, ShipOutlook, presence_word};

use crate::frames::{Earth, Enu, Point, Vector};
use crate::geometry::horizon;
use crate::paths::snapshot::Snapshot;
use crate::pipeline::build::PulseStream;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::prepared::{Moment, Prepared};
use crate::pipeline::stages::PulseFactory;
use crate::radar::fault::{RadarError, mounts};
use crate::radar::waveform::Waveform;
use crate::radar::window::Window;
use crate::scene::sea::{FacetScattering, Phases, Speckle};
use crate::scene::{Patch, Scene, Sea};
use crate::sea::realise::Realised;
use crate::sea::spectrum::moments::Moments;
use crate::sea::spectrum::{MAX_WAVE_NUMBER_RAD_M, sampling};
use crate::sea::wind::EXTRAPOLATED_ABOVE_MPS;
use crate::transport::schedule::Schedule;
use crate::units::{SPEED_OF_LIGHT_MPS, neat};

/// Power that may come and go with the edge rows of a following patch, dB below all that is received.
pub const EDGE_BUDGET_DB: f64 = -60.0;
/// Modes of the tilts that grazing angles need: with fewer HH loses more than 0.1 dB, below this sine.
pub const GRAZING_MODES: usize = 6;
const GRAZING_SINE: f64 = 0.2;
/// Modes below which tilts across or along the wind are left out at any angle.
const LEAST_MODES: usize = 3;
/// Points along a side of the patch at which geometry is taken.
pub const LATTICE: usize = 33;
/// Longest waves that count for the significant height, rad/m: 60 km.
const LONGEST_RAD_M: f64 = 1e-4;

/// A sea in figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Adequacy {
    /// Wind at 10 m, m/s.
    pub u10_mps: f64,
    /// Wind at 12.5 m, m/s.
    pub u12_5_mps: f64,
    /// Wind at 19.5 m, m/s.
    pub u19_5_mps: f64,
    /// Friction velocity in the profile of Cardone, m/s.
    pub ustar_mps: f64,
    /// Whether the wind is too weak to raise waves.
    pub calm: bool,
    /// Significant wave height that the spectrum means, m.
    pub significant_height_m: f64,
    /// Length of the waves at the peak of the spectrum, m; `None` for a flat sea.
    pub peak_wavelength_m: Option<f64>,
    /// Length that a patch should have for this spectrum, m.
    pub least_length_m: f64,
    /// Facets.
    pub facets: usize,
    /// Finest cell in ground range at the centre of the patch over the instants looked at, m; `None` where
    /// range does not resolve the patch there.
    pub ground_range_m: Option<f64>,
    /// Its extent in azimuth, `scene.azimuth_resolution_m`.
    pub azimuth_resolution_m: f64,
    /// Facets in that cell.
    pub facets_per_cell: Option<f64>,
    /// Least share of the patch whose whole echo lies in the window, over the instants looked at.
    pub share_in_window: f64,
    /// Of a following patch, [`edge_db`] once it has been looked at.
    pub edge_db: Option<f64>,
    /// Ships, in their order.
    pub ships: Vec<ShipOutlook>,
    /// What is legal but worth knowing.
    #[serde(skip)]
    pub warnings: Vec<String>,
}

/// The power that comes and goes when a following patch moves by one row, dB below all that is received: the
/// worst of the first, middle and last pulse, all facets illuminated; along an axis on which the patch lies
/// the same at all three, nothing comes or goes. `None` where the patch stays. A warning is due above
/// [`EDGE_BUDGET_DB`].
///
/// # Errors
/// A track that ends before the last pulse.
pub fn edge_db(factory: &PulseFactory, schedule: &Schedule) -> Result<Option<f64>, RadarError> {
    if !factory.follows() {
        return Ok(None);
    }
    let last = schedule.end().saturating_sub(1);
    let snapshots = factory.snapshots(&[schedule.first, schedule.first + schedule.count / 2, last])?;
    let first = |snapshot: &Snapshot| snapshot.patch.first;
    let moves =
        [0, 1].map(|axis| snapshots.windows(2).any(|two| first(&two[0])[axis] != first(&two[1])[axis]));
    let edges = snapshots.iter().map(|snapshot| snapshot.edge_db(factory.channel_pairs(), moves));
    Ok(edges.reduce(f64::max))
}

/// The adequacy of the sea of a run that is built, the edge of a patch that follows included.
///
/// # Errors
/// As of [`adequacy`], and a track that ends before the last pulse.
pub fn adequacy_with_edge(stream: &PulseStream) -> Result<Option<Adequacy>, BuildErrors> {
    let Some(mut sea) = adequacy(stream.prepared())? else { return Ok(None) };
    sea.edge_db = edge_db(stream.factory(), stream.schedule()).map_err(BuildErrors::from)?;
    let strong = sea.edge_db.filter(|edge| *edge > EDGE_BUDGET_DB);
    sea.warnings.extend(strong.map(|edge_db| {
        format!(
            "facets entering and leaving the moving patch contribute at {edge_db:.0} dB of the sea echo; below {EDGE_BUDGET_DB} dB \
             the edge is negligible: a larger patch or a shorter window helps"
        )
    }));
    Ok(Some(sea))
}

/// The adequacy of a run's sea; `None` without one.
///
/// # Errors
/// What keeps the run from being built: wind, spectrum, waveform, tracks that end early, ships.
pub fn adequacy(prepared: &Prepared) -> Result<Option<Adequacy>, BuildErrors> {
    let Some((sea, Realised { wind, spectrum, .. })) = prepared.sea()? else { return Ok(None) };
    let waveform = prepared.waveform()?;
    let moments = Moments::of(spectrum.as_ref(), [LONGEST_RAD_M, MAX_WAVE_NUMBER_RAD_M]);
    let peak_rad_m = spectrum.peak_rad_m();
    let mut adequacy = Adequacy {
        u10_mps: wind.u10_mps,
        u12_5_mps: wind.u12_5_mps,
        u19_5_mps: wind.u19_5_mps,
        ustar_mps: wind.ustar_cardone_mps,
        calm: wind.is_calm(),
        significant_height_m: moments.significant_height_m(),
        peak_wavelength_m: (peak_rad_m > 0.0).then(|| std::f64::consts::TAU / peak_rad_m),
        least_length_m: sampling::least_length_m(spectrum.as_ref(), sampling::BAND_STEP),
        facets: sea.patch.len(),
        ground_range_m: None,
        azimuth_resolution_m: sea.azimuth_resolution_m,
        facets_per_cell: None,
        share_in_window: 1.0,
        edge_db: None,
        ships: Vec::new(),
        warnings: Vec::new(),
    };
    let size_m = sea.patch.size_m();
    if size_m.iter().any(|&side| side < adequacy.least_length_m) {
        adequacy.warnings.push(format!(
            "the patch of {} m x {} m is shorter than the {:.0} m that its spectrum asks for: long waves are coarsely drawn",
            size_m[0], size_m[1], adequacy.least_length_m
        ));
    }
    if wind.is_extrapolated() {
        adequacy.warnings.push(format!(
            "wind of {:.1} m/s at 10 m: above {EXTRAPOLATED_ABOVE_MPS} m/s the laws of wind and waves are extrapolations, \
             and a linear sea is a rough model",
            wind.u10_mps
        ));
    }
    let mut known = Known::default();
    for at in prepared.spread(3) {
        assess(at, sea, waveform.as_ref(), &mut known, &mut adequacy)?;
    }
    ships::ships(prepared, sea, &mut adequacy)?;
    warn_of_modes(&sea.scattering, known.least_grazing_sine, &mut adequacy.warnings);
    if let Some(ground_range_m) = adequacy.ground_range_m {
        let facet_m = sea.patch.facet_m;
        let azimuth_m = sea.azimuth_resolution_m;
        let (cell_m, speckle) = ([ground_range_m, azimuth_m], sea.scattering.speckle);
        let facets = sampling::facets_per_cell(facet_m, cell_m);
        adequacy.facets_per_cell = Some(facets);
        let enough_m = sampling::longest_facet_m(cell_m, speckle);
        // A millimetre more is none.
        if facet_m > enough_m + 1e-3 {
            // Two digits, never more than would do.
            let unit_m = 10f64.powf(enough_m.log10().floor() - 1.0);
            let at_most_m = neat((enough_m / unit_m).floor() * unit_m);
            let more = (facet_m / at_most_m).powi(2);
            let rule = match speckle {
                Speckle::RandomPhase if facets < sampling::LEAST_FACETS_PER_CELL => format!(
                    "below {} of random phase its speckle is not Rayleigh's; sea.scattering.speckle = \"gaussian\" needs one, of at most \
                     {} m, or",
                    sampling::LEAST_FACETS_PER_CELL,
                    neat((100.0 * cell_m[0].min(cell_m[1])).floor() / 100.0)
                ),
                _ => "a facet should not be longer than it;".to_owned(),
            };
            adequacy.warnings.push(format!(
                "{facets:.1} facets in a resolution cell of {ground_range_m:.2} m ground range x {azimuth_m} m azimuth \
                 (scene.azimuth_resolution_m): {rule} scene.facet_m of at most {at_most_m} would do, with {more:.1} times as many facets"
            ));
        }
    }
    Ok(Some(adequacy))
}

/// What too few modes of the tilts of Gaussian facets leave out.
fn warn_of_modes(scattering: &FacetScattering, grazing_sine: Option<f64>, warnings: &mut Vec<String>) {
    let Speckle::Gaussian { tilt_modes } = scattering.speckle else { return };
    if !scattering.tilt_average || scattering.phases == Phases::Single {
        return;
    }
    if tilt_modes < LEAST_MODES {
        warnings.push(format!(
            "sea.scattering.tilt_modes = {tilt_modes} leaves out tilts, and most of the cross-polarised echo; {LEAST_MODES} would do"
        ));
    } else if let Some(sine) = grazing_sine.filter(|sine| *sine < GRAZING_SINE && tilt_modes < GRAZING_MODES)
    {
        warnings.push(format!(
            "the sea is looked at from {:.1} degrees above it: with fewer sea.scattering.tilt_modes than {GRAZING_MODES} its echo is \
             too weak, by 1 dB in HH and 2.5 dB in HV at 5 degrees with {LEAST_MODES}",
            sine.asin().to_degrees()
        ));
    }
}

/// What has been warned of at an earlier pulse.
#[derive(Default)]
struct Known<'a> {
    outside: bool,
    /// Of the grazing angle of the first pair in the middle of the patch.
    least_grazing_sine: Option<f64>,
    beyond_horizon: Vec<&'a str>,
}

/// The patch as it is seen at a pulse.
fn assess<'a>(
    at: Moment<'a>,
    sea: &Sea,
    waveform: &dyn Waveform,
    known: &mut Known<'a>,
    adequacy: &mut Adequacy,
) -> Result<(), BuildErrors> {
    let (scene, radar) = (at.scene(), &at.scene().radar);
    let (bandwidth_hz, pulse_s) = (waveform.bandwidth_hz(), waveform.duration_s());
    let patch = at.patch(sea)?;
    let pairs = radar.pairs();
    let ends = pairs.iter().map(|pair| at.ends(*pair)).collect::<Result<Vec<_>, _>>()?;
    let points = lattice(scene, &patch);
    let Some((first, rest)) = ends.split_first() else { return Ok(()) };

    let key = [0, 1].map(|axis| patch.first[axis] + (patch.facets[axis] / 2) as i64);
    let [x_m, y_m] = patch.centre_m(key);
    let middle = scene.frame.above_sea(x_m, y_m, 0.0);
    let sines = first.iter().map(|end| toward(*end, middle).to_array()[2].max(0.0));
    known.least_grazing_sine = sines.chain(known.least_grazing_sine).reduce(f64::min);
    let gradient = first.iter().fold(Vector::<Enu>::ZERO, |sum, end| sum + toward(*end, middle));
    let [east, north, _] = gradient.to_array();
    let ground_range_m = SPEED_OF_LIGHT_MPS / (bandwidth_hz * east.hypot(north));
    let [width_m, height_m] = patch.size_m();
    // Below an antenna the cell grows without bound.
    if ground_range_m <= width_m.hypot(height_m) {
        let finest_m = adequacy.ground_range_m.map_or(ground_range_m, |known| known.min(ground_range_m));
        adequacy.ground_range_m = Some(finest_m);
    }

    let starts_s = at.open_s(&pairs)?;
    let opens_s = starts_s.first().copied().unwrap_or(0.0);
    let closes_s = Window::new(radar, opens_s, pulse_s).close_s - pulse_s;
    let interval_s = 1.0 / radar.emissions.mean_prf_hz();
    let mut patch_s = [f64::INFINITY, f64::NEG_INFINITY];
    let mut held = 0_usize;
    for (ends, opens_s) in std::iter::once(first).chain(rest).zip(starts_s) {
        let window = Window::new(radar, opens_s, pulse_s);
        for point in &points {
            let delay_s = ends.iter().map(|end| (*end - *point).norm()).sum::<f64>() / SPEED_OF_LIGHT_MPS;
            patch_s = [patch_s[0].min(delay_s), patch_s[1].max(delay_s)];
            held += usize::from(radar.sent.is_some() || window.receives(delay_s, interval_s));
        }
    }
    let share = held as f64 / (ends.len() * points.len()) as f64;
    if held == 0 && !std::mem::replace(&mut known.outside, true) {
        let us = |times_s: [f64; 2]| times_s.map(|s| (s * 1e8).round() / 1e2);
        adequacy.warnings.push(format!(
            "the receive window misses the patch at pulse {}: it holds full echoes that begin {:?} us after the emission, \
             those of the patch begin {:?} us",
            at.pulse,
            us([opens_s, closes_s]),
            us(patch_s)
        ));
    }
    adequacy.share_in_window = adequacy.share_in_window.min(share);
    horizons(at, &points, known, adequacy)
}

/// Which antennas do not see all of the patch: each is named once.
fn horizons<'a>(
    at: Moment<'a>,
    points: &[Point<Enu>],
    known: &mut Known<'a>,
    adequacy: &mut Adequacy,
) -> Result<(), BuildErrors> {
    let scene = at.scene();
    let earth = scene.frame.earth();
    if earth == Earth::Flat {
        return Ok(());
    }
    for (name, mount) in mounts(&scene.radar) {
        let end = at.phase_centre(mount)?.position;
        let horizon_m = horizon::distance_m(earth, [horizon::height_m(earth, end), 0.0]);
        let away_m = || points.iter().map(|point| horizon::apart_m(end, *point));
        let share = away_m().filter(|far_m| *far_m > horizon_m).count() as f64 / points.len() as f64;
        if share == 0.0 || known.beyond_horizon.contains(&name) {
            continue;
        }
        known.beyond_horizon.push(name);
        let hidden = scene.frame.hiding_earth() != Earth::Flat;
        let dark = if hidden {
            " and are dark"
        } else {
            ", and are illuminated all the same (scene.horizon = false)"
        };
        adequacy.warnings.push(format!(
            "{:.0} % of the patch lie beyond the horizon of \"{name}\" at pulse {}{dark}: it sees the sea to {:.1} km, the patch \
             lies {:.1} to {:.1} km away",
            100.0 * share,
            at.pulse,
            horizon_m / 1e3,
            away_m().fold(f64::INFINITY, f64::min) / 1e3,
            away_m().fold(0.0, f64::max) / 1e3
        ));
    }
    Ok(())
}

/// Points of the mean surface over the patch, its corners among them.
fn lattice(scene: &Scene, patch: &Patch) -> Vec<Point<Enu>> {
    let low = patch.centre_m(patch.first);
    let steps = patch.facets.map(|n| (n - 1) as f64 * patch.facet_m / (LATTICE - 1) as f64);
    let place = |i: usize, axis: usize| low[axis] + i as f64 * steps[axis];
    (0..LATTICE * LATTICE)
        .map(|i| scene.frame.above_sea(place(i % LATTICE, 0), place(i / LATTICE, 1), 0.0))
        .collect()
}

/// Unit vector from a point towards an antenna; zero where they coincide.
fn toward(end: Point<Enu>, point: Point<Enu>) -> Vector<Enu> {
    Vector::from_raw((end - point).raw().normalize_or_zero())
}
