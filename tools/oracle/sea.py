"""The moving surface, the patch of facets on it, and what each facet returns.

    a(K) = sqrt(Psi_w(K)/2) dK xi(K);   E = a(K) exp(-j w t), F = conj(a(-K)) exp(+j w t), H = E + F
    z = sum_K H exp(j K.x), slopes j K H, dz/dt j w (F - E), D = j (K/|K|) H, u = (K/|K|) w (E - F)

Psi_w is twice the symmetrised spectrum where K goes with the wind, that spectrum square across it, nothing
against it. Facets are keyed by integers (ix, iy); a facet stands at (ix, iy) times its side, and its heights
repeat with the size of the patch. Waves at the Nyquist index and at 0 carry nothing.
"""

import math

import numpy as np

from . import scattering as sc
from .frames import C, Unfit, dot, unit
from .spectra import G, K_CAPILLARY, Spectrum, Wind, cardone_ustar
from .streams import FACET_PHASE, SEA_WAVE, uniform

# Clearances above the horizon beyond which the default weight of a shadow's soft edge is one for sure.
CLEAR_RAD = 0.15


class Surface:
    """One sea, periodic over nx by ny facets; fields are [nx, ny] by key modulo the size."""

    def __init__(self, nx, ny, facet_m, spectrum, wind_rad, seed, depth_m=math.inf, capillary=False):
        self.shape = nx, ny
        mx, my = np.meshgrid(np.fft.fftfreq(nx, 1 / nx), np.fft.fftfreq(ny, 1 / ny), indexing="ij")
        dkx, dky = 2 * np.pi / (nx * facet_m), 2 * np.pi / (ny * facet_m)
        self.kx, self.ky = mx * dkx, my * dky
        k = np.hypot(self.kx, self.ky)
        silent = (k == 0) | (2 * np.abs(mx) == nx) | (2 * np.abs(my) == ny)
        self.k = np.where(k == 0, 1.0, k)
        ku = self.kx * math.cos(wind_rad) + self.ky * math.sin(wind_rad)
        kc = self.ky * math.cos(wind_rad) - self.kx * math.sin(wind_rad)
        # Square across the wind is meant exactly: the cosine of 90 degrees is not left to its last digit.
        weight = 1 + np.sign(np.where(np.abs(ku) < 1e-12 * k, 0.0, ku))
        u1, u2 = uniform(seed, SEA_WAVE, mx.astype(np.int64), my.astype(np.int64), 2).reshape(2, nx, ny)
        xi = np.sqrt(-np.log1p(-u1)) * np.exp(2j * np.pi * u2)
        psi = np.where(silent, 0.0, weight * spectrum.psi(ku, kc))
        self.a = np.sqrt(psi / 2 * dkx * dky) * xi
        self.partner = np.roll(self.a[::-1, ::-1], 1, axis=(0, 1)).conj()  # conj(a(-K))
        w2 = G * self.k * np.tanh(self.k * depth_m)
        if capillary:
            w2 = w2 * (1 + (self.k / K_CAPILLARY) ** 2)
        self.w = np.sqrt(w2)

    def coefficients(self, t):
        """Fourier coefficients of every field at t."""
        turned = np.exp(-1j * np.mod(self.w * t, 2 * np.pi))
        e, f = self.a * turned, self.partner * turned.conj()
        ux, uy = self.kx / self.k, self.ky / self.k
        return {
            "z": e + f,
            "zx": 1j * self.kx * (e + f),
            "zy": 1j * self.ky * (e + f),
            "dx": 1j * ux * (e + f),
            "dy": 1j * uy * (e + f),
            "ux": ux * self.w * (e - f),
            "uy": uy * self.w * (e - f),
            "uz": 1j * self.w * (f - e),
        }

    def fields(self, t):
        nx, ny = self.shape
        return {name: nx * ny * np.fft.ifft2(h).real for name, h in self.coefficients(t).items()}


class Facets:
    """The facets of the patch at one emission, one a row."""

    def __init__(self, **columns):
        self.__dict__.update(columns)


SEA_KEYS = {
    "sea": "wind_ustar_mps wind_mps wind_height_m wind_profile wind_towards_deg wind_from_deg spectrum "
    "inverse_wave_age fetch_m capillary depth_m temperature_c salinity_psu permittivity averaging waves scattering shadow",
    "sea.scattering": "splitting phases cut_radpm tilt_average light_wind gram_charlier bragg drift_share drift_deg breaking modulation relaxation_per_s decorrelation_ms displacement",
    "sea.shadow": "enabled edge width_rad rays_per_facet update_ms",
}
SPECTRA = ("elfouhaily", "elfouhaily-fung-lee", "fung-lee")


def known(table, name):
    other = sorted(set(table) - set(SEA_KEYS[name].split()))
    if other:
        raise Unfit(f"{name}.{other[0]} cannot be judged")


def choice(table, key, default, allowed):
    value = table.get(key, default)
    if value not in allowed:
        raise Unfit(f'{key} = "{value}" cannot be judged')
    return value


