//! The spectral state of a surface as a file, for reuse.
//!
//! Little-endian: the 8 bytes `NEREUSEA`; u32 version (1); u32 flags (bit 0: surface tension; bit 1: finite
//! depth); u64 nx, u64 ny; f64 facet side, m; f64 depth, m (0 when deep); u64 seed; f64 expected variance,
//! m^2; f64 expected slope variances along x and y; nx ny amplitudes a(K), f64 re and im, m, kx by kx, in
//! the order of [`Grid::wave_index_x`] and [`Grid::wave_index_y`]; u64 FNV-1a hash of all bytes before.
//!
//! ```
//! use nereus::scene::water::{Dispersion, WindProfile};
//! use nereus::sea::spectrum::FungLee;
//! use nereus::sea::surface::{Averaging, Grid, Surface};
//! use nereus::sea::wind::Wind;
//! let spectrum = FungLee::new(&Wind::from_speed(5.0, 10.0, WindProfile::Wu, 0.0)?);
//! let grid = Grid::new(16, 8, 2.0)?;
//! let surface = Surface::synthesise(grid, &spectrum, Dispersion::default(), 3, Averaging::Automatic)?;
//! let mut file = Vec::new();
//! surface.save(&mut file)?;
//! assert_eq!(Surface::load(&mut file.as_slice())?, surface);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::io::{self, Read, Write};

use num_complex::Complex64;

use super::{Expected, Grid, Surface, SurfaceError};
use crate::scene::water::Dispersion;

const MAGIC: [u8; 8] = *b"NEREUSEA";
const VERSION: u32 = 1;
const HEADER_BYTES: usize = 80;
const TENSION: u32 = 1;
const FINITE_DEPTH: u32 = 2;
/// Largest amplitude of a wave, m: far beyond any sea, and far from overflow.
const MAX_AMPLITUDE_M: f64 = 1e6;

