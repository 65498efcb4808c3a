//! Point targets, and changes of what platforms report.

use super::*;

tables! {
    target "[[target]]" "A point target on a straight course, or on a track. Its strength is one of rcs_m2, rcs_dbsm, rcs_csv, or a scattering matrix." {
        NAME "name", Name, Means("target-<number>, counted from 0"), "Its name, unique among targets.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given, or a track"), "East, North, height above the sea, at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "Latitude.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "Longitude.";
        HEIGHT_M "height_m", number("m", -11_000.0, FAR_M), default(0.0), "With lat_deg and lon_deg, or on a track with heights = \"sea\": height above the sea.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "Velocity East, North, up.";
        TRACK "track", Section(&way::TABLE), Means("it goes straight on"), "How it moves instead, in place of position_m and velocity_mps.";
        RCS_M2 "rcs_m2", number("m^2", 0.0, 1e12), Means("another strength is given"), "Radar cross section of a sphere or trihedral: HH and VV equal, no HV.";
        RCS_DBSM "rcs_dbsm", number("dBsm", -300.0, 120.0), Means("another strength is given"), "The same in dB over 1 m^2.";
        RCS_CSV "rcs_csv", File, Means("another strength is given"), "Radar cross sections by aspect: CSV with the header az_deg,el_deg,rcs_dbsm, a regular grid of azimuth from the bow, positive to starboard, and elevation, with two values of each at least. Monostatic; bistatic radars read it at the bisector. HH and VV equal, no HV.";
        RCS_FLOOR_DBSM "rcs_floor_dbsm", number("dBsm", -300.0, 120.0), default(-300.0), "rcs_csv: cross section outside its grid.";
        HEADING_DEG "heading_deg", number("deg", -360.0, 360.0), Means("along its velocity"), "rcs_csv: where the bow points, clockwise from North.";
        S_VV "s_vv", vector("m", 2, 1e6), Means("[0, 0]"), "Scattering matrix, [re, im], receive then transmit; |S|^2 is the radar cross section.";
        S_VH "s_vh", vector("m", 2, 1e6), Means("[0, 0]"), "Scattering matrix, received V, transmitted H.";
        S_HV "s_hv", vector("m", 2, 1e6), Means("[0, 0]"), "Scattering matrix, received H, transmitted V.";
        S_HH "s_hh", vector("m", 2, 1e6), Means("[0, 0]"), "Scattering matrix, HH.";
        CONVENTION "convention", Choice(words::<Alignment>), Word("fsa"), "Scattering matrix: forward-scatter alignment, or back-scatter alignment (the received basis seen from the antenna, a sphere is the unit matrix). S_fsa = diag(1, -1) S_bsa in the order v, h.";
        FLOATING "floating", Kind::Flag, Flag(false), "Whether the waves of [sea] lift it, on top of the height of its position, and tilt its rcs_csv, and their crests hide it where sea.shadow is on. Its velocity is then level.";
        WATERLINE_M "waterline_m", number("m", 0.1, 1000.0), default(5.0), "floating: its length; shorter waves do not move it.";
        MULTIPATH "multipath", Kind::Flag, Flag(false), "Whether the mean sea reflects the rays between it and the antennas: four paths in place of one.";
        SWERLING "swerling", count(0, 4), Count(0), "How the radar cross section fluctuates about the one given, Swerling's cases: 0 not at all; 1 exponential, constant over a scan; 2 exponential, from pulse to pulse; 3 and 4 the same with chi-square of four degrees of freedom.";
        SWERLING_SCAN_S "swerling_scan_s", above("s", 0.0, 1e7), Means("required with swerling 1 and 3"), "Cases 1 and 3: how long the cross section is constant, counted from pulse 0.";
    }
    target_grid "[[target_grid]]" "A field of equal point targets, named <name>-<east>-<north>." {
        NAME "name", Name, Means("grid-<number>, counted from 0"), "First part of the names.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given"), "Centre: East, North, height above the sea.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "Latitude of the centre.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "Longitude of the centre.";
        HEIGHT_M "height_m", number("m", -11_000.0, FAR_M), default(0.0), "With lat_deg and lon_deg: height above the sea.";
        COUNT "count", Kind::Numbers { unit: "", least: 2, most: 2, min: 1.0, max: 1000.0 }, Required, "Targets eastward and northward, whole numbers.";
        SPACING_M "spacing_m", vector("m", 2, 1e6), Required, "Distance between neighbours, eastward and northward.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "Velocity East, North, up.";
        RCS_M2 "rcs_m2", number("m^2", 0.0, 1e12), Means("rcs_dbsm is given"), "Radar cross section of each.";
        RCS_DBSM "rcs_dbsm", number("dBsm", -300.0, 120.0), Means("rcs_m2 is given"), "The same in dB over 1 m^2.";
        SWERLING "swerling", count(0, 4), Count(0), "How the radar cross section of each fluctuates, by itself, about the one given, Swerling's cases: 0 not at all; 1 exponential, constant over a scan; 2 exponential, from pulse to pulse; 3 and 4 the same with chi-square of four degrees of freedom.";
        SWERLING_SCAN_S "swerling_scan_s", above("s", 0.0, 1e7), Means("required with swerling 1 and 3"), "Cases 1 and 3: how long the cross section is constant, counted from pulse 0.";
    }
    event "[[event]]" "A change of what a platform reports, from a pulse on (docs/control.md). Exactly one of pulse and at_s." {
        PULSE "pulse", count(0, u64::MAX), Means("at_s is given"), "The first pulse that has it.";
        AT_S "at_s", number("s", 0.0, 1e7), Means("pulse is given"), "After pulse 0: the first pulse emitted then or later has it.";
        PLATFORM "platform", Name, Means("the only platform"), "Whose report.";
        CHANGE "change", Kind::Line, Required, "What changes, in the words of a control line: \"step position.up 5 m\", \"bias attitude.heading 0.3 deg\", \"ramp position.east 0.5 m/s\", \"dropout 2.5 s\", \"latency 250 ms\", \"clear\".";
    }
}
