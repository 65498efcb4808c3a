//! The header and the XML of a CRSD file.
//!
//! Elements stand in the order of the standard's schema. The reference pulse and vector of a sequence or
//! channel are in its middle, the reference channel is the first one.

use std::io;
use std::sync::Arc;

use glam::DVec3;

use super::description::{Channel, Description, End, FLAT, NOISE, Sequence};
use super::records::{ADDED, Field, Known, PPP, PVP, bytes};
use super::reference::{Bistatic, OneWay, TwoAxes, at_point, local, port};
use super::states::State;
use super::writer::{Blocks, XML_AT};
use super::xml::Xml;
use crate::frames::{Ecef, Enu, Point, Vector};
use crate::scene::radar::Polarisation;
use crate::time::TimeTag;

/// Ends a section of text.
pub(super) const SECTION_END: &[u8] = b"\x0c\n";
/// Columns of the frequency response.
pub(super) const RESPONSE_COLUMNS: usize = 3;
const NAMESPACE: &str = "http://api.nsgreg.nga.mil/schema/crsd/1.0";
const CLASSIFICATION: &str = "UNCLASSIFIED";
const RELEASE: &str = "UNRESTRICTED";
const ELEMENT: &str = ":element";
const RESPONSE_NAME: &str = ":response";
const REPLICA: &str = ":replica";
/// Name of the middle of the recording and its length, as dwell times.
const DWELL: &str = "recording";
/// Half the side of the image area where there is neither sea nor target, m.
const HALF_SIDE_M: f64 = 256.0;

/// The text before the XML.
pub(super) fn file_header(blocks: &Blocks, xml: usize) -> Vec<u8> {
    let mut text = format!(
        "CRSDsar/1.0\nXML_BLOCK_SIZE := {xml}\nXML_BLOCK_BYTE_OFFSET := {XML_AT}\n\
         CLASSIFICATION := {CLASSIFICATION}\nRELEASE_INFO := {RELEASE}\n"
    );
    let named =
        [("SUPPORT", blocks.support), ("PPP", blocks.ppp), ("PVP", blocks.pvp), ("SIGNAL", blocks.signal)];
    for (name, (at, length)) in named {
        text += &format!("{name}_BLOCK_SIZE := {length}\n{name}_BLOCK_BYTE_OFFSET := {at}\n");
    }
    let mut header = text.into_bytes();
    header.extend(SECTION_END);
    header
}

