//! Platforms: their tracks, what they report, the air.

use super::*;

/// The keys of one kind of error, in the order in which the reader takes them: they differ in units alone.
macro_rules! axis_table {
    ($module:ident $heading:literal $about:literal, $unit:literal, $name:literal, sinusoid $sinusoid:literal,
     ramp $ramp:literal $ramp_unit:literal, quantisation $of:literal $coarsest:expr,
     $limit:expr, $sigma_limit:expr, $ramp_limit:expr) => {
        #[doc = concat!("Keys of `", $heading, "`.")]
        pub mod $module {
            use super::*;
            const fn key(name: &'static str, kind: Kind, absent: Absent, about: &'static str) -> Key {
                Key { name, kind, absent, about }
            }
            static KEYS: [Key; 13] = [
                key(concat!("bias_", $name), vector($unit, 3, $limit), Zeros, "Constant, exactly."),
                key(
                    concat!("bias_sigma_", $name),
                    sizes($unit, $sigma_limit),
                    Zeros,
                    "Standard deviation of a constant that is drawn once.",
                ),
                key(
                    concat!("white_", $name),
                    sizes($unit, $sigma_limit),
                    Zeros,
                    "Standard deviation of noise that is new in every report.",
                ),
                key(
                    concat!("walk_", $name, "_per_root_s"),
                    sizes(concat!($unit, "/sqrt(s)"), $sigma_limit),
                    Zeros,
                    "Random walk.",
                ),
                key(
                    concat!("gm_sigma_", $name),
                    sizes($unit, $sigma_limit),
                    Zeros,
                    "Standard deviation of a first-order Gauss-Markov process.",
                ),
                key("gm_tau_s", above("s", 0.0, 1e7), default(100.0), "Its correlation time."),
                key($sinusoid, vector($unit, 3, $sigma_limit), Zeros, "Amplitude of a sinusoid."),
                key("sinusoid_hz", number("Hz", 0.0, 1e4), default(0.1), "Its frequency."),
                key("sinusoid_deg", number("deg", -360.0, 360.0), default(0.0), "Its phase at pulse 0."),
                key(concat!("step_", $name), vector($unit, 3, $limit), Zeros, "Size of a step."),
                key("step_at_s", number("s", -1e7, 1e7), default(0.0), "When, after pulse 0."),
                key($ramp, vector($ramp_unit, 3, $ramp_limit), Zeros, "Growth from pulse 0 on."),
                key(
                    concat!("quantisation_", $name),
                    number($unit, 0.0, $coarsest),
                    default(0.0),
                    concat!("What reported ", $of, " are whole multiples of; 0: nothing."),
                ),
            ];
            /// The table.
            pub static TABLE: Table = Table {
                heading: $heading,
                about: $about,
                keys: &[
                    &KEYS[0], &KEYS[1], &KEYS[2], &KEYS[3], &KEYS[4], &KEYS[5], &KEYS[6], &KEYS[7], &KEYS[8],
                    &KEYS[9], &KEYS[10], &KEYS[11], &KEYS[12],
                ],
            };
        }
    };
}

axis_table! {
    error_m "[platform.errors.position]" "Errors of the position: East, North, up.", "m", "m", sinusoid "sinusoid_m",
    ramp "ramp_mps" "m/s", quantisation "coordinates" 1e4, FAR_M, 1e6, FAST_MPS
}
axis_table! {
    error_mps "[platform.errors.velocity]" "Errors of the velocity: East, North, up.", "m/s", "mps", sinusoid "sinusoid_mps",
    ramp "ramp_mps2" "m/s^2", quantisation "components" 1e3, FAST_MPS, 1e4, FAST_MPS
}
axis_table! {
    error_deg "[platform.errors.attitude]" "Errors of the attitude: roll, pitch, heading (clockwise).", "deg", "deg", sinusoid "sinusoid_amplitude_deg",
    ramp "ramp_degps" "deg/s", quantisation "angles" 90.0, 360.0, 360.0, 360.0
}

