//! Support arrays, antennas and error covariances.

use std::io;

use super::*;
use crate::recording::crsd::pattern::GainArray;

impl Facts {
    pub(super) fn support(&self, xml: &mut Xml) -> io::Result<()> {
        let header = &self.description.header;
        let flat = GainArray::flat();
        let ends = self.description.ends.iter().map(|end| (end.name.as_str(), &end.array));
        xml.within("SupportArray", |xml| {
            ends.chain([(ELEMENT, &flat)]).try_for_each(|(name, array)| {
                xml.within("GainPhaseArray", |xml| {
                    xml.text("Identifier", support_id(name))?;
                    xml.text("ElementFormat", "Gain=F4;Phase=F4;")?;
                    xml.real("X0", array.first(0))?;
                    xml.real("Y0", array.first(1))?;
                    xml.real("XSS", array.step[0])?;
                    xml.real("YSS", array.step[1])?;
                    if array.has_gaps() { xml.text("NODATA", "7fc000007fc00000") } else { Ok(()) }
                })
            })?;
            xml.within("FxResponseArray", |xml| {
                xml.text("Identifier", support_id(RESPONSE_NAME))?;
                xml.text("ElementFormat", "Amp=F4;Phase=F4;")?;
                xml.real("Fx0FXR", header.carrier_hz - 0.5 * header.sample_rate_hz)?;
                xml.real("FxSSFXR", 0.5 * header.sample_rate_hz)
            })?;
            xml.within("AddedSupportArray", |xml| {
                xml.text("Identifier", support_id(REPLICA))?;
                xml.text("ElementFormat", "CF8")?;
                xml.real("X0", 0.0)?;
                xml.real("Y0", 0.0)?;
                xml.real("XSS", 1.0)?;
                xml.real("YSS", 1.0 / header.sample_rate_hz)?;
                xml.text("XUnits", "none")?;
                xml.text("YUnits", "s")?;
                xml.text("ZUnits", "1")?;
                let what = "transmitted pulse behind the receive filter, from its first edge on";
                xml.text_with("Parameter", &[("name", "meaning")], what)
            })
        })
    }

    /// Antennas with the polarisations of their ports, each once.
    fn ports(&self) -> Vec<(&str, Polarisation)> {
        let description = &self.description;
        let sent = description.sequences.iter().map(|s| (s.end, s.polarisation));
        let received = description.channels.iter().map(|c| (c.end, c.polarisation));
        let mut ports = Vec::new();
        for (end, polarisation) in sent.chain(received) {
            let port = (description.ends[end].name.as_str(), polarisation);
            if !ports.contains(&port) {
                ports.push(port);
            }
        }
        ports
    }

    pub(super) fn antennas(&self, xml: &mut Xml) -> io::Result<()> {
        let ends = &self.description.ends;
        let ports = self.ports();
        xml.within("Antenna", |xml| {
            xml.text("NumACFs", ends.len())?;
            xml.text("NumAPCs", ends.len())?;
            xml.text("NumAPATs", ports.len())?;
            for end in ends {
                xml.within("AntCoordFrame", |xml| xml.text("Identifier", &end.name))?;
            }
            for end in ends {
                xml.within("AntPhaseCenter", |xml| {
                    xml.text("Identifier", &end.name)?;
                    xml.text("ACFId", &end.name)?;
                    xml.vector("APCXYZ", DVec3::ZERO)
                })?;
            }
            ports.into_iter().try_for_each(|(name, polarisation)| {
                xml.within("AntPattern", |xml| {
                    xml.text("Identifier", pattern_id(name, polarisation))?;
                    xml.real("FreqZero", self.description.header.carrier_hz)?;
                    xml.text("ArrayGPId", support_id(name))?;
                    xml.text("ElemGPId", support_id(ELEMENT))?;
                    for scale in ["EBFreqShift", "MLFreqDilation"] {
                        xml.within(scale, |xml| {
                            xml.real("DCXSF", 0.0)?;
                            xml.real("DCYSF", 0.0)
                        })?;
                    }
                    xml.with("GainBSPoly", &[("order1", "0")], |xml| {
                        xml.text_with("Coef", &[("exponent1", "0")], "0.0")
                    })?;
                    let TwoAxes { amplitudes, phases } = port(polarisation);
                    xml.within("AntPolRef", |xml| {
                        xml.real("AmpX", amplitudes[0])?;
                        xml.real("AmpY", amplitudes[1])?;
                        xml.real("PhaseX", phases[0])?;
                        xml.real("PhaseY", phases[1])
                    })
                })
            })
        })
    }

    pub(super) fn errors(&self, xml: &mut Xml) -> io::Result<()> {
        let (channel, sequence, ..) = self.reference();
        let [sent, received] = [sequence.end, channel.end].map(|end| &self.description.ends[end]);
        let is_monostatic = self.description.is_monostatic();
        xml.within("ErrorParameters", |xml| {
            xml.within("SARImage", |xml| {
                xml.within(if is_monostatic { "Monostatic" } else { "Bistatic" }, |xml| {
                    xml.within("PosVelError", |xml| {
                        if is_monostatic {
                            xml.text("Frame", "ECF")?;
                            return xml.matrix("PVCov", &received.covariance);
                        }
                        xml.text("TxFrame", "ECF")?;
                        xml.matrix("TxPVCov", &sent.covariance)?;
                        xml.text("RcvFrame", "ECF")?;
                        xml.matrix("RcvPVCov", &received.covariance)?;
                        xml.matrix("TxRcvPVCov", &[[0.0; 6]; 6])
                    })?;
                    let [[tx_s2, tx_rate2], [rcv_s2, rcv_rate2]] = [sent.clock, received.clock];
                    xml.within("RadarSensor", |xml| {
                        if is_monostatic {
                            let rate2 = tx_rate2.max(rcv_rate2);
                            return xml.matrix("TimeFreqCov", &diagonal([tx_s2, rcv_s2, rate2]));
                        }
                        xml.matrix("TimeFreqCov", &diagonal([tx_s2, rcv_s2, tx_rate2, rcv_rate2]))
                    })
                })
            })
        })
    }
}

fn diagonal<const N: usize>(values: [f64; N]) -> [[f64; N]; N] {
    std::array::from_fn(|row| std::array::from_fn(|column| if row == column { values[row] } else { 0.0 }))
}
