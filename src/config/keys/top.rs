//! The scenario as a whole, and where and when it is.

use super::*;

tables! {
    root "(top level)" "The tables of a scenario." {
        SCENE "scene", Section(&scene::TABLE), Required, "Where and when.";
        RADAR "radar", Section(&radar::TABLE), Required, "The instrument.";
        PLATFORM "platform", Sections(&platform::TABLE), Required, "What moves; at least one.";
        TRANSMITTER "transmitter", Sections(&transmitter::TABLE), Required, "Transmitters; at least one.";
        RECEIVER "receiver", Sections(&receiver::TABLE), Required, "Receivers; at least one.";
        EMITTER "emitter", Sections(&emitter::TABLE), Means("none"), "What receivers take besides: other radars, jammers.";
        SEA "sea", Section(&sea::TABLE), Means("no sea: targets alone"), "The sea, on the patch of [scene].";
        SWELL "swell", Sections(&swell::TABLE), Means("none"), "Swell trains, with [sea].";
        SLICK "slick", Sections(&slick::TABLE), Means("none"), "Films on the water, with [sea].";
        LAND "land", Section(&land::TABLE), Means("none"), "Land on the patch, with [sea].";
        SHIP "ship", Sections(&ship::TABLE), Means("none"), "Ships under way, with [sea].";
        AIS "ais", Sections(&ais::TABLE), Means("none"), "Ships of a recorded AIS log, with [sea].";
        TARGET "target", Sections(&target::TABLE), Means("none"), "Point targets.";
        TARGET_GRID "target_grid", Sections(&target_grid::TABLE), Means("none"), "Fields of equal point targets.";
        EVENT "event", Sections(&event::TABLE), Means("none"), "Changes of what platforms report, each from a pulse on.";
        FIDELITY "fidelity", Section(&fidelity::TABLE), Means("all defaults"), "Speed against accuracy.";
        STREAM "stream", Section(&stream::TABLE), Means("all defaults"), "How pulses are released.";
        SINK "sink", Sections(&sink::TABLE), Means("pulses are counted and forgotten"), "Where pulses go.";
    }
    scene "[scene]" "Where and when. The scene frame is East, North, up at the origin, a point of mean sea level." {
        ORIGIN_LAT_DEG "origin_lat_deg", number("deg", -90.0, 90.0), Means("a plain local frame, not georeferenced"), "Latitude of the origin, WGS-84. The three origin keys stand together or not at all.";
        ORIGIN_LON_DEG "origin_lon_deg", number("deg", -180.0, 360.0), Means("see origin_lat_deg"), "Longitude of the origin, East positive.";
        ORIGIN_H_M "origin_h_m", number("m", -500.0, 10_000.0), Means("see origin_lat_deg"), "Height of mean sea level above the WGS-84 ellipsoid at the origin (the geoid undulation). It converts every height above sea level of the scenario.";
        EARTH "earth", Choice(words::<Curved>), Means("\"curved\" with an origin, \"flat\" without"), "Shape of the mean sea surface.";
        EARTH_RADIUS_FACTOR "earth_radius_factor", number("", 0.1, 100.0), default(1.0), "Curved earth: effective radius over 6371 km; 4/3 is standard refraction.";
        HORIZON "horizon", Kind::Flag, Means("true on a curved earth"), "Curved earth: whether it hides the sea, targets and the direct path beyond the horizon of an antenna. Without diffraction.";
        START_UTC "start_utc", TimeOr(&[("now", "without recorded tracks, logs and live navigation"), ("live", "with live navigation and no recording")]), Means("2000-01-01T00:00:00Z; required with recorded tracks and live navigation"), "Emission of pulse 0, from which all stamps count; release counts from the start of the run, whenever that is. now: the first whole second for which the run is ready, and it waits for it. live: the first whole second that live navigation covers.";
        DURATION_S "duration_s", above("s", 0.0, 1e7), Required, "Pulses leave from start_utc until just before this much later.";
        SEED "seed", count(0, u64::MAX), Count(0), "Seed of every random stream.";
        PATCH "patch", Choice(words::<PatchKind>), Word("fixed"), "With [sea]: whether the patch of sea that is modelled stays, or follows a point as the platforms fly on.";
        PATCH_SIZE_M "patch_size_m", Kind::Numbers { unit: "m", least: 2, most: 2, min: 1e-4, max: FAR_M }, Means("required with [sea]"), "Length of the patch along East and North, whole facets. The waves repeat after it.";
        FACET_M "facet_m", number_or("auto", "m", 1e-4, 1e5), Means("required with [sea]"), "Side of a facet of the sea, or \"auto\": the largest that divides both sides of the patch and is small enough for speckle in a cell of c/(2 B) by azimuth_resolution_m, B the bandwidth_hz of the waveform or else the sample rate, and for 12 facets along the wave at Elfouhaily's peak (of wind and inverse_wave_age; not below 1 m).";
        AZIMUTH_RESOLUTION_M "azimuth_resolution_m", above("m", 0.0, 1e5), default(1.0), "With [sea]: resolution in azimuth of the processor that follows. Facets are judged and chosen by it; the echo does not depend on it.";
        PATCH_CENTRE_M "patch_centre_m", vector("m", 2, FAR_M), Zeros, "fixed: centre of the patch, East and North, to the nearest facet.";
        PATCH_FOLLOW "patch_follow", Section(&patch_follow::TABLE), Means("the point at which the first receiver aims; required where it aims at none"), "follow: the point that the patch stays around.";
    }
    patch_follow "[scene.patch_follow]" "The point that the patch of sea stays around." {
        KIND "kind", Choice(words::<Followed>), Required, "A point of the sea beside a platform, or one on a straight course.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given"), "point: East, North, height above the sea, at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "point: latitude; the point lies on the sea.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "point: longitude.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "point: velocity East, North, up.";
        PLATFORM "platform", Name, Required, "beside: the platform.";
        ALONG_M "along_m", number("m", -FAR_M, FAR_M), default(0.0), "beside: metres ahead along the ground track.";
        ACROSS_M "across_m", number("m", -FAR_M, FAR_M), Required, "beside: metres to starboard of the ground track, negative to port.";
        AIM_FROM "aim_from", Choice(words::<AimFrom>), Word("reported"), "Which tracks the point is known from.";
    }
}
