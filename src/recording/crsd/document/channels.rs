//! Transmit sequences, channels, and the reference geometry.

use std::io;

use super::*;
use crate::recording::crsd::reference::local;

fn polarisation(xml: &mut Xml, name: &str, of: Polarisation, at: &TwoAxes) -> io::Result<()> {
    let id = match of {
        Polarisation::H => "H",
        Polarisation::V => "V",
        Polarisation::R => "RHC",
        Polarisation::L => "LHC",
    };
    xml.within(name, |xml| {
        xml.text("PolarizationID", id)?;
        xml.real("AmpH", at.amplitudes[0])?;
        xml.real("AmpV", at.amplitudes[1])?;
        xml.real("PhaseH", at.phases[0])?;
        xml.real("PhaseV", at.phases[1])
    })
}

impl Facts {
    pub(super) fn sequences(&self, xml: &mut Xml, area: &Area) -> io::Result<()> {
        let description = &self.description;
        let header = &description.header;
        let (_, reference, ..) = self.reference();
        xml.within("TxSequence", |xml| {
            xml.text("RefTxId", &reference.id)?;
            xml.text("TxWFType", "LFM")?;
            description.sequences.iter().enumerate().try_for_each(|(i, sequence)| {
                let [tx1, tx2] = Self::span(&self.pulses[i..=i], "TxTime");
                let seen = state(&self.pulses[i][1], "Tx");
                let name = &description.ends[sequence.end].name;
                xml.within("Parameters", |xml| {
                    xml.text("Identifier", &sequence.id)?;
                    xml.text("RefPulseIndex", self.counts[i] / 2)?;
                    xml.text("FxResponseId", support_id(RESPONSE_NAME))?;
                    xml.text("FxBWFixed", true)?;
                    xml.real("FxC", header.carrier_hz)?;
                    xml.real("FxBW", header.bandwidth_hz)?;
                    xml.real("TXmtMin", header.pulse_s)?;
                    xml.real("TXmtMax", header.pulse_s)?;
                    xml.real("TxTime1", tx1)?;
                    xml.real("TxTime2", tx2)?;
                    xml.text("TxAPCId", name)?;
                    xml.text("TxAPATId", pattern_id(name, sequence.polarisation))?;
                    reference_point(xml, "TxRefPoint", area)?;
                    let at = at_point(&seen, port(sequence.polarisation), area.point, 1.0);
                    polarisation(xml, "TxPolarization", sequence.polarisation, &at)?;
                    xml.real("TxRefRadIntensity", sequence.intensity_dbw)?;
                    xml.real("TxRadIntErrorStdDev", 0.0)?;
                    xml.real("TxRefLAtm", self.air_db(&seen, area, sequence.polarisation))
                })
            })
        })
    }

    fn air_db(&self, seen: &State, area: &Area, port: Polarisation) -> f64 {
        let way_m = seen.position_m - area.point;
        let [_, _, up] = local(area.point);
        let rise = up.dot(way_m.normalize_or_zero());
        1e-3 * way_m.length() * (self.description.air_db_per_km + self.description.rain.of(port, rise))
    }

    pub(super) fn channels(&self, xml: &mut Xml, area: &Area) -> io::Result<()> {
        let description = &self.description;
        xml.within("Channel", |xml| {
            xml.text("RefChId", &description.channels[0].id)?;
            (0..description.channels.len()).try_for_each(|i| self.channel(xml, area, i))
        })
    }

    fn channel(&self, xml: &mut Xml, area: &Area, i: usize) -> io::Result<()> {
        let description = &self.description;
        let header = &description.header;
        let channel = &description.channels[i];
        let sequence = &description.sequences[channel.sequence];
        let middle = self.counts[channel.sequence] / 2;
        let [start1, start2] = Self::span(&self.vectors[i..=i], "RcvStart");
        let band = self.received_band();
        let seen = state(&self.vectors[i][1], "Rcv");
        let name = &description.ends[channel.end].name;
        xml.within("Parameters", |xml| {
            xml.text("Identifier", &channel.id)?;
            xml.text("RefVectorIndex", middle)?;
            xml.text("RefFreqFixed", true)?;
            xml.text("FrcvFixed", true)?;
            xml.text("SignalNormal", true)?;
            xml.real("F0Ref", header.carrier_hz)?;
            xml.real("Fs", header.sample_rate_hz)?;
            xml.real("BWInst", FLAT * header.sample_rate_hz)?;
            xml.real("RcvStartTime1", start1)?;
            xml.real("RcvStartTime2", start2)?;
            xml.real("FrcvMin", band[0])?;
            xml.real("FrcvMax", band[1])?;
            xml.text("RcvAPCId", name)?;
            xml.text("RcvAPATId", pattern_id(name, channel.polarisation))?;
            reference_point(xml, "RcvRefPoint", area)?;
            let at = at_point(&seen, port(channel.polarisation), area.point, -1.0);
            polarisation(xml, "RcvPolarization", channel.polarisation, &at)?;
            xml.real("RcvRefIrradiance", channel.irradiance_dbw)?;
            xml.real("RcvIrradianceErrorStdDev", 0.0)?;
            xml.real("RcvRefLAtm", self.air_db(&seen, area, channel.polarisation))?;
            xml.real("PNCRSD", description.noise_w)?;
            xml.real("BNCRSD", NOISE)?;
            xml.within("SARImage", |xml| {
                xml.text("TxId", &sequence.id)?;
                xml.text("RefVectorPulseIndex", middle)?;
                let sent = state(&self.pulses[channel.sequence][1], "Tx");
                let at = at_point(&sent, port(sequence.polarisation), area.point, 1.0);
                polarisation(xml, "TxPolarization", sequence.polarisation, &at)?;
                xml.within("DwellTimes", |xml| {
                    xml.within("Polynomials", |xml| {
                        xml.text("CODId", DWELL)?;
                        xml.text("DwellId", DWELL)
                    })
                })?;
                image_area(xml, area)
            })
        })
    }

