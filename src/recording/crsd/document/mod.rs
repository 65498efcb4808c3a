//! The header and the XML of a CRSD file.
//!
//! Elements stand in the order of the standard's schema. The reference pulse and vector of a sequence or
//! channel are in its middle, the reference channel is the first one.

mod antennas;
mod channels;

use std::io;
use std::sync::Arc;

use glam::DVec3;

use super::description::{Channel, Description, End, FLAT, NOISE, Sequence};
use super::records::{ADDED, Field, Known, PPP, PVP, bytes};
use super::reference::{Geometry, OneWay, TwoAxes, at_point, port, steady};
use super::states::State;
use super::xml::Xml;
use crate::frames::{Ecef, Enu, Point, Vector};
use crate::scene::radar::Polarisation;
use crate::time::TimeTag;

/// Where the XML begins: behind a header that is always shorter.
pub(super) const XML_AT: u64 = 2048;
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

/// Where the blocks of a complete file are, and how long they are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Blocks {
    pub support: (u64, u64),
    pub ppp: (u64, u64),
    pub pvp: (u64, u64),
    pub signal: (u64, u64),
}

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
    /// The reference point: the middle, or millimetres East of it (see [`steady`]).
    point: DVec3,
    /// How far East of the middle it is, m.
    aside_m: f64,
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

fn reference_point(xml: &mut Xml, name: &str, area: &Area) -> io::Result<()> {
    xml.within(name, |xml| {
        xml.vector("ECF", area.point)?;
        xml.point("IAC", &[], [area.aside_m, 0.0])
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
        let axes = [axis(Vector::new(1.0, 0.0, 0.0)), axis(Vector::new(0.0, 1.0, 0.0))];
        let (_, _, pulse, vector) = self.reference();
        let (aside_m, point) = steady([state(pulse, "Tx"), state(vector, "Rcv")], middle, axes[0]);
        Area { middle, point, aside_m, axes, half }
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
}

/// Names of support arrays; no antenna has that of one that all share, which begins with a colon.
fn support_id(name: &str) -> String {
    name.strip_prefix(':').map_or_else(|| format!("gain-{name}"), str::to_owned)
}

fn pattern_id(antenna: &str, polarisation: Polarisation) -> String {
    format!("{antenna}-{}", polarisation.letter())
}
