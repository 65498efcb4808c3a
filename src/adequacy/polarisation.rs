//! Whether antennas are used where their polarisation bases say little: far off the boresight of an aperture,
//! near the vertical of an isotropic antenna.
//!
//! Directions in use are those to targets, to the patch of sea, and to the other end of the direct path, at
//! the first, middle and last pulse, where the gain of the antenna lies within [`USED_DB`] of its peak.

use glam::DVec3;

use super::lattice;
use super::link_budget::open_all;
use crate::frames::{Enu, Point, Vector};
use crate::motion::pointing::PhaseCentre;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::prepared::{Moment, Prepared};
use crate::radar::antenna::Antenna;
use crate::radar::fault::mounts;
use crate::scattering::target::Scatterer;
use crate::scene::Target;
use crate::scene::radar::{AntennaMount, PolarisationBasis};

/// One-way power below the peak at which a direction is no longer one that an antenna is used in, dB.
pub const USED_DB: f64 = 30.0;
/// Angle off the boresight beyond which ports of an aperture are not those of a real antenna, degrees.
pub const WIDEST_DEG: f64 = 60.0;
/// Angle to the vertical within which H and V of an isotropic antenna turn quickly with the azimuth, degrees.
pub const OVERHEAD_DEG: f64 = 10.0;

/// What is worth knowing of the polarisation bases of a run: of each antenna the worst direction.
///
/// # Errors
/// Patterns that cannot be read, tracks that end before the run.
pub fn polarisation(prepared: &Prepared) -> Result<Vec<String>, BuildErrors> {
    let scene = prepared.scene();
    let antennas = open_all(&scene.radar)?;
    let mut warnings = Vec::new();
    for (place, ((name, mount), antenna)) in mounts(&scene.radar).zip(&antennas).enumerate() {
        let mut worst: Option<(f64, String)> = None;
        for at in prepared.spread(3) {
            let (PhaseCentre { position: own, .. }, frame) = at.antenna(mount)?;
            let up = scene.frame.earth().up(own).raw();
            for (towards, point) in used(at, place)? {
                let Some(d) = (point - own).raw().try_normalize() else { continue };
                let in_frame = frame.inverse() * Vector::<Enu>::from_raw(d);
                let found = judge(antenna, mount, in_frame.raw(), d, up);
                let Some((badness, off_deg)) = found else { continue };
                if worst.as_ref().is_none_or(|(known, _)| badness > *known) {
                    let pulse = at.pulse;
                    let warning = match PolarisationBasis::of(&mount.pattern) {
                        PolarisationBasis::Ludwig3 => format!(
                            "\"{name}\" is used {off_deg:.0} degrees off its boresight at pulse {pulse} (towards {towards}), less than {USED_DB} dB \
                             below its peak gain: beyond {WIDEST_DEG} degrees H and V by Ludwig's third definition are not those of a real antenna; \
                             point it there"
                        ),
                        PolarisationBasis::LocalHorizontal => format!(
                            "isotropic antenna \"{name}\" is used {off_deg:.1} degrees from the vertical at pulse {pulse} (towards {towards}): within \
                             {OVERHEAD_DEG} degrees its H and V turn with the azimuth, and straight up and down they have no limit; an aperture \
                             that points there has"
                        ),
                    };
                    worst = Some((badness, warning));
                }
            }
        }
        warnings.extend(worst.map(|(_, warning)| warning));
    }
    Ok(warnings)
}

/// How bad a direction is, and the angle that shows it, degrees; `None` where it is fine or not in use.
fn judge(
    antenna: &Antenna,
    mount: &AntennaMount,
    in_frame: DVec3,
    d: DVec3,
    up: DVec3,
) -> Option<(f64, f64)> {
    match PolarisationBasis::of(&mount.pattern) {
        PolarisationBasis::LocalHorizontal => {
            let off_deg = d.cross(up).length().clamp(0.0, 1.0).asin().to_degrees();
            (off_deg < OVERHEAD_DEG).then_some((-off_deg, off_deg))
        }
        PolarisationBasis::Ludwig3 => {
            let off_deg = in_frame.x.clamp(-1.0, 1.0).acos().to_degrees();
            let gain = |d: DVec3| antenna.field_gain(Vector::from_raw(d)).norm();
            let in_use = || gain(in_frame) > gain(DVec3::X) * 10f64.powf(-USED_DB / 20.0);
            (off_deg > WIDEST_DEG && in_use()).then_some((off_deg, off_deg))
        }
    }
}

/// What antenna `place` (transmitters first) looks at.
fn used(at: Moment<'_>, place: usize) -> Result<Vec<(String, Point<Enu>)>, BuildErrors> {
    let (scene, radar) = (at.scene(), &at.scene().radar);
    let of_target = |target: &Target| {
        (format!("target \"{}\"", target.name), Scatterer::at(target, at.elapsed_s).position)
    };
    let mut points: Vec<(String, Point<Enu>)> = scene.targets.iter().map(of_target).collect();
    if let Some(sea) = &scene.sea {
        let lattice = lattice(scene, &at.patch(sea)?);
        points.extend(lattice.into_iter().map(|point| ("the patch of sea".to_owned(), point)));
    }
    if radar.direct_path {
        for pair in radar.pairs() {
            let (tx, rx) = (&radar.transmitters[pair.transmitter], &radar.receivers[pair.receiver]);
            let (name, other) = if pair.transmitter == place {
                (&rx.name, &rx.antenna)
            } else if radar.transmitters.len() + pair.receiver == place {
                (&tx.name, &tx.antenna)
            } else {
                continue;
            };
            points.push((format!("\"{name}\" on the direct path"), at.phase_centre(other)?.position));
        }
    }
    Ok(points)
}
