//! Trajectories: fixed and straight.

use thiserror::Error;

use crate::frames::{Body, Enu, Point, Rotation, Vector};
use crate::time::TimeTag;

/// Why a track cannot say where a platform is.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TrackError {
    /// The instant is outside the track.
    #[error("{time} is outside the track")]
    Outside {
        /// What was asked.
        time: TimeTag,
    },
}

/// A platform at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Position.
    pub position: Point<Enu>,
    /// Velocity, m/s.
    pub velocity: Vector<Enu>,
    /// Acceleration, m/s^2.
    pub acceleration: Vector<Enu>,
    /// Attitude.
    pub attitude: Rotation<Body, Enu>,
    /// Angular rate, rad/s.
    pub angular_rate: Vector<Enu>,
}

/// A trajectory.
#[derive(Clone, Debug)]
pub struct Track {
    at: TimeTag,
    state: State,
}

impl Track {
    /// Stays where it is.
    pub fn fixed(position: Point<Enu>, attitude: Rotation<Body, Enu>) -> Self {
        Self::straight(position, TimeTag::default(), Vector::ZERO, Some(attitude))
    }

    /// Straight line at constant speed; without an attitude, nose along the velocity, wings level.
    pub fn straight(
        position: Point<Enu>,
        at: TimeTag,
        velocity: Vector<Enu>,
        attitude: Option<Rotation<Body, Enu>>,
    ) -> Self {
        let v = velocity.raw();
        let attitude = attitude.unwrap_or_else(|| Rotation::from_yaw_pitch_roll(v.x.atan2(v.y), 0.0, 0.0));
        let (acceleration, angular_rate) = (Vector::ZERO, Vector::ZERO);
        Self { at, state: State { position, velocity, acceleration, attitude, angular_rate } }
    }

    /// First and last instant, `None` where there is no end.
    pub fn span(&self) -> Option<(TimeTag, TimeTag)> {
        None
    }

    /// Whether the track covers a stretch of time.
    pub fn covers(&self, _from: TimeTag, _to: TimeTag) -> Result<(), TrackError> {
        Ok(())
    }

    /// The platform at an instant.
    pub fn state(&self, t: TimeTag) -> Result<State, TrackError> {
        let moved = self.state.velocity * t.since(self.at);
        Ok(State { position: self.state.position + moved, ..self.state })
    }
}
