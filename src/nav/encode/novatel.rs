//! INSPVAX.

use std::io::Write;

use super::super::decode::novatel::{HEADER_BYTES, INSPVAX_BYTES, INSPVAX_ID, SOLUTION_GOOD, crc32};
use super::super::solution::Solution;
use super::{EncodeError, lon_deg, tidy, turn_deg};
use crate::time::TimeTag;

/// Type of the position: inertial with a pseudorange solution.
const INS_PSRSP: u32 = 53;
/// Status of the time: `FINESTEERING`.
const FINE_STEERING: u8 = 180;
/// The resolution of angles in ASCII, degrees.
const UNIT_DEG: f64 = 1e-9;
/// Metres of a radian on Earth, about: enough for half a millisecond of flight.
const EARTH_A_M: f64 = 6_378_137.0;
const EARTH_E2: f64 = 6.694_379_990_141_316e-3;

/// The figures of a message.
pub(super) struct Values {
    week: u32,
    ms: u32,
    lat_deg: f64,
    lon_deg: f64,
    height_m: f64,
    undulation_m: f64,
    /// North, East, up.
    velocity_mps: [f64; 3],
    /// Roll, pitch, azimuth.
    angles_deg: [f64; 3],
    /// Latitude, longitude, height; velocities; roll, pitch, azimuth.
    sigma: [[f32; 3]; 3],
}

impl Values {
    /// The values of a state.
    ///
    /// # Errors
    /// A state without velocity or attitude, or outside what the message can hold.
    pub fn of(solution: &Solution) -> Result<Self, EncodeError> {
        let (Some([east, north, up]), Some(angles)) = (solution.velocity_mps, solution.yaw_pitch_roll_rad)
        else {
            return Err(EncodeError::Incomplete);
        };
        // Rounded to the nearer millisecond, over the end of a second and of a week.
        let (seconds, fraction_s) = (solution.time.seconds(), solution.time.fraction_s());
        let label_s = (fraction_s * 1e3).round() / 1e3;
        let (week, seconds_of_week) = TimeTag::new(seconds, label_s).to_gps().ok_or(EncodeError::Range)?;
        let step_s = label_s - fraction_s;
        let place = solution.place;
        let (sin, cos) = place.lat_rad.sin_cos();
        let prime_m = EARTH_A_M / (1.0 - EARTH_E2 * sin * sin).sqrt();
        let meridian_m = prime_m * (1.0 - EARTH_E2) / (1.0 - EARTH_E2 * sin * sin);
        let lat_rad = place.lat_rad + north * step_s / (meridian_m + place.h_m);
        let lon_rad = place.lon_rad + east * step_s / ((prime_m + place.h_m) * cos.max(1e-9));
        let height_m = place.h_m + up * step_s;
        // What f32 and four decimals both hold to less than the height's last digit.
        let undulation_m = f64::from(((solution.undulation_m * 1e3).round() / 1e3) as f32);
        let [yaw, pitch, roll] = tidy(angles);
        let [east_m, north_m, up_m] = solution.sigma.position_m.unwrap_or_default();
        let [east_mps, north_mps, up_mps] = solution.sigma.velocity_mps.unwrap_or_default();
        let [yaw_rad, pitch_rad, roll_rad] = solution.sigma.angles_rad.unwrap_or_default();
        Ok(Self {
            week,
            ms: (seconds_of_week * 1e3).round() as u32,
            lat_deg: lat_rad.to_degrees().clamp(-90.0, 90.0),
            lon_deg: lon_deg(lon_rad),
            height_m: height_m - undulation_m,
            undulation_m,
            velocity_mps: [north, east, up],
            angles_deg: [roll.to_degrees(), pitch.to_degrees(), turn_deg(yaw, UNIT_DEG)],
            sigma: [
                [north_m, east_m, up_m],
                [north_mps, east_mps, up_mps],
                [roll_rad, pitch_rad, yaw_rad].map(f32::to_degrees),
            ],
        })
    }

    pub fn ascii(&self, out: &mut Vec<u8>) {
        let start = out.len();
        // Writing to memory does not fail.
        let _ = self.text(out);
        let crc = crc32(&out[start + 1..]);
        let _ = write!(out, "*{crc:08x}\r\n");
    }

    fn text(&self, out: &mut Vec<u8>) -> std::io::Result<()> {
        let (week, seconds, ms) = (self.week, self.ms / 1000, self.ms % 1000);
        // What is written of the undulation decides the height.
        let undulation_m = (self.undulation_m * 1e4).round() / 1e4;
        let height_m = self.height_m + self.undulation_m - undulation_m;
        write!(out, "#INSPVAXA,COM1,0,0.0,FINESTEERING,{week},{seconds}.{ms:03},00000000,0000,0;")?;
        write!(out, "INS_SOLUTION_GOOD,INS_PSRSP,{:.11},{:.11},", self.lat_deg, self.lon_deg)?;
        write!(out, "{height_m:.5},{undulation_m:.4}")?;
        for velocity in self.velocity_mps {
            write!(out, ",{velocity:.6}")?;
        }
        for angle in self.angles_deg {
            write!(out, ",{angle:.9}")?;
        }
        for sigma in self.sigma.iter().flatten() {
            write!(out, ",{sigma:.6}")?;
        }
        write!(out, ",00000000,0")
    }

    pub fn binary(&self, out: &mut Vec<u8>) {
        let start = out.len();
        out.extend([0xAA, 0x44, 0x12, HEADER_BYTES as u8]);
        out.extend(INSPVAX_ID.to_le_bytes());
        // Type binary; port COM1.
        out.extend([0, 32]);
        out.extend((INSPVAX_BYTES as u16).to_le_bytes());
        // Sequence, idle time.
        out.extend([0, 0, 0, FINE_STEERING]);
        out.extend((self.week as u16).to_le_bytes());
        out.extend(self.ms.to_le_bytes());
        // Status of the receiver, reserved, version.
        out.extend([0; 8]);
        out.extend(SOLUTION_GOOD.to_le_bytes());
        out.extend(INS_PSRSP.to_le_bytes());
        for figure in [self.lat_deg, self.lon_deg, self.height_m] {
            out.extend(figure.to_le_bytes());
        }
        out.extend((self.undulation_m as f32).to_le_bytes());
        for figure in self.velocity_mps.iter().chain(&self.angles_deg) {
            out.extend(figure.to_le_bytes());
        }
        for sigma in self.sigma.iter().flatten() {
            out.extend(sigma.to_le_bytes());
        }
        // Extended status, time since the last update.
        out.extend([0; 6]);
        let crc = crc32(&out[start..]);
        out.extend(crc.to_le_bytes());
    }
}