def given(table, key):
    if key not in table:
        raise Unfit(f"a scenario without {key} cannot be judged")
    return table[key]


class Sea:
    """The sea of a scenario."""

    def __init__(self, config, scene, seed):
        for other in ("ship", "slick", "swell"):
            if config.get(other):
                raise Unfit(f"{other} cannot be judged")
        self.scene, self.seed = scene, seed
        place, sea = config["scene"], config["sea"]
        known(sea, "sea")
        if sea.get("waves", "linear") != "linear":
            raise Unfit("choppy waves cannot be judged")
        self._patch(config, place)
        self._water(sea)
        self._returns(sea.get("scattering", {}))
        self._shadow(sea.get("shadow", {}))

    def _patch(self, config, place):
        self.facet = given(place, "facet_m")
        sides = [size / self.facet for size in given(place, "patch_size_m")]
        self.n = [round(n) for n in sides]
        if max(abs(a - b) for a, b in zip(sides, self.n)) > 1e-9:
            raise Unfit("a patch that is not a whole number of facets cannot be judged")
        self.centre = place.get("patch_centre_m", [0.0, 0.0])
        self.aim = None
        if choice(place, "patch", "fixed", ("fixed", "follow")) == "follow":
            self.aim = place.get("patch_follow", config["receiver"][0].get("pointing", {"kind": "fixed"}))
            choice(self.aim, "kind", None, ("at", "point", "beside"))

    def _water(self, sea):
        choice(sea, "wind_profile", "cardone", ("cardone",))
        if "wind_ustar_mps" in sea:
            self.wind = Wind(sea["wind_ustar_mps"])
        else:
            self.wind = Wind(cardone_ustar(given(sea, "wind_mps"), sea.get("wind_height_m", 10.0)))
        if "wind_towards_deg" in sea:
            towards = sea["wind_towards_deg"]
        else:
            towards = 270.0 - given(sea, "wind_from_deg")
        self.towards = math.radians(towards)
        omega_c = sea.get("inverse_wave_age", 0.84)
        if "fetch_m" in sea:
            x = G / self.wind.u10**2 * sea["fetch_m"]
            omega_c = 0.84 * math.tanh((x / 2.2e4) ** 0.4) ** -0.75
        if not 0.84 <= omega_c <= 5:
            raise Unfit(f"an inverse wave age of {omega_c:.3g} cannot be judged")
        kind = choice(sea, "spectrum", "elfouhaily", SPECTRA)
        self.spectrum = Spectrum(kind, self.wind, omega_c)
        if (
            choice(sea, "averaging", "automatic", ("automatic", "points")) == "automatic"
            and not self.wind.calm
        ):
            # Near the limit the two sides may take the peak for different numbers.
            if self.spectrum.peak() * min(self.n) * self.facet / (2 * math.pi) < 7:
                raise Unfit('averages over cells cannot be judged: set averaging = "points"')
        self.surface = Surface(
            *self.n, self.facet, self.spectrum, self.towards, self.seed,
            sea.get("depth_m", math.inf), sea.get("capillary", False),
        )  # fmt: skip
        water = choice(sea, "permittivity", "meissner-wentz", ("meissner-wentz", "klein-swift"))
        fit = sc.meissner_wentz if water == "meissner-wentz" else sc.klein_swift
        self.eps = fit(self.scene.f0, sea.get("temperature_c", 20.0), sea.get("salinity_psu", 35.0))

    def _returns(self, table):
        known(table, "sea.scattering")
        single = table.get("phases", "polcoherent") == "single"
        if table.get("bragg", "frozen" if single else "travelling") != "frozen":
            raise Unfit('Bragg waves that travel cannot be judged: set bragg = "frozen"')
        if table.get("breaking", "off") != "off":
            raise Unfit("breaking waves cannot be judged")
        if table.get("modulation", "off") != "off":
            raise Unfit("modulated Bragg waves cannot be judged")
        if table.get("decorrelation_ms", False):
            raise Unfit("decorrelation_ms cannot be judged")
        self.splitting = choice(table, "splitting", "consistent", ("consistent", "mars2007"))
        if table.get("tilt_average", self.splitting == "consistent"):
            raise Unfit("an average over tilts cannot be judged: set tilt_average = false")
        if table.get("light_wind", "threshold") != "published":
            raise Unfit('Bragg waves in light wind cannot be judged: set light_wind = "published"')
        self.phases = choice(table, "phases", "polcoherent", ("polcoherent", "single"))
        self.displacement = table.get("displacement", True)
        self.wavenumber = 2 * math.pi * self.scene.f0 / C
        grid = math.pi / self.facet
        self.cut = table.get("cut_radpm", max(grid, self.wavenumber / 3))
        self.skewed_at_u12 = self.wind.u12 if table.get("gram_charlier", False) else None
        if self.splitting == "mars2007":
            self.slopes, self.roughness = sc.cox_munk(self.wind.u12), 0.0
            return
        if self.skewed_at_u12 is not None:
            raise Unfit("gram_charlier with the consistent splitting cannot be judged")
        self.slopes = [max(s, sc.SLOPE_FLOOR) for s in self.spectrum.slope_variances(grid, self.cut)]
        self.roughness = self.spectrum.height_variance(self.cut)

    def _shadow(self, table):
        known(table, "sea.shadow")
        self.shadows = table.get("enabled", True)
        self.clear = max(table.get("width_rad", 0.0), CLEAR_RAD)

    def first_key(self, t):
        centre = self.centre
        if self.aim:
            centre = self.scene.aim(self.aim, np.array([t]), "reported")[0]
        half_up = lambda x: math.copysign(math.floor(abs(x) + 0.5), x)
        return [int(half_up(c / self.facet)) - n // 2 for c, n in zip(centre, self.n)]

    def facets(self, t):
        """The patch at an emission: places at t, velocities, normals, areas, phases."""
        keys = [first + np.arange(n) for first, n in zip(self.first_key(t), self.n)]
        ix, iy = np.meshgrid(*keys, indexing="ij")
        at = ix % self.n[0], iy % self.n[1]
        f = {name: field[at] for name, field in self.surface.fields(t).items()}
        if not self.displacement:
            for name in ("dx", "dy", "ux", "uy"):
                f[name] = np.zeros_like(f[name])
        x, y = ix * self.facet, iy * self.facet
        z = f["z"] - (x**2 + y**2) / (2 * self.scene.radius)
        zx, zy = f["zx"] - x / self.scene.radius, f["zy"] - y / self.scene.radius
        stack = lambda *c: np.stack([a.ravel() for a in np.broadcast_arrays(*c)], -1)
        n = unit(stack(-zx, -zy, 1.0))
        downwind = np.array([math.cos(self.towards), math.sin(self.towards), 0.0])
        ex = unit(downwind - (n @ downwind)[:, None] * n)
        rise, run = np.abs(np.diff(z, axis=0)), np.abs(np.diff(z, axis=1))
        # Steepest of the chords that interpolation between facets can make.
        steep = np.hypot(np.maximum(rise[:, 1:], rise[:, :-1]), np.maximum(run[1:], run[:-1]))
        return Facets(
            place=stack(x + f["dx"], y + f["dy"], z),
            velocity=stack(f["ux"], f["uy"], f["uz"]),
            n=n,
            ex=ex,
            ey=np.cross(n, ex),
            area=self.facet**2 / n[:, 2],
            phasors=np.exp(2j * np.pi * uniform(self.seed, FACET_PHASE, ix, iy, 2)),
            steepest=float(np.max(steep, initial=0.0)) / self.facet,
        )

    def matrices(self, facets, ki, ks):
        """Scattering matrices, m; [n, 2, 2]."""
        self._check_shadow(facets, ki, ks)
        out = np.zeros((len(ki), 2, 2), complex)
        illuminated = np.flatnonzero((dot(ki, facets.n) < 0) & (dot(ks, facets.n) > 0))
        ki, ks = ki[illuminated], ks[illuminated]
        n, ex, ey = facets.n[illuminated], facets.ex[illuminated], facets.ey[illuminated]
        ku, kc = sc.bragg_vector(ki, ks, self.wavenumber, ex, ey)
        psi, kb = self.spectrum.psi(ku, kc), np.hypot(ku, kc)
        if self.splitting == "consistent":
            psi = psi * sc.taper(kb, self.cut)
        elif np.any(kb < 1.5 * self.cut):
            # The page has the full spectrum here, and a cut for every mode; beyond the cut both are one.
            raise Unfit("mars2007 with Bragg waves near the cut cannot be judged")
        bragg = sc.bragg(ki, ks, n, self.wavenumber, self.eps, psi)
        zu, zc, qn, there = sc.specular_slopes(ki, ks, n, ex, ey)
        density = np.where(there, sc.slope_density(zu, zc, *self.slopes, self.skewed_at_u12), 0.0)
        glint = sc.specular(ki, ks, qn, self.eps, density)
        cosine2 = dot(ks - ki, ks - ki) / 4
        glint *= np.exp(-2 * self.wavenumber**2 * cosine2 * self.roughness)[:, None, None]
        glint[np.abs(glint) < 1e-12] = 0.0
        size = np.sqrt(facets.area[illuminated])[:, None, None]
        phase0, phase1 = facets.phasors[:, illuminated, None, None]
        if self.phases == "single":
            out[illuminated] = size * np.sqrt(np.abs(bragg) ** 2 + np.abs(glint) ** 2) * phase0
        else:
            out[illuminated] = size * (bragg * phase1 + glint * phase0)
        return out

    def _check_shadow(self, facets, ki, ks):
        """Shadows are not computed: where they are on, none may fall."""
        if not self.shadows:
            return
        lowest = math.asin(min(np.min(-ki[:, 2]), np.min(ks[:, 2])))
        if lowest - math.atan(facets.steepest) < self.clear:
            raise Unfit("shadows cannot be judged, and some may fall: set sea.shadow.enabled = false")