/// Why a state cannot be saved or loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// Reading or writing failed.
    #[error("sea state: {0}")]
    Io(#[source] io::Error),
    /// Less than the header states.
    #[error("sea state: the file ends too early")]
    Truncated,
    /// Another kind of file.
    #[error("sea state: the file does not begin with NEREUSEA")]
    Magic,
    /// Another version.
    #[error("sea state: version {found}, readable is {VERSION}")]
    Version {
        /// The version found.
        found: u32,
    },
    /// Unknown flags.
    #[error("sea state: unknown flags {found:#x}")]
    Flags {
        /// The flags found.
        found: u32,
    },
    /// A header that describes no surface.
    #[error("sea state: {0}")]
    Surface(#[from] SurfaceError),
    /// A number that cannot be.
    #[error("sea state: {what} is {value}, which no sea has")]
    Value {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The bytes are not those that were written.
    #[error("sea state: the check sum does not match")]
    Checksum,
    /// More bytes than the header states.
    #[error("sea state: bytes follow after the end")]
    Trailing,
}

impl From<io::Error> for StateError {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof { Self::Truncated } else { Self::Io(error) }
    }
}

/// FNV-1a, 64 bit.
struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

impl Surface {
    /// Writes the state.
    ///
    /// # Errors
    /// What the writer fails with.
    pub fn save(&self, out: &mut impl Write) -> Result<(), StateError> {
        let mut flags = 0;
        if self.dispersion.capillary {
            flags |= TENSION;
        }
        if self.dispersion.depth_m.is_some() {
            flags |= FINITE_DEPTH;
        }
        let mut bytes = Vec::with_capacity(HEADER_BYTES);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(flags.to_le_bytes());
        bytes.extend((self.grid.nx() as u64).to_le_bytes());
        bytes.extend((self.grid.ny() as u64).to_le_bytes());
        bytes.extend(self.grid.facet_m().to_le_bytes());
        bytes.extend(self.dispersion.depth_m.unwrap_or(0.0).to_le_bytes());
        bytes.extend(self.seed.to_le_bytes());
        bytes.extend(self.expected.variance_m2.to_le_bytes());
        bytes.extend(self.expected.slope_variance[0].to_le_bytes());
        bytes.extend(self.expected.slope_variance[1].to_le_bytes());
        let mut hash = Fnv::new();
        hash.add(&bytes);
        out.write_all(&bytes)?;
        for row in self.amplitude_m.chunks_exact(self.grid.ny()) {
            bytes.clear();
            for a in row {
                bytes.extend(a.re.to_le_bytes());
                bytes.extend(a.im.to_le_bytes());
            }
            hash.add(&bytes);
            out.write_all(&bytes)?;
        }
        out.write_all(&hash.0.to_le_bytes())?;
        Ok(out.flush()?)
    }

    /// Reads a state back.
    ///
    /// # Errors
    /// What the reader fails with, bytes that are no state, or a state that is damaged.
    pub fn load(input: &mut impl Read) -> Result<Self, StateError> {
        let mut header = [0; HEADER_BYTES];
        input.read_exact(&mut header)?;
        let mut hash = Fnv::new();
        hash.add(&header);
        if header[..8] != MAGIC {
            return Err(StateError::Magic);
        }
        let word = |at: usize| u64::from_le_bytes(eight(&header[at..]));
        let real = |at: usize| f64::from_bits(word(at));
        let (version, flags) = (word(8) as u32, (word(8) >> 32) as u32);
        if version != VERSION {
            return Err(StateError::Version { found: version });
        }
        if flags & !(TENSION | FINITE_DEPTH) != 0 {
            return Err(StateError::Flags { found: flags });
        }
        // A count that does not fit is over the limit in any case.
        let count = |at| usize::try_from(word(at)).unwrap_or(usize::MAX);
        let grid = Grid::new(count(16), count(24), real(32))?;
        let dispersion = Dispersion {
            capillary: flags & TENSION != 0,
            depth_m: (flags & FINITE_DEPTH != 0).then(|| real(40)),
        };
        dispersion.check().map_err(SurfaceError::from)?;
        if dispersion.depth_m.is_none() && word(40) != 0 {
            return Err(StateError::Value { what: "the depth of deep water", value: real(40) });
        }
        let expected = Expected { variance_m2: real(56), slope_variance: [real(64), real(72)] };
        let [sx, sy] = expected.slope_variance;
        for (what, value) in
            [("the variance", expected.variance_m2), ("a slope variance", sx), ("a slope variance", sy)]
        {
            if !value.is_finite() || value < 0.0 {
                return Err(StateError::Value { what, value });
            }
        }
        // Memory grows with what is really there, whatever the header states.
        let mut amplitude_m = Vec::new();
        let mut bytes = vec![0; 16 * grid.ny()];
        for i in 0..grid.nx() {
            input.read_exact(&mut bytes)?;
            hash.add(&bytes);
            for (j, pair) in bytes.chunks_exact(16).enumerate() {
                let part = |at: usize| f64::from_le_bytes(eight(&pair[at..]));
                let a = Complex64::new(part(0), part(8));
                for value in [a.re, a.im] {
                    if !value.is_finite() || value.abs() > MAX_AMPLITUDE_M {
                        return Err(StateError::Value { what: "an amplitude", value });
                    }
                }
                let wave = grid.wave_index_x(i).zip(grid.wave_index_y(j)).filter(|m| *m != (0, 0));
                if wave.is_none() && a != Complex64::ZERO {
                    return Err(StateError::Value { what: "the amplitude of no wave", value: a.norm() });
                }
                amplitude_m.push(a);
            }
        }
        let mut sum = [0; 8];
        input.read_exact(&mut sum)?;
        if u64::from_le_bytes(sum) != hash.0 {
            return Err(StateError::Checksum);
        }
        if input.read(&mut [0])? != 0 {
            return Err(StateError::Trailing);
        }
        Ok(Self { grid, dispersion, seed: word(48), expected, amplitude_m })
    }
}

/// The first eight bytes of a slice that has them.
fn eight(bytes: &[u8]) -> [u8; 8] {
    let mut out = [0; 8];
    out.copy_from_slice(&bytes[..8]);
    out
}