tables! {
    platform "[[platform]]" "Something that carries antennas." {
        NAME "name", Name, Required, "Its name, unique among platforms.";
        TRACK "track", Section(&track::TABLE), Required, "Where it is: drives delays, phases and gains.";
        REPORTED "reported", Section(&track::TABLE), Means("the true track is reported"), "Where it reports to be, in the same form.";
        ERRORS "errors", Section(&errors::TABLE), Means("none"), "Errors of its reports.";
        TURBULENCE "turbulence", Section(&turbulence::TABLE), Means("still air"), "Gusts that it flies through: true motion about its track.";
    }
    errors "[platform.errors]" "Known errors of what a platform reports: report minus truth. The same seed gives the same errors, in whole runs and in parts." {
        PRESET "preset", Choice(words::<Class>), Means("no errors but those below"), "Class of navigation to start from: satellites, with carrier phase, aided tactical or navigation-grade inertial unit. The keys below stand above it.";
        RECORDED "recorded", Choice(words::<Recorded>), Word("truth"), "What the track is. truth: what happened, errors are added to the report. reported: what was reported, the true motion differs from it; errors must then be smooth (bias, sinusoid, ramp, walk, Gauss-Markov of position and attitude).";
        RATE_HZ "rate_hz", number("Hz", 0.0, 1e5), Means("that of the preset, or 0: a report at every pulse"), "Reports per second from pulse 0 on.";
        LATENCY_S "latency_s", number("s", 0.0, 60.0), Means("that of the preset, or 0"), "From the epoch of a report to its arrival.";
        JITTER_S "jitter_s", number("s", 0.0, 10.0), default(0.0), "Standard deviation of the arrival (Gaussian). Time stamps are right.";
        BETWEEN "between", Choice(words::<Between>), Word("extrapolate"), "Until the next report arrives: moved on with the reported velocity, or held.";
        DROPOUTS "dropouts", Section(&dropouts::TABLE), Means("none"), "Reports that are lost for a while.";
        LEVER_ARM_ERROR_M "lever_arm_error_m", vector("m", 3, 1e4), Zeros, "Error of the lever arm: forward, starboard, down.";
        POSITION "position", Section(&error_m::TABLE), Means("that of the preset, or none"), "Errors of the position.";
        VELOCITY "velocity", Section(&error_mps::TABLE), Means("that of the preset, or none"), "Errors of the velocity, in addition to the derivative of sinusoid and ramp of the position.";
        ATTITUDE "attitude", Section(&error_deg::TABLE), Means("that of the preset, or none"), "Errors of roll, pitch and heading.";
    }
    dropouts "[platform.errors.dropouts]" "Reports that are lost for a while: good reception and dropouts last for exponentially distributed times. Pulse 0 finds reception good." {
        PER_HOUR "per_hour", number("1/h", 0.0, 1e6), Required, "Dropouts per hour of good reception.";
        MEAN_S "mean_s", above("s", 0.0, 1e6), Required, "Mean length.";
        DURING "during", Choice(words::<Between>), Word("extrapolate"), "What is reported meanwhile: the last report moved on with its velocity, or held.";
    }
    turbulence "[platform.turbulence]" "Gusts of the Dryden model and an aircraft's response. Exactly one of level and wind20_mps." {
        LEVEL "level", Choice(words::<GustLevel>), Means("wind20_mps is given"), "A wind of 15, 30 or 45 knots at 20 ft.";
        WIND20_MPS "wind20_mps", number("m/s", 0.0, 100.0), Means("level is given"), "Wind at 20 ft (6.1 m) above the sea.";
        HEIGHT_M "height_m", number("m", 0.0, 1e5), Means("that of the platform at pulse 0"), "Height above the sea for which gusts are taken.";
        AIRSPEED_MPS "airspeed_mps", number("m/s", 5.0, 1e4), Means("the speed of the platform at pulse 0"), "Speed at which gusts are met.";
        CUTOFF_HZ "cutoff_hz", number("Hz", 0.05, 5.0), default(0.5), "Cutoff of the aircraft's response: a low pass of second order.";
        VELOCITY_GAIN "velocity_gain", number("", 0.0, 10.0), default(1.0), "Ratio of aircraft velocity to gust velocity at low frequency.";
        ATTITUDE_GAIN "attitude_gain", number("", 0.0, 10.0), default(1.0), "Ratio of the angle by which the nose turns into the gust to gust velocity over airspeed, at low frequency.";
        TRACK_HOLD_S "track_hold_s", number("s", 0.0, 1e5), default(30.0), "Time in which it is steered back to its track; 0: it drifts.";
    }
    track "[platform.track] and [platform.reported]" "A trajectory." {
        KIND "kind", Choice(words::<TrackKind>), Required, "Stays; straight line at constant speed; recorded track; what a receiver reports during the run (docs/navigation.md).";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg, lon_deg and h_m are given"), "fixed, straight: East, North, up in the scene frame (tangent plane at the origin), at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "fixed, straight: latitude, WGS-84.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "fixed, straight: longitude.";
        H_M "h_m", number("m", -11_000.0, FAR_M), Means("position_m is given"), "fixed, straight: height above the datum.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Required, "straight: velocity East, North, up.";
        YAW_DEG "yaw_deg", number("deg", -360.0, 360.0), Means("0; straight: along the velocity"), "Yaw clockwise from North. fixed, straight, and recordings with attitude = \"constant\".";
        PITCH_DEG "pitch_deg", number("deg", -90.0, 90.0), Means("0; straight: along the velocity"), "Pitch, nose up.";
        ROLL_DEG "roll_deg", number("deg", -180.0, 180.0), Means("0"), "Roll, right wing down.";
        PATH "path", File, Required, "Recordings: the file.";
        DATUM "datum", Choice(words::<DatumKind>), Means("required, but for position_m, for recordings of x_m, y_m, z_m in a scene without origin, and for inspvax and sbet, which say it; live: \"msl\""), "What heights are measured from: WGS-84 ellipsoid, mean sea level, or (recordings, live) standard pressure altitude. live: where the messages do not say.";
        BAROMETRIC_OFFSET_M "barometric_offset_m", number("m", -2000.0, 2000.0), default(0.0), "barometric: added to make a pressure altitude a height above mean sea level.";
        GPS_WEEK "gps_week", count(0, 8191), Required, "sbet: GPS week of the first record; the file has seconds of the week only. 2000 began on 2018-05-06.";
        DATE "date", Date, Means("that of the messages (RMC, ZDA)"), "nmea, live: day of the first position, in place of the dates of the messages: for logs of GGA alone, and for receivers whose date is wrong.";
        MAX_GAP_S "max_gap_s", above("s", 0.0, 86_400.0), default(5.0), "Recordings, live: longest gap between fixes that is interpolated.";
        SMOOTHING "smoothing", Section(&smoothing::TABLE), Means("off"), "Recordings: how fixes become a smooth track.";
        ATTITUDE "attitude", Choice(words::<AttitudeKind>), Means("recorded where the fixes have it, otherwise coordinated_turn; `check` and `run` report which"), "Recordings, live: where the attitude comes from. coordinated_turn: derived from the motion, nose along the velocity, roll of a coordinated turn. level: the same with level wings. ADS-B and GGA carry none.";
        SOURCE "source", Kind::Origin, Required, "live: where its messages come from, NMEA 0183 and NovAtel INSPVAX: a serial port, somebody to connect to, an address to which a sender connects or sends datagrams, a file that is replayed in time.";
        BAUD "baud", count(50, 4_000_000), Count(115_200), "live, serial port: bits per second.";
        MAX_EXTRAPOLATION_S "max_extrapolation_s", above("s", 0.0, 86_400.0), default(1.0), "live: longest time after the last fix for which motion is extrapolated from it. Sentences come an epoch late: for a receiver of one epoch per second take 2.5.";
        TIMEOUT_S "timeout_s", number("s", 0.0, 86_400.0), default(30.0), "live: how long the begin of the run waits for navigation.";
        VEHICLE "vehicle", Choice(words::<MotionBounds>), Means("aircraft; recordings: spacecraft, whose speeds nothing exceeds"), "live, recordings without smoothing: what carries the receiver. It sets the bounds of the plausibility gate: 40 m/s and 10 m/s^2 for a ship, 100 and 30 on the ground, 1000 and 100 in the air, 12000 and 100 in orbit.";
        MAX_SPEED_MPS "max_speed_mps", above("m/s", 0.0, FAST_MPS), Means("that of the vehicle"), "live, recordings without smoothing: a fix that would need a higher speed is counted and refused.";
        MAX_ACCELERATION_MPS2 "max_acceleration_mps2", above("m/s^2", 0.0, 1e5), Means("that of the vehicle"), "live, recordings without smoothing: a fix that would need a higher acceleration is counted and refused.";
        RESET_FIXES "reset_fixes", count(2, 1000), Count(5), "live, recordings without smoothing: so many refused fixes in a row that agree with each other are believed after all.";
        NOMINAL "nominal", Section(&TABLE), Means("what needs the flight beforehand is left out"), "live: a track of another kind that stands for the flight in `check` and in `plan`.";
    }
    smoothing "[platform.track.smoothing]" "How fixes become a smooth track." {
        KIND "kind", Choice(words::<SmoothingKind>), Required, "Fixes are exact, or a Rauch-Tung-Striebel smoother.";
        HORIZONTAL_SIGMA_M "horizontal_sigma_m", number("m", 1e-4, 1e4), default(5.0), "rts: standard deviation of the horizontal position of a fix.";
        VERTICAL_SIGMA_M "vertical_sigma_m", number("m", 1e-4, 1e4), default(5.0), "rts: standard deviation of the height of a fix.";
        MAX_ACCELERATION_MPS2 "max_acceleration_mps2", number("m/s^2", 0.01, 1e3), default(3.0), "rts: bound on the acceleration of the track.";
    }
}
