//! Points, vectors and rotations that know their frame, and every change of frame.
//!
//! * **ECEF**: WGS-84 Earth-centred, Earth-fixed.
//! * **ENU**: the scene frame. East, North, up at the scene's origin on the mean sea surface; a rigid
//!   (not curved) frame: `ENU = R (X - X0)`.
//! * **Body**: forward, starboard, down (FRD).
//! * **Antenna**: boresight `+x`, horizontal aperture axis `+y`, vertical aperture axis `+z`.
//!
//! Frames are part of the type, so a mix does not compile:
//!
//! ```compile_fail
//! use nereus::frames::{Body, Enu, Vector};
//! let v: Vector<Enu> = Vector::new(1.0, 0.0, 0.0);
//! let w: Vector<Body> = Vector::new(1.0, 0.0, 0.0);
//! let _ = v + w;
//! ```
//!
//! WGS-84 to ECEF is the closed form; the way back is Bowring's iteration, since closed forms are wrong by
//! millimetres at satellite heights.

use std::marker::PhantomData;
use std::ops::{Add, Mul, Neg, Sub};

use glam::{DMat3, DQuat, DVec3};

use crate::units::EARTH_RADIUS_M;

/// Tag: Earth-centred, Earth-fixed, WGS-84.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ecef;
/// Tag: the scene's local East, North, up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enu;
/// Tag: platform body, forward, starboard, down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body;
/// Tag: antenna, boresight +x, horizontal aperture axis +y, vertical +z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Antenna;

/// A position in frame `F`, metres.
#[derive(Debug, PartialEq)]
pub struct Point<F>(DVec3, PhantomData<F>);

/// A direction, displacement (m), velocity (m/s) or acceleration (m/s^2) in frame `F`.
#[derive(Debug, PartialEq)]
pub struct Vector<F>(DVec3, PhantomData<F>);

/// A rotation that takes vectors of frame `A` into frame `B` (Hamilton quaternion).
#[derive(Debug, PartialEq)]
pub struct Rotation<A, B>(DQuat, PhantomData<(A, B)>);

impl<F> Clone for Point<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F> Copy for Point<F> {}
impl<F> Clone for Vector<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F> Copy for Vector<F> {}
impl<A, B> Clone for Rotation<A, B> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<A, B> Copy for Rotation<A, B> {}

impl<F> Point<F> {
    /// The point at the given coordinates, metres.
    pub fn new(x_m: f64, y_m: f64, z_m: f64) -> Self {
        Self(DVec3::new(x_m, y_m, z_m), PhantomData)
    }
    /// Tags a bare vector.
    pub fn from_raw(raw: DVec3) -> Self {
        Self(raw, PhantomData)
    }
    /// The bare coordinates, for inner loops.
    pub fn raw(self) -> DVec3 {
        self.0
    }
    /// Coordinates as an array, metres.
    pub fn to_array(self) -> [f64; 3] {
        self.0.to_array()
    }
}

impl<F> Vector<F> {
    /// The null vector.
    pub const ZERO: Self = Self(DVec3::ZERO, PhantomData);
    /// The vector with the given components.
    pub fn new(x: f64, y: f64, z: f64) -> Self {
        Self(DVec3::new(x, y, z), PhantomData)
    }
    /// Tags a bare vector.
    pub fn from_raw(raw: DVec3) -> Self {
        Self(raw, PhantomData)
    }
    /// The bare components, for inner loops.
    pub fn raw(self) -> DVec3 {
        self.0
    }
    /// Components as an array.
    pub fn to_array(self) -> [f64; 3] {
        self.0.to_array()
    }
    /// Euclidean length.
    pub fn norm(self) -> f64 {
        self.0.length()
    }
    /// Scalar product.
    pub fn dot(self, other: Self) -> f64 {
        self.0.dot(other.0)
    }
    /// Vector product.
    pub fn cross(self, other: Self) -> Self {
        Self(self.0.cross(other.0), PhantomData)
    }
}

impl<F> Sub for Point<F> {
    type Output = Vector<F>;
    fn sub(self, other: Self) -> Vector<F> {
        Vector::from_raw(self.0 - other.0)
    }
}
impl<F> Add<Vector<F>> for Point<F> {
    type Output = Self;
    fn add(self, v: Vector<F>) -> Self {
        Self::from_raw(self.0 + v.0)
    }
}
impl<F> Add for Vector<F> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::from_raw(self.0 + other.0)
    }
}
impl<F> Sub for Vector<F> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::from_raw(self.0 - other.0)
    }
}
impl<F> Neg for Vector<F> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::from_raw(-self.0)
    }
}
impl<F> Mul<f64> for Vector<F> {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self::from_raw(self.0 * s)
    }
}

