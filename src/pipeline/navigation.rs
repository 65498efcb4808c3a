//! The words of navigation outputs.

use crate::frames::{Earth, Geodetic, Point, Rotation, SceneFrame, Vector};
use crate::nav::encode::{Format, Sentence};
use crate::nav::solution::Solution;
use crate::pulse::{PlatformRecord, Pulse};
use crate::recording::header::Header;
use crate::sinks::nav::{Encoder, Messages, NavSettings};
use crate::time::TimeTag;

/// Says where a platform of the scene reports to be.
struct Reports {
    platform: usize,
    frame: SceneFrame,
    format: Format,
}

/// What speaks these words in the scene of a run; `None` if that lies nowhere on Earth.
pub(super) fn encoder(settings: &NavSettings, header: &Header) -> Option<Box<dyn Encoder>> {
    let origin = header.origin?;
    let frame = SceneFrame::at(Geodetic::from_deg(origin.lat_deg, origin.lon_deg, origin.h_m), Earth::Flat);
    let format = match &settings.messages {
        Messages::Nmea(names) => {
            Format::Nmea(names.iter().filter_map(|name| Sentence::named(name)).collect())
        }
        Messages::InspvaxAscii => Format::InspvaxAscii,
        Messages::InspvaxBinary => Format::InspvaxBinary,
    };
    Some(Box::new(Reports { platform: settings.platform, frame, format }))
}

impl Encoder for Reports {
    fn encode(&mut self, pulse: &Pulse, out: &mut Vec<u8>) -> u64 {
        let record = pulse.nav_reported.get(self.platform);
        u64::from(!record.is_some_and(|record| self.write(pulse.time, record, out)))
    }
}

impl Reports {
    /// Appends the messages of a state; false if it has none.
    fn write(&self, time: TimeTag, record: &PlatformRecord, out: &mut Vec<u8>) -> bool {
        let [x, y, z] = record.position_m;
        let [e, n, u] = record.velocity_mps;
        let [qw, qx, qy, qz] = record.attitude_quat;
        let attitude = Rotation::from_raw(glam::DQuat::from_xyzw(qx, qy, qz, qw));
        let (position, velocity) = (Point::new(x, y, z), Vector::new(e, n, u));
        Solution::of_scene(&self.frame, time, position, velocity, attitude)
            .is_some_and(|said| self.format.write(&said, out).is_ok())
    }
}
