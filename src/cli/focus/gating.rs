//! From which pulses a pixel is made.

use std::str::FromStr;

use super::scenario::Scenario;
use super::{FocusArgs, Ground, Recording, RecordingError};
use crate::cli::focus::error::FocusError;
use crate::processor::backproject::{Aperture, Gate};

/// A processed Doppler bandwidth as asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DopplerBand {
    /// Every pixel takes every pulse.
    All,
    /// So wide about the aim, Hz.
    Hz(f64),
}

impl FromStr for DopplerBand {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => Ok(Self::All),
            _ => match text.parse::<f64>() {
                Ok(hz) if hz > 0.0 && hz.is_finite() => Ok(Self::Hz(hz)),
                _ => Err("allowed: a number of Hz above 0, or all".to_owned()),
            },
        }
    }
}

/// The gate of a channel, whose pulses in use are `illuminated`: as asked, or as wide as the pulse rate of
/// the channel where some pixel lies beyond that in some pulse.
pub(super) fn gate(
    args: &FocusArgs,
    recording: &Recording,
    scenario: &Scenario,
    aperture: &Aperture,
    ground: &Ground,
    channel: usize,
    illuminated: &[usize],
) -> Result<Option<Gate>, FocusError> {
    let asked_hz = match args.doppler_hz {
        Some(DopplerBand::All) => return Ok(None),
        Some(DopplerBand::Hz(hz)) => Some(hz),
        None => None,
    };
    let row = &recording.header.channels[channel];
    let rate_hz = recording.header.prf_hz * illuminated.len() as f64 / recording.pulses().max(1) as f64;
    let Some(aim_hz) = aims(recording, scenario, aperture, channel, illuminated)? else {
        return match asked_hz {
            Some(hz) => Err(FocusError::NoAim { hz, channel: row.name.clone() }),
            None => Ok(None),
        };
    };
    let gate = Gate { bandwidth_hz: asked_hz.unwrap_or(rate_hz), taper: args.aperture.taper(), aim_hz };
    let needed = asked_hz.is_some() || reaches_beyond(&gate, aperture, ground);
    Ok(needed.then_some(gate))
}

/// Doppler of the aim in every pulse, Hz; none where an antenna that moves has no aim.
fn aims(
    recording: &Recording,
    scenario: &Scenario,
    aperture: &Aperture,
    channel: usize,
    illuminated: &[usize],
) -> Result<Option<Vec<f64>>, FocusError> {
    let row = &recording.header.channels[channel];
    let ends = [
        ("transmitter", &row.transmitter, aperture.transmitter),
        ("receiver", &row.receiver, aperture.receiver),
    ];
    let (Some(first), Some(last)) = (illuminated.first(), illuminated.last()) else { return Ok(None) };
    let mut boresights = Vec::new();
    for (kind, name, path) in ends {
        let rests = path.at(recording.emission_s[*first]) == path.at(recording.emission_s[*last]);
        if scenario.is_isotropic(kind, name) && !rests {
            return Ok(None);
        }
        match recording.boresights(name) {
            Ok(known) => boresights.push(known),
            Err(RecordingError::Missing { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        }
    }
    let [out, back] = [&boresights[0], &boresights[1]];
    let aim = |(echo, pulse)| {
        let pulse: usize = pulse;
        let none = [f64::NAN; 3];
        let at = |all: &[[f64; 3]]| all.get(pulse).copied().unwrap_or(none);
        aperture.aim_hz(echo, [at(out), at(back)])
    };
    Ok(Some(aperture.pulses.iter().zip(illuminated.iter().copied()).map(aim).collect()))
}

/// Whether a corner of the image lies beyond the band in any pulse.
fn reaches_beyond(gate: &Gate, aperture: &Aperture, ground: &Ground) -> bool {
    let [columns, rows] = ground.pixels.map(|n| n as f64 - 1.0);
    let corners =
        [(0.0, 0.0), (columns, 0.0), (0.0, rows), (columns, rows)].map(|(i, j)| ground.point_m(i, j));
    aperture.pulses.iter().enumerate().any(|(place, pulse)| {
        corners.iter().any(|corner| gate.place(place, aperture.doppler_hz(pulse, *corner)).abs() > 0.5)
    })
}