impl<A, B> Rotation<A, B> {
    /// Tags a bare unit quaternion.
    pub fn from_raw(raw: DQuat) -> Self {
        Self(raw, PhantomData)
    }
    /// The bare quaternion.
    pub fn raw(self) -> DQuat {
        self.0
    }
    /// The rotation whose columns are the `A` axes expressed in `B` (orthonormal, right-handed).
    pub fn from_axes(x: Vector<B>, y: Vector<B>, z: Vector<B>) -> Self {
        Self::from_raw(DQuat::from_mat3(&DMat3::from_cols(x.0, y.0, z.0)).normalize())
    }
    /// The opposite rotation, `B` to `A`.
    pub fn inverse(self) -> Rotation<B, A> {
        Rotation::from_raw(self.0.conjugate())
    }
    /// First `self` (`A` to `B`), then `next` (`B` to `C`).
    pub fn then<C>(self, next: Rotation<B, C>) -> Rotation<A, C> {
        Rotation::from_raw((next.0 * self.0).normalize())
    }
    /// Components `[w, x, y, z]`, scalar first.
    pub fn to_wxyz(self) -> [f64; 4] {
        [self.0.w, self.0.x, self.0.y, self.0.z]
    }
}

impl<A, B> Mul<Vector<A>> for Rotation<A, B> {
    type Output = Vector<B>;
    fn mul(self, v: Vector<A>) -> Vector<B> {
        Vector::from_raw(self.0 * v.0)
    }
}

impl Rotation<Body, Enu> {
    /// Attitude from yaw (clockwise from North), pitch (nose up) and roll (right wing down), radians:
    /// `C = Rz(yaw) Ry(pitch) Rx(roll)` body to NED, then NED to ENU.
    ///
    /// ```
    /// use nereus::frames::{Rotation, Vector};
    /// let east = Rotation::from_yaw_pitch_roll(90f64.to_radians(), 0.0, 0.0);
    /// let nose = east * Vector::new(1.0, 0.0, 0.0);
    /// assert!((nose.to_array()[0] - 1.0).abs() < 1e-12);
    /// ```
    pub fn from_yaw_pitch_roll(yaw_rad: f64, pitch_rad: f64, roll_rad: f64) -> Self {
        let to_ned = DQuat::from_rotation_z(yaw_rad)
            * DQuat::from_rotation_y(pitch_rad)
            * DQuat::from_rotation_x(roll_rad);
        // NED to ENU: half a turn about (1, 1, 0)/sqrt(2) swaps x and y and negates z.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let to_enu = DQuat::from_xyzw(half, half, 0.0, 0.0);
        Self::from_raw((to_enu * to_ned).normalize())
    }

    /// Yaw in [0, 2 pi), pitch and roll, radians (inverse of [`Self::from_yaw_pitch_roll`]).
    pub fn to_yaw_pitch_roll(self) -> [f64; 3] {
        let nose = self.0 * DVec3::X;
        let wing = self.0 * DVec3::Y;
        let belly = self.0 * DVec3::Z;
        let yaw = nose.x.atan2(nose.y).rem_euclid(std::f64::consts::TAU);
        let pitch = nose.z.clamp(-1.0, 1.0).asin();
        let roll = (-wing.z).atan2(-belly.z);
        [yaw, pitch, roll]
    }
}

/// A WGS-84 geodetic position: latitude and longitude in radians, ellipsoidal height in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    /// Latitude, radians.
    pub lat_rad: f64,
    /// Longitude, radians.
    pub lon_rad: f64,
    /// Height above the WGS-84 ellipsoid, metres.
    pub h_m: f64,
}

/// Semi-axes and flattening of WGS-84, m.
const A_M: f64 = 6_378_137.0;
const F: f64 = 1.0 / 298.257_223_563;
const B_M: f64 = A_M * (1.0 - F);

impl Geodetic {
    /// From degrees and metres.
    pub fn from_deg(lat_deg: f64, lon_deg: f64, h_m: f64) -> Self {
        Self { lat_rad: lat_deg.to_radians(), lon_rad: lon_deg.to_radians(), h_m }
    }

