//! From which pulses a pixel is made.

use super::{DopplerBand, FocusError, Focuser, boresight};
use crate::processor::backproject::{Aperture, Gate};
use crate::recording::RecordingError;
use crate::recording::ground::Ground;
use crate::recording::instrument::AntennaRow;

impl Focuser<'_> {
    /// The Doppler weights (gate) of a channel, whose pulses in use are `illuminated`: as asked, or as wide
    /// as the pulse rate of the channel where some pixel lies beyond that in some pulse.
    pub(super) fn gate(
        &self,
        aperture: &Aperture,
        channel: usize,
        illuminated: &[usize],
    ) -> Result<Option<Gate>, FocusError> {
        let asked_hz = match self.settings.doppler {
            DopplerBand::All => return Ok(None),
            DopplerBand::Hz(hz) => Some(hz),
            DopplerBand::WhereNeeded => None,
        };
        let header = &self.recording.header;
        let rate_hz = header.prf_hz * illuminated.len() as f64 / self.recording.pulses().max(1) as f64;
        let Some(aim_hz) = self.aims_hz(aperture, channel, illuminated)? else {
            return match asked_hz {
                Some(hz) => Err(FocusError::NoAim { hz, channel: header.channels[channel].name.clone() }),
                None => Ok(None),
            };
        };
        let bandwidth_hz = asked_hz.unwrap_or(rate_hz);
        let gate = Gate { bandwidth_hz, taper: self.settings.aperture, aim_hz };
        let needed = asked_hz.is_some() || reaches_beyond(&gate, aperture, &self.ground);
        Ok(needed.then_some(gate))
    }

    /// Doppler of the aim in every pulse, Hz; none where an antenna that moves has no aim.
    fn aims_hz(
        &self,
        aperture: &Aperture,
        channel: usize,
        illuminated: &[usize],
    ) -> Result<Option<Vec<f64>>, FocusError> {
        let recording = self.recording;
        let row = &recording.header.channels[channel];
        let (Some(first), Some(last)) = (illuminated.first(), illuminated.last()) else { return Ok(None) };
        let mut boresights = Vec::new();
        for (name, path) in [(&row.transmitter, aperture.transmitter), (&row.receiver, aperture.receiver)] {
            let rests = path.at(recording.emission_s[*first]) == path.at(recording.emission_s[*last]);
            if self.is_isotropic(name) && !rests {
                return Ok(None);
            }
            match recording.boresights(name) {
                Ok(known) => boresights.push(known),
                Err(RecordingError::Missing { .. }) => {
                    let Some(instrument) = &self.instrument else { return Ok(None) };
                    match boresight::boresights(recording, instrument, (name, path))? {
                        Some(reported) => boresights.push(reported),
                        None => return Ok(None),
                    }
                }
                Err(error) => return Err(error.into()),
            }
        }
        let aim = |(echo, pulse): (_, &usize)| {
            let at = |end: usize| boresights[end].get(*pulse).copied().unwrap_or([f64::NAN; 3]);
            aperture.aim_hz(echo, [at(0), at(1)])
        };
        Ok(Some(aperture.pulses.iter().zip(illuminated).map(aim).collect()))
    }

    /// Whether an antenna radiates alike in all directions, so that its boresight is no aim. One that is not
    /// described counts as one that has an aim.
    fn is_isotropic(&self, name: &str) -> bool {
        let antenna = self.instrument.as_ref().and_then(|instrument| instrument.antenna(name));
        antenna.is_some_and(AntennaRow::is_isotropic)
    }
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
