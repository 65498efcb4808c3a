//! Columns of a pattern file of our own, and what they may hold.

use std::fmt;

/// Points of a grid, at most.
pub(super) const MOST_POINTS: usize = 4_000_000;
const GAIN_DBI: std::ops::RangeInclusive<f64> = -300.0..=100.0;
const RCS_DBSM: std::ops::RangeInclusive<f64> = -300.0..=120.0;

/// What the file gives of every direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Gain of an antenna, dBi, and phase where there is a column for it.
    Gain,
    /// Radar cross section, dBsm.
    CrossSection,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gain => "pattern file",
            Self::CrossSection => "file of cross sections",
        })
    }
}

impl Quantity {
    /// Columns of the longest header, and how many of them may be left out.
    pub(super) fn columns(self) -> (&'static [Column], usize) {
        match self {
            Self::Gain => (&[Column::Azimuth, Column::Elevation, Column::Gain, Column::Phase], 1),
            Self::CrossSection => (&[Column::Azimuth, Column::Elevation, Column::CrossSection], 0),
        }
    }

    pub(super) fn headers(self) -> &'static str {
        match self {
            Self::Gain => "az_deg,el_deg,gain_dbi or az_deg,el_deg,gain_dbi,phase_deg",
            Self::CrossSection => "az_deg,el_deg,rcs_dbsm",
        }
    }
}

/// A column of a pattern file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// `az_deg`
    Azimuth,
    /// `el_deg`
    Elevation,
    /// `gain_dbi`
    Gain,
    /// `phase_deg`
    Phase,
    /// `rcs_dbsm`
    CrossSection,
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Azimuth => "az_deg",
            Self::Elevation => "el_deg",
            Self::Gain => "gain_dbi",
            Self::Phase => "phase_deg",
            Self::CrossSection => "rcs_dbsm",
        })
    }
}

impl Column {
    pub(super) fn read(self, text: &str) -> Result<f64, &'static str> {
        let (range, allowed) = match self {
            Self::Azimuth => (-360.0..=360.0, "degrees from -360 to 360"),
            Self::Elevation => (-90.0..=90.0, "degrees from -90 to 90"),
            Self::Gain => (GAIN_DBI, "dBi from -300 to 100"),
            Self::Phase => (-1e6..=1e6, "degrees"),
            Self::CrossSection => (RCS_DBSM, "dBsm from -300 to 120"),
        };
        text.parse().ok().filter(|value| range.contains(value)).ok_or(allowed)
    }
}