/// What the XML is made from: the run, and the first, the middle and the last record of every array.
pub(super) struct Facts {
    pub description: Arc<Description>,
    pub pulses: Vec<[Known<'static>; 3]>,
    pub vectors: Vec<[Known<'static>; 3]>,
    /// Pulses of every sequence.
    pub counts: Vec<u64>,
}

/// Where the scene lies.
struct Area {
    /// Its middle, Earth-centred: the image area reference point.
    middle: DVec3,
    /// East and North, Earth-centred.
    axes: [DVec3; 2],
    /// Half its sides, m.
    half: [f64; 2],
}

impl Area {
    fn corners(&self) -> [[f64; 2]; 4] {
        let [x, y] = self.half;
        [[-x, -y], [-x, y], [x, y], [x, -y]]
    }
}

/// The XML.
pub(super) fn xml(facts: &Facts) -> io::Result<Vec<u8>> {
    let mut xml = Xml::new()?;
    let area = facts.area();
    xml.with("CRSDsar", &[("xmlns", NAMESPACE)], |xml| {
        facts.product(xml)?;
        facts.global(xml)?;
        facts.scene(xml, &area)?;
        facts.data(xml)?;
        facts.sequences(xml, &area)?;
        facts.channels(xml, &area)?;
        facts.reference_geometry(xml, &area)?;
        facts.dwell(xml)?;
        facts.support(xml)?;
        parameters(xml, "PPP", &PPP)?;
        parameters(xml, "PVP", &PVP)?;
        facts.antennas(xml)?;
        facts.errors(xml)
    })?;
    Ok(xml.into_bytes())
}

fn parameters(xml: &mut Xml, block: &str, fields: &[Field]) -> io::Result<()> {
    xml.within(block, |xml| {
        let mut offset = 0;
        for (name, format, words) in fields {
            let added = format!("Added{block}");
            let is_added = ADDED.contains(name);
            xml.within(if is_added { &added } else { name }, |xml| {
                if is_added {
                    xml.text("Name", name)?;
                }
                xml.text("Offset", offset)?;
                xml.text("Size", words)?;
                xml.text("Format", format)
            })?;
            offset += words;
        }
        Ok(())
    })
}

fn state(record: &Known, end: &str) -> State {
    let of = |name: &str| record.vector(&format!("{end}{name}"));
    State { position_m: of("Pos"), velocity_mps: of("Vel"), acx: of("ACX"), acy: of("ACY") }
}

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

fn reference_point(xml: &mut Xml, name: &str, area: &Area) -> io::Result<()> {
    xml.within(name, |xml| {
        xml.vector("ECF", area.middle)?;
        xml.point("IAC", &[], [0.0; 2])
    })
}

fn image_area(xml: &mut Xml, area: &Area) -> io::Result<()> {
    let corners = area.corners();
    xml.within("ImageArea", |xml| {
        xml.point("X1Y1", &[], corners[0])?;
        xml.point("X2Y2", &[], corners[2])?;
        xml.with("Polygon", &[("size", "4")], |xml| {
            (1..).zip(corners).try_for_each(|(i, corner): (usize, _)| {
                xml.point("Vertex", &[("index", &i.to_string())], corner)
            })
        })
    })
}

impl Facts {
    fn reference(&self) -> (&Channel, &Sequence, &Known<'static>, &Known<'static>) {
        let channel = &self.description.channels[0];
        let sequence = &self.description.sequences[channel.sequence];
        (channel, sequence, &self.pulses[channel.sequence][1], &self.vectors[0][1])
    }

    /// Where the scene lies: on the patch, or about where the reference channel looks at the reference pulse.
    fn area(&self) -> Area {
        let description = &self.description;
        let frame = &description.frame;
        let looked_at = || {
            let (channel, sequence, pulse, vector) = self.reference();
            let boresight = |end: usize, seen: State| {
                let is_aimed = !description.ends[end].is_isotropic;
                is_aimed.then(|| self.on_sea(seen.position_m, seen.acx.cross(seen.acy))).flatten()
            };
            boresight(channel.end, state(vector, "Rcv"))
                .or_else(|| boresight(sequence.end, state(pulse, "Tx")))
                .unwrap_or_else(|| [description.nominal_point_m().x, description.nominal_point_m().y])
        };
        let [x, y] = match &description.patch {
            Some((Some(middle), _)) => *middle,
            _ => looked_at(),
        };
        let half = match &description.patch {
            Some((_, sides)) => sides.map(|side| 0.5 * side),
            None => {
                let far = |axis: usize, middle: f64| {
                    let of = description.targets_m.iter().map(|target| (target[axis] - middle).abs() + 50.0);
                    of.fold(HALF_SIDE_M, f64::max)
                };
                [far(0, x), far(1, y)]
            }
        };
        let axis = |v: Vector<Enu>| frame.vector_to_ecef(v).map_or(DVec3::ZERO, Vector::raw);
        let middle = frame.to_ecef(frame.above_sea(x, y, 0.0)).map_or(DVec3::ZERO, Point::raw);
        Area { middle, axes: [axis(Vector::new(1.0, 0.0, 0.0)), axis(Vector::new(0.0, 1.0, 0.0))], half }
    }

    /// Where a ray meets the mean sea, East and North, m.
    fn on_sea(&self, from: DVec3, ahead: DVec3) -> Option<[f64; 2]> {
        let frame = &self.description.frame;
        let from = frame.from_ecef(Point::<Ecef>::from_raw(from))?.raw();
        let ahead = frame.vector_from_ecef(Vector::<Ecef>::from_raw(ahead))?.raw();
        let mut place = from;
        // The sea falls off slowly: a few turns from the plane on.
        for _ in 0..8 {
            let sea_m = frame.above_sea(place.x, place.y, 0.0).raw().z;
            let far_m = (sea_m - from.z) / ahead.z;
            if !(far_m > 0.0 && far_m < 1e8) {
                return None;
            }
            place = from + ahead * far_m;
        }
        Some([place.x, place.y])
    }

    fn product(&self, xml: &mut Xml) -> io::Result<()> {
        let description = &self.description;
        let header = &description.header;
        let name = format!("nereus {} seed {}", header.start, header.seed);
        xml.within("ProductInfo", |xml| {
            xml.text("ProductName", &name)?;
            xml.text("Classification", CLASSIFICATION)?;
            xml.text("ReleaseInfo", RELEASE)?;
            xml.text_with("Parameter", &[("name", "software")], &header.software)?;
            xml.text_with("Parameter", &[("name", "seed")], header.seed)?;
            xml.text_with("Parameter", &[("name", "origin_lat_lon_h")], self.origin())
        })?;
        let kind = if description.is_monostatic() { "MONOSTATIC" } else { "BISTATIC" };
        xml.within("SARInfo", |xml| {
            xml.text("CollectType", kind)?;
            xml.within("RadarMode", |xml| xml.text("ModeType", description.mode))
        })?;
        let (channel, sequence, ..) = self.reference();
        for (info, end) in [("TransmitInfo", sequence.end), ("ReceiveInfo", channel.end)] {
            xml.within(info, |xml| {
                xml.text("SensorName", &description.ends[end].platform)?;
                xml.text("EventName", &name)?;
                xml.text_with("Parameter", &[("name", "positions")], "as reported by the platform")
            })?;
        }
        Ok(())
    }

    fn origin(&self) -> String {
        let origin = self.description.header.origin;
        origin.map_or(String::new(), |o| format!("{:?} {:?} {:?}", o.lat_deg, o.lon_deg, o.h_m))
    }

    /// First and last time of arrays of records, s after the reference time.
    fn span(records: &[[Known<'static>; 3]], name: &str) -> [f64; 2] {
        let of = |record: &Known| record.time_s(name);
        let first = records.iter().map(|[first, ..]| of(first)).fold(f64::INFINITY, f64::min);
        [first, records.iter().map(|[.., last]| of(last)).fold(f64::NEG_INFINITY, f64::max)]
    }

    fn received_band(&self) -> [f64; 2] {
        let half = 0.5 * FLAT * self.description.header.sample_rate_hz;
        [self.description.header.carrier_hz - half, self.description.header.carrier_hz + half]
    }

    fn global(&self, xml: &mut Xml) -> io::Result<()> {
        let header = &self.description.header;
        let [tx, rcv] = [Self::span(&self.pulses, "TxTime"), Self::span(&self.vectors, "RcvStart")];
        let band = self.received_band();
        xml.within("Global", |xml| {
            xml.text("CollectionRefTime", TimeTag::new(header.start.seconds(), 0.0))?;
            xml.within("Transmit", |xml| {
                xml.real("TxTime1", tx[0])?;
                xml.real("TxTime2", tx[1])?;
                xml.real("FxMin", header.carrier_hz - 0.5 * header.bandwidth_hz)?;
                xml.real("FxMax", header.carrier_hz + 0.5 * header.bandwidth_hz)
            })?;
            xml.within("Receive", |xml| {
                xml.real("RcvStartTime1", rcv[0])?;
                xml.real("RcvStartTime2", rcv[1])?;
                xml.real("FrcvMin", band[0])?;
                xml.real("FrcvMax", band[1])
            })
        })
    }

    fn scene(&self, xml: &mut Xml, area: &Area) -> io::Result<()> {
        let place = Point::<Ecef>::from_raw(area.middle).to_geodetic();
        xml.within("SceneCoordinates", |xml| {
            xml.text("EarthModel", "WGS_84")?;
            xml.within("IARP", |xml| {
                xml.vector("ECF", area.middle)?;
                xml.within("LLH", |xml| {
                    xml.real("Lat", place.lat_rad.to_degrees())?;
                    xml.real("Lon", place.lon_rad.to_degrees())?;
                    xml.real("HAE", place.h_m)
                })
            })?;
            xml.within("ReferenceSurface", |xml| {
                xml.within("Planar", |xml| {
                    xml.vector("uIAX", area.axes[0])?;
                    xml.vector("uIAY", area.axes[1])
                })
            })?;
            image_area(xml, area)?;
            xml.within("ImageAreaCornerPoints", |xml| {
                (1..).zip(area.corners()).try_for_each(|(i, [x, y]): (usize, _)| {
                    let corner = Point::<Ecef>::from_raw(area.middle + x * area.axes[0] + y * area.axes[1]);
                    let corner = corner.to_geodetic();
                    xml.with("IACP", &[("index", &i.to_string())], |xml| {
                        xml.real("Lat", corner.lat_rad.to_degrees())?;
                        xml.real("Lon", corner.lon_rad.to_degrees())
                    })
                })
            })
        })
    }

    /// Arrays of the support block: name, rows, columns.
    fn support_arrays(&self) -> Vec<(&str, [usize; 2])> {
        let of = |end: &'_ End| end.array.size;
        let ends = self.description.ends.iter().map(|end| (end.name.as_str(), of(end)));
        let replica = [1, self.description.header.replica.len()];
        let shared = [(ELEMENT, [3, 3]), (RESPONSE_NAME, [1, RESPONSE_COLUMNS]), (REPLICA, replica)];
        ends.chain(shared).collect()
    }

    fn data(&self, xml: &mut Xml) -> io::Result<()> {
        let description = &self.description;
        let vector = (description.header.layout.samples * description.signal.bytes()) as u64;
        xml.within("Data", |xml| {
            xml.within("Support", |xml| {
                let arrays = self.support_arrays();
                xml.text("NumSupportArrays", arrays.len())?;
                let mut at = 0;
                arrays.iter().try_for_each(|(name, [rows, columns])| {
                    xml.within("SupportArray", |xml| {
                        xml.text("SAId", support_id(name))?;
                        xml.text("NumRows", rows)?;
                        xml.text("NumCols", columns)?;
                        xml.text("BytesPerElement", 8)?;
                        xml.text("ArrayByteOffset", at)?;
                        at += 8 * rows * columns;
                        Ok(())
                    })
                })
            })?;
            xml.within("Transmit", |xml| {
                xml.text("NumBytesPPP", bytes(&PPP))?;
                xml.text("NumTxSequences", self.counts.len())?;
                let mut at = 0;
                description.sequences.iter().zip(&self.counts).try_for_each(|(sequence, count)| {
                    xml.within("TxSequence", |xml| {
                        xml.text("TxId", &sequence.id)?;
                        xml.text("NumPulses", count)?;
                        xml.text("PPPArrayByteOffset", at)?;
                        at += count * bytes(&PPP) as u64;
                        Ok(())
                    })
                })
            })?;
            xml.within("Receive", |xml| {
                xml.text("SignalArrayFormat", description.signal.name())?;
                xml.text("NumBytesPVP", bytes(&PVP))?;
                xml.text("NumCRSDChannels", description.channels.len())?;
                let mut before = 0;
                description.channels.iter().try_for_each(|channel| {
                    let count = self.counts[channel.sequence];
                    xml.within("Channel", |xml| {
                        xml.text("ChId", &channel.id)?;
                        xml.text("NumVectors", count)?;
                        xml.text("NumSamples", description.header.layout.samples)?;
                        xml.text("SignalArrayByteOffset", before * vector)?;
                        xml.text("PVPArrayByteOffset", before * bytes(&PVP) as u64)?;
                        before += count;
                        Ok(())
                    })
                })
            })
        })
    }

    fn sequences(&self, xml: &mut Xml, area: &Area) -> io::Result<()> {
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
                    let at = at_point(&seen, port(sequence.polarisation), area.middle, 1.0);
                    polarisation(xml, "TxPolarization", sequence.polarisation, &at)?;
                    xml.real("TxRefRadIntensity", sequence.intensity_dbw)?;
                    xml.real("TxRadIntErrorStdDev", 0.0)?;
                    xml.real("TxRefLAtm", self.air_db(&seen, area))
                })
            })
        })
    }

    fn air_db(&self, seen: &State, area: &Area) -> f64 {
        self.description.air_db_per_m * seen.position_m.distance(area.middle)
    }

    fn channels(&self, xml: &mut Xml, area: &Area) -> io::Result<()> {
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
            let at = at_point(&seen, port(channel.polarisation), area.middle, -1.0);
            polarisation(xml, "RcvPolarization", channel.polarisation, &at)?;
            xml.real("RcvRefIrradiance", channel.irradiance_dbw)?;
            xml.real("RcvIrradianceErrorStdDev", 0.0)?;
            xml.real("RcvRefLAtm", self.air_db(&seen, area))?;
            xml.real("PNCRSD", description.noise_w)?;
            xml.real("BNCRSD", NOISE)?;
            xml.within("SARImage", |xml| {
                xml.text("TxId", &sequence.id)?;
                xml.text("RefVectorPulseIndex", middle)?;
                let sent = state(&self.pulses[channel.sequence][1], "Tx");
                let at = at_point(&sent, port(sequence.polarisation), area.middle, 1.0);
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

    fn reference_geometry(&self, xml: &mut Xml, area: &Area) -> io::Result<()> {
        let (_, _, pulse, vector) = self.reference();
        let (sent, received) = (state(pulse, "Tx"), state(vector, "Rcv"));
        let axes = local(area.middle);
        let transmitter = OneWay::of(sent.position_m, sent.velocity_mps, area.middle, axes);
        let receiver = OneWay::of(received.position_m, received.velocity_mps, area.middle, axes);
        let both = Bistatic::of(&transmitter, &receiver, area.middle, axes);
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

    fn dwell(&self, xml: &mut Xml) -> io::Result<()> {
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

    fn support(&self, xml: &mut Xml) -> io::Result<()> {
        let header = &self.description.header;
        let flat = super::pattern::GainArray::flat();
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

    fn antennas(&self, xml: &mut Xml) -> io::Result<()> {
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

    fn errors(&self, xml: &mut Xml) -> io::Result<()> {
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

/// Names of support arrays; no antenna has that of one that all share, which begins with a colon.
fn support_id(name: &str) -> String {
    name.strip_prefix(':').map_or_else(|| format!("gain-{name}"), str::to_owned)
}

fn pattern_id(antenna: &str, polarisation: Polarisation) -> String {
    format!("{antenna}-{}", polarisation.letter())
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