    /// Whether it lies over 1000 km from another place, and within 100 km of it once latitude and longitude
    /// are exchanged.
    pub fn looks_swapped(self, near: Self) -> bool {
        let distance_m = |a: Self| {
            let [place, other] = [a, near].map(|at| Self { h_m: 0.0, ..at }.to_ecef());
            (place - other).norm()
        };
        let other_way = Self { lat_rad: self.lon_rad, lon_rad: self.lat_rad, h_m: self.h_m };
        distance_m(self) > 1e6 && distance_m(other_way) < 1e5
    }

    /// Earth-centred, Earth-fixed position: `X = (N + h) cos(lat) cos(lon)`, `Y = (N + h) cos(lat) sin(lon)`,
    /// `Z = (N b^2/a^2 + h) sin(lat)`, `N = a / sqrt(1 - e^2 sin^2(lat))` the radius of curvature.
    pub fn to_ecef(self) -> Point<Ecef> {
        let Self { lat_rad, lon_rad, h_m } = self;
        let [cos, sin] = [lat_rad.cos(), lat_rad.sin()];
        let eccentricity_2 = (A_M * A_M - B_M * B_M) / (A_M * A_M);
        let n_m = A_M / (1.0 - eccentricity_2 * sin * sin).sqrt();
        let [x, y] = [(n_m + h_m) * cos * lon_rad.cos(), (n_m + h_m) * cos * lon_rad.sin()];
        Point::new(x, y, (n_m * (B_M / A_M) * (B_M / A_M) + h_m) * sin)
    }
}

impl Point<Ecef> {
    /// Geodetic latitude, longitude and ellipsoidal height (Bowring's iteration, to 1e-8 m up to
    /// geostationary heights).
    pub fn to_geodetic(self) -> Geodetic {
        const E2: f64 = F * (2.0 - F);
        let Self(DVec3 { x, y, z }, _) = self;
        let p = x.hypot(y);
        // Parametric latitude; each turn gains five digits and more, at any height.
        let mut beta = z.atan2((1.0 - F) * p);
        let mut lat_rad = beta;
        for _ in 0..4 {
            let (sin, cos) = beta.sin_cos();
            let up = z + E2 / (1.0 - E2) * B_M * sin.powi(3);
            lat_rad = up.atan2((p - E2 * A_M * cos.powi(3)).max(0.0));
            beta = ((1.0 - F) * lat_rad.sin()).atan2(lat_rad.cos());
        }
        let (sin, cos) = lat_rad.sin_cos();
        let (lon_rad, h_m) = (y.atan2(x), p * cos + z * sin - A_M * (1.0 - E2 * sin * sin).sqrt());
        Geodetic { lat_rad, lon_rad, h_m }
    }
}

/// How the mean sea surface falls away from the tangent plane at the scene's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Earth {
    /// The surface is the plane z = 0.
    Flat,
    /// A sphere of radius `radius_factor` times 6371 km: 1 is the geometric Earth, 4/3 standard
    /// refraction.
    Curved {
        /// Effective-radius factor k_e.
        radius_factor: f64,
    },
}

impl Earth {
    /// Effective-radius factor; none of a flat one.
    pub fn radius_factor(self) -> Option<f64> {
        match self {
            Self::Flat => None,
            Self::Curved { radius_factor } => Some(radius_factor),
        }
    }

    /// That of an effective-radius factor; flat without one.
    pub fn of_radius_factor(radius_factor: Option<f64>) -> Self {
        radius_factor.map_or(Self::Flat, |radius_factor| Self::Curved { radius_factor })
    }

    /// Depth of the sea surface below the tangent plane at horizontal distance
    /// `sqrt(x^2 + y^2)` from the origin, metres: `d^2 / (2 k_e R_e)`.
    pub fn drop_m(self, x_m: f64, y_m: f64) -> f64 {
        match self {
            Self::Flat => 0.0,
            Self::Curved { radius_factor } => {
                (x_m * x_m + y_m * y_m) / (2.0 * radius_factor * EARTH_RADIUS_M)
            }
        }
    }

    /// Gradient of [`Self::drop_m`] along x and y: how steeply the sea surface falls away there.
    pub fn drop_slope(self, x_m: f64, y_m: f64) -> [f64; 2] {
        match self {
            Self::Flat => [0.0; 2],
            Self::Curved { radius_factor } => [x_m, y_m].map(|d| d / (radius_factor * EARTH_RADIUS_M)),
        }
    }

