//! Ships and their wakes.

use super::*;

tables! {
    ship "[[ship]]" "A ship on a straight course at constant speed through water at rest, or on a track: its waves and its turbulent wake. Exactly one direction, or a track." {
        NAME "name", Name, Means("ship-<number>, counted from 0"), "Its name, unique among ships.";
        HULL "hull", FileOr("wigley"), Required, "A description (.toml) or an offset table (.csv), see hulls/README.md; or the parabolic hull of Wigley.";
        LENGTH_M "length_m", number("m", 0.05, 1000.0), Means("that of the hull's file; required with \"wigley\""), "Length on the waterline to which the hull is scaled.";
        BEAM_M "beam_m", above("m", 0.0, 1000.0), Required, "wigley: beam, from a ten-thousandth of the length to the length.";
        DRAUGHT_M "draught_m", above("m", 0.0, 1000.0), Required, "wigley: draught, within the same bounds.";
        POSITION_M "position_m", vector("m", 2, FAR_M), Means("lat_deg and lon_deg are given, or a track"), "Midship at pulse 0, East and North.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "Latitude of midship at pulse 0.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "Longitude.";
        HEADING_DEG "heading_deg", number("deg", -360.0, 360.0), Means("towards_deg is given"), "Direction in which it sails, clockwise from the North of the scene, as a compass has it.";
        TOWARDS_DEG "towards_deg", number("deg", -360.0, 360.0), Means("heading_deg is given"), "The same, counter-clockwise from East.";
        SPEED_MPS "speed_mps", number("m/s", 0.0, 100.0), Means("required without a track"), "Speed through the water.";
        TRACK "track", Section(&way::TABLE), Means("it sails straight on"), "How it sails instead, in place of position, direction and speed: it heads along its course over ground.";
        WAKE "wake", Kind::Flag, Flag(true), "Whether it raises waves.";
        BAND_LIMIT_RADPM "band_limit_radpm", above("rad/m", 0.0, 1e6), Means("0.7 pi / facet_m"), "With wake: wave number above which its waves are left out.";
        WAKE_BRAGG "wake_bragg", Kind::Flag, Means("true below a carrier of 6 GHz"), "With wake: whether its waves above the band limit scatter by Bragg within facets, in a narrow V about its track.";
        TURBULENT "turbulent", Switched(&turbulent::TABLE), Flag(true), "Its turbulent wake, in which small waves are damped.";
        ECHO "echo", Kind::Flag, Flag(false), "Whether it returns an echo: of the scatterers of its hull's file, or else of its mesh.";
        MESH "mesh", Kind::Flag, Means("true unless the hull's file has scatterers"), "With echo: whether hull and superstructure return it by physical optics, panel by panel.";
        SUPERSTRUCTURE "superstructure", FileOr("none"), Means("\"none\""), "With a mesh: what stands on the hull, triangles of an .obj or .stl file in metres, x forward of midship, y to port, z up from the waterline; scaled with the hull.";
        UP "up", Choice(words::<UpAxis>), Word("z"), "With a superstructure: the axis of its file that points up. With \"y\" z points to starboard, as graphics programs have it.";
        FREEBOARD_M "freeboard_m", above("m", 0.0, 100.0), Means("a twentieth of the length"), "With a mesh: height of the deck above the waterline, up to which the sides of the hull rise.";
        PANEL_M "panel_m", number("m", 0.05, 100.0), default(1.0), "With a mesh: longest edge of a panel; at most 100000 panels per ship.";
        MOTION "motion", Choice(words::<RideKind>), Word("level"), "With a mesh: whether it rides level, or heaves, pitches and rolls with the waves of [sea] by the response of a box of its length, beam, draught and block coefficient.";
        ROLL_PERIOD_S "roll_period_s", number("s", 0.5, 60.0), Means("2 C B / sqrt(GM) with GM = 0.07 B and C = 0.373 + 0.023 B/T - 0.00043 L, 0.3 at least (beam B, draught T, length L in m)"), "motion = \"waves\": its natural period of roll.";
    }
    ais "[[ais]]" "Ships of a recorded AIS log, named mmsi-<number>: each sails straight on with the course and speed of its report nearest to the start, or follows its reports. A log is a CSV with the columns Time (UTC), MMSI, Latitude_degrees, Longitude_degrees, COG_degrees, SOG_knots, and if it has them Length_metres, Beam_metres, Draught_metres; or as MarineCadastre or the Danish Maritime Authority name them; or sentences !AIVDM with times in tag blocks. Needs an origin." {
        LOG "log", File, Required, "The log.";
        MMSI "mmsi", Kind::Numbers { unit: "", least: 1, most: 1000, min: 0.0, max: 999_999_999.0 }, Means("all vessels"), "Only these vessels; all of them must be in the log.";
        START_UTC "start_utc", Time, Means("scene.start_utc"), "Instant of the log at which pulse 0 is emitted.";
        HULL "hull", FileOr("wigley"), Means("\"wigley\""), "Hull of all of them, as in [[ship]].";
        LENGTH_M "length_m", number("m", 0.05, 1000.0), default(60.0), "Length of ships for which the log has none. Beam and draught of a Wigley hull are those of the log, or 0.134 and 0.043 of the length, as those of DTMB 5415.";
        MOST_AGE_S "most_age_s", number("s", 0.0, 1e6), default(180.0), "Vessels without a report so near to the start are left out.";
        LEAST_SPEED_MPS "least_speed_mps", number("m/s", 0.0, 100.0), default(0.5), "Slower vessels are left out: a ship at anchor raises no waves.";
        FOLLOW "follow", Kind::Flag, Flag(false), "Whether vessels follow their reports, each between two by the positions, courses and speeds of both; without, each sails straight on. Vessels with one report sail straight on.";
        MAX_TURN_DEGPS "max_turn_degps", above("deg/s", 0.0, 60.0), default(1.5), "follow: a report for which a vessel would have to turn faster is counted and left out.";
        WITHIN_M "within_m", above("m", 0.0, FAR_M), default(20_000.0), "Vessels further from the origin at the start are left out.";
        WAKE "wake", Kind::Flag, Flag(true), "As in [[ship]].";
        WAKE_BRAGG "wake_bragg", Kind::Flag, Means("true below a carrier of 6 GHz"), "As in [[ship]].";
        TURBULENT "turbulent", Switched(&turbulent::TABLE), Flag(true), "As in [[ship]].";
        ECHO "echo", Kind::Flag, Flag(false), "As in [[ship]], as are the keys below: of the scatterers of the hull's file, or else of the mesh of each hull.";
        MESH "mesh", Kind::Flag, Means("true unless the hull's file has scatterers"), "As in [[ship]].";
        SUPERSTRUCTURE "superstructure", FileOr("none"), Means("\"none\""), "As in [[ship]]: the same on all of them, scaled with a hull that comes from a file.";
        UP "up", Choice(words::<UpAxis>), Word("z"), "As in [[ship]].";
        FREEBOARD_M "freeboard_m", above("m", 0.0, 100.0), Means("a twentieth of the length"), "As in [[ship]].";
        PANEL_M "panel_m", number("m", 0.05, 100.0), Means("a fiftieth of each length"), "As in [[ship]].";
        MOTION "motion", Choice(words::<RideKind>), Word("level"), "As in [[ship]].";
        ROLL_PERIOD_S "roll_period_s", number("s", 0.5, 60.0), Means("that of each hull, as in [[ship]]"), "As in [[ship]].";
    }
    way "[ship.track] and [target.track]" "How a ship or a target moves: recorded, or through waypoints. Recordings must cover the run." {
        KIND "kind", Choice(words::<WayKind>), Required, "A recorded track, as of a platform; or waypoints.";
        PATH "path", File, Required, "Recordings: the file.";
        HEIGHTS "heights", Choice(words::<HeightsKind>), Word("sea"), "Of targets. sea: it keeps its height_m above the sea. recorded: heights are those of the recording. Ships sail on the sea.";
        DATUM "datum", Choice(words::<DatumKind>), Means("required with heights = \"recorded\", as of a platform"), "What recorded heights are measured from.";
        BAROMETRIC_OFFSET_M "barometric_offset_m", number("m", -2000.0, 2000.0), default(0.0), "barometric: added to make a pressure altitude a height above mean sea level.";
        GPS_WEEK "gps_week", count(0, 8191), Required, "sbet: GPS week of the first record.";
        DATE "date", Date, Means("that of the messages (RMC, ZDA)"), "nmea: day of the first position.";
        MAX_GAP_S "max_gap_s", above("s", 0.0, 86_400.0), default(5.0), "Recordings: longest gap between fixes that is interpolated.";
        SMOOTHING "smoothing", Section(&smoothing::TABLE), Means("off"), "Recordings: how fixes become a smooth track.";
        VEHICLE "vehicle", Choice(words::<MotionBounds>), Means("spacecraft, whose speeds nothing exceeds"), "Recordings without smoothing: what carries the receiver. It sets the bounds of the plausibility gate, as of a platform.";
        MAX_SPEED_MPS "max_speed_mps", above("m/s", 0.0, FAST_MPS), Means("that of the vehicle"), "Recordings without smoothing: a fix that would need a higher speed is counted and refused.";
        MAX_ACCELERATION_MPS2 "max_acceleration_mps2", above("m/s^2", 0.0, 1e5), Means("that of the vehicle"), "Recordings without smoothing: a fix that would need a higher acceleration is counted and refused.";
        RESET_FIXES "reset_fixes", count(2, 1000), Count(5), "Recordings without smoothing: so many refused fixes in a row that agree with each other are believed after all.";
        WAYPOINTS_M "waypoints_m", Kind::Points { unit: "m", least: 2, most: 1000, limit: FAR_M }, Means("waypoints_deg is given"), "waypoints: East and North. Before the first and after the last it goes straight on.";
        WAYPOINTS_DEG "waypoints_deg", Kind::Points { unit: "deg", least: 2, most: 1000, limit: 360.0 }, Means("waypoints_m is given"), "waypoints: latitude and longitude.";
        SPEED_MPS "speed_mps", above("m/s", 0.0, FAST_MPS), Required, "waypoints: speed, constant.";
        TURN_RADIUS_M "turn_radius_m", above("m", 0.0, 1e7), Required, "waypoints: least radius of a turn; it cuts the corner, and its curvature changes gradually.";
        BEGIN_S "begin_s", number("s", -1e7, 1e7), default(0.0), "waypoints: when it leaves the first, after pulse 0.";
    }
    turbulent "[ship.turbulent]" "The dark V behind a ship: width 4 B (x / 4 L)^(1/a) at a distance x from the stern, with length L and beam B." {
        SPREAD_EXPONENT "spread_exponent", number("", 4.0, 5.0), default(5.0), "Exponent a of the width.";
        DECAY_LENGTHS "decay_lengths", number("", 0.01, 1e4), default(20.0), "Distance over which the damping falls by a factor of e, in lengths of the ship.";
        WIND_RATIO "wind_ratio", number("", 0.0, 1.0), default(0.4), "Ratio of the wind that raises the small waves in the middle of the wake to the wind outside.";
    }
}
