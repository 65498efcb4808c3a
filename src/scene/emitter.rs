//! What else radiates: another radar, a beacon, a jammer, by a schedule, carrier and waveform of its own.

use super::radar::{Channel, Polarisation, Radar, RainClutter, Transmitter, TxPolarisation, Waveform};
use crate::time::PulseTimes;

/// An emitter beside the transmitters of a radar. Whatever receivers take of it is added to their channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Emitter {
    /// Name, power of its one polarisation, antenna.
    pub transmitter: Transmitter,
    /// Carrier frequency, Hz.
    pub carrier_hz: f64,
    /// What it radiates.
    pub waveform: Waveform,
    /// When its pulses leave, relative to pulse 0 of the radar; none after the radar's last.
    pub emissions: PulseTimes,
    /// Polarisation of all of them.
    pub polarisation: Polarisation,
    /// Receivers that take it, by their places in [`Radar`].
    pub receivers: Vec<usize>,
    /// Whether the direct path is received.
    pub direct_path: bool,
    /// Whether sea, ships and targets return it.
    pub echo: bool,
}

impl Emitter {
    /// Above the carrier of the radar, Hz.
    pub fn offset_hz(&self, radar: &Radar) -> f64 {
        self.carrier_hz - radar.carrier_hz
    }

    /// The radar as it receives this emitter: one more transmitter, its carrier, waveform and schedule, and a
    /// channel for every port of a receiver that takes it. Without rain clutter.
    pub fn received_by(&self, radar: &Radar) -> Radar {
        let mut heard = radar.clone();
        heard.emitters.clear();
        heard.transmitters.push(self.transmitter.clone());
        heard.carrier_hz = self.carrier_hz;
        heard.waveform = self.waveform.clone();
        heard.emissions = self.emissions.clone();
        heard.tx_polarisation = TxPolarisation::Simultaneous;
        heard.direct_path = self.direct_path;
        heard.rain_clutter = None::<RainClutter>;
        heard.channels.clear();
        for channel in radar.channels.iter().filter(|own| self.receivers.contains(&own.receiver)) {
            let port = (channel.receiver, channel.rx);
            if heard.channels.iter().all(|own| (own.receiver, own.rx) != port) {
                let transmitter = radar.transmitters.len();
                heard.channels.push(Channel { transmitter, tx: self.polarisation, ..channel.clone() });
            }
        }
        heard
    }
}