    /// Middle and length of the recording, s.
    fn dwell_s(&self) -> [f64; 2] {
        let [first, last] = Self::span(&self.pulses, "TxTime");
        [0.5 * (first + last), last - first]
    }

    pub(super) fn reference_geometry(&self, xml: &mut Xml, area: &Area) -> io::Result<()> {
        let (_, _, pulse, vector) = self.reference();
        let ends = [state(pulse, "Tx"), state(vector, "Rcv")];
        let Geometry { transmitter, receiver, both } = Geometry::of(ends, area.point);
        let (sent_s, received_s) = (pulse.time_s("TxTime"), vector.time_s("RcvStart"));
        let part = transmitter.slant_m / (transmitter.slant_m + receiver.slant_m);
        xml.within("ReferenceGeometry", |xml| {
            reference_point(xml, "RefPoint", area)?;
            xml.within("SARImage", |xml| {
                let [middle_s, length_s] = self.dwell_s();
                xml.real("CODTime", middle_s)?;
                xml.real("DwellTime", length_s)?;
                xml.real("ReferenceTime", sent_s + part * (received_s - sent_s))?;
                xml.vector("ARPPos", both.reference.position_m)?;
                xml.vector("ARPVel", both.reference.velocity_mps)?;
                xml.real("BistaticAngle", both.angle_deg)?;
                xml.real("BistaticAngleRate", both.angle_rate_deg)?;
                angles(xml, &both.reference)?;
                xml.real("TwistAngle", both.twist_deg)?;
                xml.real("SlopeAngle", both.slope_deg)?;
                xml.real("LayoverAngle", both.layover_deg)
            })?;
            for (name, time_s, way) in
                [("TxParameters", sent_s, &transmitter), ("RcvParameters", received_s, &receiver)]
            {
                xml.within(name, |xml| {
                    xml.real("Time", time_s)?;
                    xml.vector("APCPos", way.position_m)?;
                    xml.vector("APCVel", way.velocity_mps)?;
                    angles(xml, way)
                })?;
            }
            Ok(())
        })
    }

    pub(super) fn dwell(&self, xml: &mut Xml) -> io::Result<()> {
        let [middle_s, length_s] = self.dwell_s();
        let times = [("COD", "CODTime", middle_s), ("Dwell", "DwellTime", length_s)];
        xml.within("DwellPolynomials", |xml| {
            times.into_iter().try_for_each(|(_, name, seconds)| {
                xml.text(&format!("Num{name}s"), 1)?;
                xml.within(name, |xml| {
                    xml.text("Identifier", DWELL)?;
                    xml.with(&format!("{name}Poly"), &[("order1", "0"), ("order2", "0")], |xml| {
                        let place = [("exponent1", "0"), ("exponent2", "0")];
                        xml.text_with("Coef", &place, format!("{seconds:?}"))
                    })
                })
            })
        })
    }
}

fn angles(xml: &mut Xml, way: &OneWay) -> io::Result<()> {
    xml.text("SideOfTrack", way.side)?;
    xml.real("SlantRange", way.slant_m)?;
    xml.real("GroundRange", way.ground_m)?;
    xml.real("DopplerConeAngle", way.cone_deg)?;
    xml.real("SquintAngle", way.squint_deg)?;
    xml.real("AzimuthAngle", way.azimuth_deg)?;
    xml.real("GrazeAngle", way.graze_deg)?;
    xml.real("IncidenceAngle", way.incidence_deg)
}