    /// Unit vector straight up at a place: away from the centre of the modelled Earth, +z over a flat one.
    pub fn up(self, place: Point<Enu>) -> Vector<Enu> {
        let up = match self {
            Self::Flat => DVec3::Z,
            Self::Curved { radius_factor } => {
                (place.raw() + DVec3::Z * (radius_factor * EARTH_RADIUS_M)).normalize_or(DVec3::Z)
            }
        };
        Vector::from_raw(up)
    }
}

/// The scene's ENU frame: where its origin is on Earth (if it is georeferenced) and how the sea curves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneFrame {
    origin: Option<Geodetic>,
    ecef_origin_m: DVec3,
    to_enu: DMat3,
    earth: Earth,
    horizon: bool,
}

impl SceneFrame {
    /// A plain local frame that is not georeferenced.
    pub fn plain(earth: Earth) -> Self {
        Self { origin: None, ecef_origin_m: DVec3::ZERO, to_enu: DMat3::IDENTITY, earth, horizon: true }
    }

    /// The frame whose origin is the given point of the mean sea surface (its ellipsoidal height is
    /// the geoid undulation there).
    pub fn at(origin: Geodetic, earth: Earth) -> Self {
        let (sin_lat, cos_lat) = origin.lat_rad.sin_cos();
        let (sin_lon, cos_lon) = origin.lon_rad.sin_cos();
        let east = DVec3::new(-sin_lon, cos_lon, 0.0);
        let north = DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
        let up = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
        Self {
            origin: Some(origin),
            ecef_origin_m: origin.to_ecef().raw(),
            to_enu: DMat3::from_cols(east, north, up).transpose(),
            earth,
            horizon: true,
        }
    }

    /// The same, with or without a horizon that hides what lies beyond it. A flat earth has none.
    pub fn with_horizon(self, horizon: bool) -> Self {
        Self { horizon, ..self }
    }

    /// The origin, `None` for a plain local frame.
    pub fn origin(&self) -> Option<Geodetic> {
        self.origin
    }

    /// The earth as it hides what lies beyond its horizon: flat where it hides nothing.
    pub fn hiding_earth(&self) -> Earth {
        if self.horizon { self.earth } else { Earth::Flat }
    }

    /// The shape of the mean sea surface.
    pub fn earth(&self) -> Earth {
        self.earth
    }

    /// ECEF to ENU. `None` for a plain local frame.
    pub fn from_ecef(&self, point: Point<Ecef>) -> Option<Point<Enu>> {
        self.origin?;
        Some(Point::from_raw(self.to_enu * (point.raw() - self.ecef_origin_m)))
    }

    /// ENU to ECEF. `None` for a plain local frame.
    pub fn to_ecef(&self, point: Point<Enu>) -> Option<Point<Ecef>> {
        self.origin?;
        Some(Point::from_raw(self.to_enu.transpose() * point.raw() + self.ecef_origin_m))
    }

    /// ECEF components of an ENU direction or velocity. `None` for a plain local frame.
    pub fn vector_to_ecef(&self, vector: Vector<Enu>) -> Option<Vector<Ecef>> {
        self.origin?;
        Some(Vector::from_raw(self.to_enu.transpose() * vector.raw()))
    }

    /// ENU components of an ECEF direction or velocity. `None` for a plain local frame.
    pub fn vector_from_ecef(&self, vector: Vector<Ecef>) -> Option<Vector<Enu>> {
        self.origin?;
        Some(Vector::from_raw(self.to_enu * vector.raw()))
    }

    /// Geodetic to ENU. `None` for a plain local frame.
    pub fn from_geodetic(&self, position: Geodetic) -> Option<Point<Enu>> {
        self.from_ecef(position.to_ecef())
    }

    /// ENU to geodetic. `None` for a plain local frame.
    pub fn to_geodetic(&self, point: Point<Enu>) -> Option<Geodetic> {
        Some(self.to_ecef(point)?.to_geodetic())
    }

    /// The ENU point at `height_m` above the mean sea surface, over horizontal position (x, y).
    pub fn above_sea(&self, x_m: f64, y_m: f64, height_m: f64) -> Point<Enu> {
        Point::new(x_m, y_m, height_m - self.earth.drop_m(x_m, y_m))
    }
}
