//! The sea.

use super::*;

tables! {
    sea "[sea]" "The sea on the patch of [scene]: wind, waves, water. Exactly one strength and one direction of the wind." {
        WIND_USTAR_MPS "wind_ustar_mps", number("m/s", 0.0, 3.0), Means("wind_mps is given"), "Strength of the wind as friction velocity in the profile.";
        WIND_MPS "wind_mps", number("m/s", 0.0, 40.0), Means("wind_ustar_mps is given"), "Strength of the wind as mean speed at wind_height_m. Below 0.3 m/s at 10 m the sea is flat.";
        WIND_HEIGHT_M "wind_height_m", number("m", 1.0, 100.0), default(10.0), "Height above the sea of wind_mps.";
        WIND_PROFILE "wind_profile", Choice(words::<WindProfile>), Word("cardone"), "Profile that carries the wind to other heights: Cardone 1969, or logarithmic with the drag of Wu 1982.";
        WIND_TOWARDS_DEG "wind_towards_deg", number("deg", -360.0, 360.0), Means("wind_from_deg is given"), "Direction in which the wind blows, counter-clockwise from East.";
        WIND_FROM_DEG "wind_from_deg", number("deg", -360.0, 360.0), Means("wind_towards_deg is given"), "Direction from which the wind blows, clockwise from North, as in a weather report.";
        SPECTRUM "spectrum", Choice(words::<SpectrumName>), Word("elfouhaily"), "Spectrum of the wind sea (`nereus table` has another default, see docs/sigma0.md). elfouhaily-fung-lee: Elfouhaily's with the directions of Fung and Lee, as in the MaRS paper. measured: from a file, with the wind's waves beyond its last wave number.";
        INVERSE_WAVE_AGE "inverse_wave_age", number("", 0.84, 5.0), default(0.84), "elfouhaily, elfouhaily-fung-lee: 0.84 fully developed to 5 very young. At most one of inverse_wave_age and fetch_m.";
        FETCH_M "fetch_m", number("m", 100.0, 1e7), Means("inverse_wave_age decides; required with jonswap"), "elfouhaily, elfouhaily-fung-lee, jonswap: distance over which the wind has blown.";
        SPREADING "spreading", Choice(words::<SpreadingLaw>), Word("mitsuyasu"), "pierson-moskowitz, jonswap: exponent s of the spreading cos^2s(phi/2) about the wind: Mitsuyasu's, that of Elfouhaily's upwind to crosswind ratio, or one for all waves.";
        SPREADING_EXPONENT "spreading_exponent", number("", 0.0, 1000.0), Required, "spreading = \"constant\": the exponent s.";
        SPECTRUM_PATH "spectrum_path", File, Required, "measured: CSV with the columns kx_rad_m,ky_rad_m,psi_m4 on a regular grid, K in the direction of travel.";
        SPECTRUM_TAIL "spectrum_tail", Choice(words::<WithTail>), Word("elfouhaily"), "measured: the waves beyond the last wave number of the file: Elfouhaily's of this wind, joined to it, or none (a file without Bragg waves is then a sea without Bragg echo).";
        WAVES "waves", Choice(words::<Waves>), Means("\"choppy\"; \"linear\" with depth_m, scattering.displacement = false or a floating target"), "Shape of the waves of the map. linear: crests and troughs symmetric. choppy: second order in the steepness, crests sharper and higher than troughs, facets denser on them; in deep water, and with facets that follow the horizontal motion.";
        CAPILLARY "capillary", Kind::Flag, Flag(false), "Whether surface tension speeds up short waves.";
        DEPTH_M "depth_m", number("m", 0.1, 1e5), Means("deep water"), "Depth of the water, for the speed of the waves.";
        TEMPERATURE_C "temperature_c", number("C", -2.0, 34.0), default(20.0), "Temperature of the water; klein-swift holds from 0 to 30.";
        SALINITY_PSU "salinity_psu", number("psu", 0.0, 40.0), default(35.0), "Practical salinity (PSS-78); 35 is 35.17 g/kg of salt. klein-swift holds from 4 to 35.";
        PERMITTIVITY "permittivity", Choice(words::<Permittivity>), Word("meissner-wentz"), "Model of the permittivity: Meissner and Wentz 2012 (1 to 90 GHz), Klein and Swift 1977 (1 to 10 GHz), Recommendation ITU-R P.527-6 (1 MHz to 1 THz).";
        AVERAGING "averaging", Choice(words::<Averaging>), Word("automatic"), "How the spectrum is taken on the grid of wave numbers: at points, as means over cells, or means only where the grid is coarse for the spectrum.";
        STATE_PATH "state_path", File, Means("the waves are drawn from scene.seed"), "A saved sea of the same grid to start from.";
        SCATTERING "scattering", Section(&scattering::TABLE), Means("all defaults"), "How facets scatter.";
        SHADOW "shadow", Section(&shadow::TABLE), Means("all defaults"), "What waves hide.";
        FAR "far", Section(&far::TABLE), Means("all defaults"), "The sea beyond the patch.";
    }
    scattering "[sea.scattering]" "How facets scatter." {
        SPLITTING "splitting", Choice(words::<Splitting>), Word("consistent"), "How waves are divided between specular points and Bragg scattering: each once, or all slopes and the whole spectrum in addition to the slopes of the map, as in the MaRS paper.";
        PHASES "phases", Choice(words::<Phases>), Word("polcoherent"), "Random phases of a facet: independent ones of its Bragg and its specular part, with the phases between polarisations kept, or a single one on the magnitudes.";
        SPECKLE "speckle", Choice(words::<SpeckleKind>), Word("random-phase"), "What a facet is in a resolution cell. random-phase: one scatterer, so that speckle needs six facets or more. gaussian: all the scatterers that it holds, of complex Gaussian amplitude, so that one or two are enough. Land keeps its random phases.";
        TILT_MODES "tilt_modes", count(1, 9), Count(3), "speckle = \"gaussian\" with tilt_average: random processes for the tilts within a facet; where waves travel, a facet of three takes 1.8 to 2.6 times as long as one of random phase. 1: level facets, which depolarise by the slopes of the map alone; 3: up to 0.2 dB is lost from 30 to 75 degrees of incidence (0.5 dB cross-polarised), at 85 1 dB of HH and 2.5 dB of HV; 6: 0.1 dB there; 9: nothing.";
        CUT_RADPM "cut_radpm", above("rad/m", 0.0, 1e6), Means("that of the splitting"), "Cutoff wave number that divides the slopes of specular scattering from the Bragg waves.";
        TILT_AVERAGE "tilt_average", Kind::Flag, Means("true; false for mars2007"), "consistent: whether the Bragg part averages over tilts within a facet, so that what the sea returns does not depend on the size of facets. Nine Bragg waves per facet instead of one.";
        LIGHT_WIND "light_wind", Choice(words::<LightWinds>), Word("threshold"), "Bragg waves in light wind. threshold: none below the wind that sustains them against viscosity, and a spectral level that never falls as the wind rises. published: the spectrum unmodified, whose level may rise as the wind falls.";
        GRAM_CHARLIER "gram_charlier", Kind::Flag, Flag(false), "Whether slope densities have the skewness and peakedness of Cox and Munk.";
        BRAGG "bragg", Choice(words::<BraggKind>), Means("\"travelling\"; \"frozen\" with phases = \"single\""), "Bragg waves within a facet: at rest on it, so that its Doppler is that of the resolved waves alone, or travelling: lines at plus and minus their frequency, weighted by the spectrum along and against the line of sight, as wide as the waves between facet and Bragg wave make them.";
        DRIFT_SHARE "drift_share", number("", 0.0, 0.1), default(0.03), "bragg = \"travelling\": ratio of the drift of the water's surface to the speed of the wind at 10 m; 0 for none.";
        DRIFT_DEG "drift_deg", number("deg", -180.0, 180.0), default(0.0), "bragg = \"travelling\": direction of the drift, counter-clockwise from that in which the wind blows; Ekman's is -45 in the northern hemisphere, 45 in the southern.";
        BREAKING "breaking", Choice(words::<Breaking>), Means("\"whitecaps\"; \"off\" with facet_m above 4 or a patch of more than 7 km^2"), "Breaking waves: none, or spikes on steep crests that cover as much of the sea as whitecaps do in this wind (Monahan and O'Muircheartaigh 1980) and run downwind for 0.1 to 1 s, a scatterer for each square metre.";
        MODULATION "modulation", Choice(words::<ModulationKind>), Word("relaxation"), "Whether long waves modulate the Bragg waves: all facets equally rough, or rougher where the surface contracts, by the relaxation-rate model; the sea then returns more upwind than downwind.";
        RELAXATION_PER_S "relaxation_per_s", number("1/s", 0.01, 1000.0), Means("the growth rate of the Bragg waves seen at 45 degrees (Plant 1982)"), "modulation = \"relaxation\": rate at which Bragg waves return to their equilibrium with the wind.";
        DECORRELATION_MS "decorrelation_ms", above("ms", 0.0, 1e9), Means("never; with bragg = \"travelling\" what the waves within a facet give"), "Time in which a facet forgets its random phase.";
        DISPLACEMENT "displacement", Kind::Flag, Flag(true), "Whether facets follow the horizontal orbital motion of the waves; false: they move up and down only.";
    }
    shadow "[sea.shadow]" "What waves hide from a transmitter or a receiver." {
        ENABLED "enabled", Kind::Flag, Flag(true), "Whether anything is hidden.";
        EDGE "edge", Choice(words::<ShadowEdge>), Word("soft"), "Whether visibility falls smoothly at the edge of a shadow, or at once as in the MaRS paper.";
        WIDTH_RAD "width_rad", above("rad", 0.0, 1000.0), Means("half the rms change of slope over a facet, from the map"), "soft: tangent of the angle above the shadow boundary (the line of sight that grazes the crests before the facet) over which a facet comes into full view.";
        RAYS_PER_FACET "rays_per_facet", count(1, 64), Count(2), "Rays per facet across the look direction.";
        UPDATE_MS "update_ms", number("ms", 0.1, 10_000.0), Means("the multiple of ten pulse intervals nearest to 20 ms, at least ten intervals"), "Time between updates; visibility is cross-faded in between.";
        TWO_RAYS "two_rays", Kind::Flag, Flag(false), "Whether the ray that the mean sea reflects onto a facet interferes with the straight one, so that the echo falls as the fourth power of the grazing angle below the critical one (docs/physics.md section 11.3). It counts below about a degree, in a standard atmosphere.";
    }
    far "[sea.far]" "The sea beyond the patch, to the horizon or the end of the window: cells with the statistics of facets (docs/far-sea.md)." {
        ENABLED "enabled", Kind::Flag, Flag(false), "Whether there is any; without it the sea ends with the patch.";
        CELLS "cells", count(1, 64), Count(4), "Cells in a resolution cell (a range cell by the narrower beam). Few make the echo spikier than speckle: its contrast exceeds 2 by 2/cells at least.";
        MOST_CELLS "most_cells", count(256, 1_048_576), Count(16_384), "Cells of a pulse, at most, as it is when a second begins; where there would be more, each stands for two, four ... times the area.";
        TEXTURE "texture", Kind::Flag, Flag(true), "Whether cells have waves in common, so that swell is seen as stripes that travel; false: each has waves of its own.";
    }
    swell "[[swell]]" "A swell train. Exactly one direction." {
        SIGNIFICANT_HEIGHT_M "significant_height_m", number("m", 0.0, 30.0), Required, "Significant wave height.";
        PEAK_PERIOD_S "peak_period_s", number("s", 1.0, 40.0), Required, "Peak period.";
        TOWARDS_DEG "towards_deg", number("deg", -360.0, 360.0), Means("from_deg is given"), "Direction in which it travels, counter-clockwise from East.";
        FROM_DEG "from_deg", number("deg", -360.0, 360.0), Means("towards_deg is given"), "Direction from which it comes, clockwise from North.";
        SPREAD_DEG "spread_deg", number("deg", 3.0, 80.0), default(10.0), "Directional spread, circular standard deviation.";
        SHAPE "shape", Choice(words::<SwellKind>), Word("gaussian"), "Shape in frequency.";
        RELATIVE_WIDTH "relative_width", number("", 0.01, 0.3), default(0.1), "gaussian: standard deviation over peak frequency.";
        PEAK_ENHANCEMENT "peak_enhancement", number("", 1.0, 50.0), Required, "jonswap: peak enhancement; swell has about 5 to 20.";
    }
    slick "[[slick]]" "A film on the water, at rest: an ellipse (centre_m, half_axes_m, direction_deg) or a polygon (corners_m)." {
        NAME "name", Name, Means("slick-<number>, counted from 0"), "Its name, unique among slicks.";
        CENTRE_M "centre_m", vector("m", 2, FAR_M), Means("corners_m is given"), "ellipse: centre, East and North.";
        HALF_AXES_M "half_axes_m", Kind::Numbers { unit: "m", least: 2, most: 2, min: 1e-3, max: FAR_M }, Required, "ellipse: half axes.";
        DIRECTION_DEG "direction_deg", number("deg", -360.0, 360.0), default(0.0), "ellipse: direction of the first axis, counter-clockwise from East.";
        CORNERS_M "corners_m", Kind::Points { unit: "m", least: 3, most: 1000, limit: FAR_M }, Means("centre_m is given"), "polygon: corners in turn, each [East, North].";
        RIM_M "rim_m", number("m", 0.0, 1e5), Means("one facet"), "Width over which the film thins out across its outline.";
        COVER "cover", number("", 0.0, 1.0), default(1.0), "Fraction of the water covered inside.";
        ELASTICITY_NPM "elasticity_npm", number("N/m", 0.0, 1.0), default(0.0255), "Dilational elasticity of the film; 0.0255 is oleyl alcohol.";
    }
    land "[land]" "Land on the patch, wherever a raster of heights rises above the sea: constant-gamma clutter at rest, which hides what lies behind it. With [sea] and an origin." {
        DEM "dem", File, Required, "GeoTIFF of heights that covers the patch: one band, north up, EPSG 4326, 4258, 4979 or UTM (326xx, 327xx, 258xx). Cells without data are sea.";
        SEA_LEVEL_M "sea_level_m", number("m", -1000.0, 9000.0), default(0.0), "Height of mean sea level in the raster's vertical datum.";
        TERRAIN "terrain", Choice(words::<Terrain>), Word("farmland"), "Kind of terrain, for its gamma at 10 GHz: -20, -15, -12, -10, -5, -5 dB; 5 dB more for ten times the frequency.";
        GAMMA_DB "gamma_db", number("dB", -60.0, 20.0), Means("that of terrain"), "Normalised cross section over the sine of the local grazing angle, VV.";
        HH_OVER_VV_DB "hh_over_vv_db", number("dB", -20.0, 20.0), default(0.0), "HH over VV.";
        CROSS_OVER_VV_DB "cross_over_vv_db", number("dB", -60.0, 0.0), default(-8.0), "HV and VH over VV.";
    }
}
