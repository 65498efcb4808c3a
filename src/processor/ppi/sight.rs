//! Which channel of a radar has a plan, and what is known of its antennas.

use super::PpiError;
use super::scans::Motion;
use crate::inputs::one_line;
use crate::recording::header::Header;
use crate::recording::instrument::{AntennaRow, Instrument, Look};
use crate::units::SPEED_OF_LIGHT_MPS;

/// What is known of the antennas of a channel.
pub(crate) struct Sight {
    /// The platform of both.
    pub(crate) platform: String,
    /// How the receiver's scans.
    pub(crate) motion: Motion,
    /// Its rate, clockwise; of a sector that within a sweep.
    pub(crate) rate_deg_per_s: f64,
    /// Whether its azimuth counts from North; else from the platform's nose.
    pub(crate) is_level: bool,
    /// Two-way half-power beamwidth, rad.
    pub(crate) beam_rad: Option<f64>,
}

impl Sight {
    /// Of the channel asked for, or the first that there is a plan of, and its place.
    ///
    /// # Errors
    /// No such channel, one that is bistatic or does not scan, and pulses that cannot be compressed.
    pub(crate) fn of(header: &Header, asked: Option<&str>) -> Result<(usize, Self), PpiError> {
        if header.is_continuous() {
            return Err(PpiError::Continuous);
        }
        if header.is_dechirped() {
            return Err(PpiError::Dechirped);
        }
        let instrument = header.instrument.as_ref().ok_or(PpiError::NoInstrument)?;
        let found = chosen(header, instrument, asked)?;
        if header.replica.is_empty() { Err(PpiError::NoReplica) } else { Ok(found) }
    }
}

/// The channel asked for, or the first that there is a plan of; else what is wrong with the first.
fn chosen(header: &Header, instrument: &Instrument, asked: Option<&str>) -> Result<(usize, Sight), PpiError> {
    let all = &header.channels;
    let echoes: Vec<usize> = (0..all.len()).filter(|place| all[*place].is_of_echoes()).collect();
    if let Some(name) = asked {
        let place = echoes.iter().find(|place| all[**place].name == name).ok_or_else(|| {
            let allowed: Vec<_> = echoes.iter().map(|place| one_line(&all[*place].name)).collect();
            PpiError::Channel { name: name.to_owned(), allowed: allowed.join(", ") }
        })?;
        return Ok((*place, sight(header, instrument, *place)?));
    }
    let mut refused = None;
    for place in echoes {
        match sight(header, instrument, place) {
            Ok(sight) => return Ok((place, sight)),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    Err(refused.unwrap_or(PpiError::NoEchoes))
}

fn sight(header: &Header, instrument: &Instrument, channel: usize) -> Result<Sight, PpiError> {
    let row = &header.channels[channel];
    let antenna = |name: &str| instrument.antenna(name).ok_or(PpiError::NoInstrument);
    let (transmitter, receiver) = (antenna(&row.transmitter)?, antenna(&row.receiver)?);
    if transmitter.platform != receiver.platform {
        return Err(PpiError::Bistatic {
            channel: row.name.clone(),
            transmits: transmitter.platform.clone(),
            receives: receiver.platform.clone(),
        });
    }
    let Look::Scan { level, rate_deg_per_s, sector_deg: [from, to], .. } = receiver.look else {
        return Err(PpiError::StandsStill { channel: row.name.clone(), receiver: row.receiver.clone() });
    };
    let motion = if rate_deg_per_s == 0.0 {
        Motion::Steps
    } else if from == to {
        Motion::Rotation { rate_rad_per_s: rate_deg_per_s.to_radians() }
    } else {
        Motion::Sector { width_rad: (to - from).abs().to_radians() }
    };
    let wavelength_m = SPEED_OF_LIGHT_MPS / header.carrier_hz;
    let scanning = [transmitter, receiver].into_iter().filter(|end| matches!(end.look, Look::Scan { .. }));
    let inverse: f64 = scanning.filter_map(|end| beam_rad(end, wavelength_m)).map(|beam| beam.powi(-2)).sum();
    Ok(Sight {
        platform: receiver.platform.clone(),
        motion,
        rate_deg_per_s,
        is_level: level,
        beam_rad: (inverse > 0.0).then(|| inverse.sqrt().recip()),
    })
}

/// Half-power beamwidth of an aperture in azimuth, rad; none where it is not known.
fn beam_rad(antenna: &AntennaRow, wavelength_m: f64) -> Option<f64> {
    let [width_m, _] = antenna.aperture_m?;
    let factor = if antenna.pattern == "ellipse" { 1.029 } else { 0.886 };
    Some((factor * wavelength_m / width_m).min(std::f64::consts::TAU)).filter(|beam| *beam > 0.0)
}
