"""The scenario as meant: tracks, antennas, targets. Times are arrays of s after the emission of pulse 0."""

import math

import numpy as np

from .frames import C, EARTH_RADIUS_M, UP, Unfit, dot, ecef, enu, local_up, matrix, rx, ry, rz, turn, unit


class Track:
    """A recorded trajectory: rows of position, velocity, attitude at times in s after pulse 0."""

    def __init__(self, times, position_m, velocity_mps, attitude_quat):
        self.t = times
        self.p, self.v, self.q = position_m, velocity_mps, np.array(attitude_quat)
        for k in range(1, len(self.q)):  # the same rotation, the nearer sign
            if dot(self.q[k], self.q[k - 1]) < 0:
                self.q[k:] *= -1

    def _row(self, t):
        return np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, max(len(self.t) - 2, 0))

    def position(self, t):
        return self._motion(t)[0]

    def velocity(self, t):
        return self._motion(t)[1]

    def _motion(self, t):
        k = self._row(t)
        dt = (t - self.t[k])[:, None]
        if len(self.t) == 1:
            return self.p[k] + self.v[k] * dt, self.v[k]
        h = (self.t[k + 1] - self.t[k])[:, None]
        # Hermite about the straight line through the nearer row, so that no digit of large coordinates is lost.
        d = self.p[k + 1] - self.p[k]
        c2 = (3 * d / h - 2 * self.v[k] - self.v[k + 1]) / h
        c3 = (self.v[k] + self.v[k + 1] - 2 * d / h) / (h * h)
        p = self.p[k] + dt * (self.v[k] + dt * (c2 + dt * c3))
        v = self.v[k] + dt * (2 * c2 + dt * 3 * c3)
        # Outside the rows: constant acceleration from the nearer end.
        beyond = dt > h
        a = (self.v[k + 1] - self.v[k]) / h
        end = np.where(beyond[:, 0], k + 1, k)
        s = np.where(beyond, dt - h, dt)
        outside = beyond | (dt < 0)
        p = np.where(outside, self.p[end] + self.v[end] * s + a * s * s / 2, p)
        return p, np.where(outside, self.v[end] + a * s, v)

    def attitude(self, t):
        """Body to ENU."""
        k = self._row(t)
        if len(self.t) == 1:
            return matrix(self.q[k])
        s = ((t - self.t[k]) / (self.t[k + 1] - self.t[k]))[:, None]
        a, b = self.q[k], self.q[k + 1]
        cosine = dot(a, b)[:, None]
        angle = np.arctan2(np.linalg.norm(b - a * cosine, axis=-1, keepdims=True), cosine)
        small = angle < 1e-12
        sine = np.where(small, 1.0, np.sin(angle))
        slerp = (np.sin((1 - s) * angle) * a + np.sin(s * angle) * b) / sine
        return matrix(np.where(small, a + s * (b - a), slerp))


class Scene:
    """The scenario as meant, with the recorded tracks."""

    def __init__(self, config, tracks, channels):
        self.tracks = tracks
        scene = config["scene"]
        self.origin = None
        if "origin_lat_deg" in scene:
            self.origin = tuple(scene[f"origin_{k}"] for k in ("lat_deg", "lon_deg", "h_m"))
        curved = scene.get("earth", "curved" if self.origin else "flat") == "curved"
        self.radius = scene.get("earth_radius_factor", 1.0) * EARTH_RADIUS_M if curved else math.inf
        self.hides = curved and scene.get("horizon", True)
        self.radar = config["radar"]
        self.f0 = self.radar["carrier_hz"]
        self.fs = self.radar["sample_rate_hz"]
        self.duration = scene["duration_s"]
        self.antennas = {}
        for end in ("transmitter", "receiver"):
            for a in config[end]:
                self.antennas[a["name"]] = Antenna(a, self)
        self.positions, self.velocities, self.matrices = self._targets(config)
        w = self.radar["waveform"]
        if w["kind"] != "lfm":
            raise Unfit("waveforms from files are not recomputed")
        self.bandwidth, self.pulse_s = w["bandwidth_hz"], w["pulse_s"]
        self.mu = self.bandwidth / self.pulse_s * (-1 if w.get("sweep", "up") == "down" else 1)
        if "noise_figure_db" in self.radar or "adc" in self.radar:
            raise Unfit("the recording has noise or a converter: take noise_figure_db and adc out")
        self.pri = [us * 1e-6 for us in self.radar.get("pri_us", [])]
        self.sequence = None
        if self.radar.get("tx_polarisation") == "alternating":
            first_use = dict.fromkeys(c[-1][1] for c in channels)
            self.sequence = self.radar.get("tx_sequence", list(first_use))

    def emission(self, m):
        """Emission of pulse m, s after pulse 0."""
        if not self.pri:
            return m / self.radar["prf_hz"]
        return (m // len(self.pri)) * math.fsum(self.pri) + math.fsum(self.pri[: m % len(self.pri)])

    def judge_horizon(self, a, b):
        """Refuses what the curve of the earth hides: points that see each other over d <= D_a + D_b alone."""
        if not self.hides:
            return
        depth = lambda p: (p[..., 0] ** 2 + p[..., 1] ** 2) / (2 * self.radius)
        reach = lambda p: np.sqrt(2 * self.radius * np.maximum(p[..., 2] + depth(p), 0.0))
        apart = np.hypot(a[..., 0] - b[..., 0], a[..., 1] - b[..., 1])
        if np.any(apart > reach(a) + reach(b)):
            raise Unfit("some of it lies beyond the horizon: how the earth hides it is not recomputed")

    def on_sea(self, x, y, height=0.0):
        return np.stack([x, y, height - (x * x + y * y) / (2 * self.radius)], -1)

    def place(self, table):
        """A point given by position_m (third: height above the sea) or by latitude and longitude."""
        if "position_m" in table:
            return self.on_sea(*map(float, table["position_m"]))
        lat0, lon0, h0 = self.origin
        east, north, _ = enu(lat0, lon0) @ (
            ecef(table["lat_deg"], table["lon_deg"], h0) - ecef(lat0, lon0, h0)
        )
        return self.on_sea(east, north, table.get("height_m", 0.0))

    def _targets(self, config):
        positions, velocities, matrices = [], [], []
        for t in config.get("target", []):
            if any(k.startswith("s_") for k in t):
                s = np.array([[complex(*t.get(f"s_{p}{q}", (0, 0))) for q in "vh"] for p in "vh"])
                if t.get("convention", "fsa") == "bsa":
                    s = np.diag([1, -1]) @ s
            else:
                s = sphere(t)
            positions.append(self.place(t))
            velocities.append(t.get("velocity_mps", [0.0] * 3))
            matrices.append(s)
        for g in config.get("target_grid", []):
            # The sea curves under the grid: every target stands on it by itself.
            centre = self.place(g)
            height = g["position_m"][2] if "position_m" in g else g.get("height_m", 0.0)
            (nx, ny), (dx, dy) = g["count"], g["spacing_m"]
            for i in range(int(nx)):
                for j in range(int(ny)):
                    x, y = centre[0] + (i - (nx - 1) / 2) * dx, centre[1] + (j - (ny - 1) / 2) * dy
                    positions.append(self.on_sea(x, y, height))
                    velocities.append(g.get("velocity_mps", [0.0] * 3))
                    matrices.append(sphere(g))
        n = len(positions)
        return (
            np.array(positions, float).reshape(n, 3),
            np.array(velocities, float).reshape(n, 3),
            np.array(matrices, complex).reshape(n, 2, 2),
        )

    def aim(self, table, t, which):
        """Where a servo, a receive window or a patch is drawn to."""
        if table["kind"] in ("at", "point"):
            return self.place(table) + np.array(table.get("velocity_mps", [0.0] * 3)) * t[:, None]
        track = self.tracks[table["platform"]][which]
        ahead = unit(track.velocity(t)[:, :2])
        starboard = np.stack([ahead[:, 1], -ahead[:, 0]], -1)
        beside = table.get("along_m", 0.0) * ahead + table.get("across_m", 0.0) * starboard
        x, y = (track.position(t)[:, :2] + beside).T
        return self.on_sea(x, y)


def sphere(t):
    """HH and VV of a monostatic radar equal, in forward-scatter alignment and order v, h."""
    sigma = t["rcs_m2"] if "rcs_m2" in t else 10 ** (t["rcs_dbsm"] / 10)
    return np.diag([1, -1]) * math.sqrt(sigma)


class Antenna:
    def __init__(self, table, scene):
        self.scene = scene
        self.table = table
        self.tracks = scene.tracks[table["platform"]]
        self.arm = np.array(table.get("lever_arm_m", [0.0] * 3), float)
        self.pattern = table["antenna"]
        if self.pattern["kind"] == "file":
            raise Unfit("patterns from files are not recomputed")
        self.pointing = table.get("pointing", {"kind": "fixed"})
        isolation = table.get("cross_pol_isolation_db")
        self.leak = 0.0 if isolation is None else 10 ** (-isolation / 20)

    def centre(self, t, which="true"):
        track = self.tracks[which]
        return track.position(t) + turn(track.attitude(t), self.arm)

    def axes(self, t):
        """Antenna to ENU: columns boresight, horizontal, vertical."""
        p = self.pointing
        attitude = self.tracks["true"].attitude(t)
        if p["kind"] == "fixed":
            yaw, pitch, roll = (math.radians(p.get(k, 0.0)) for k in ("yaw_deg", "pitch_deg", "roll_deg"))
            # A level mount has its vertical axis up, as a servo has; the body's points down.
            return attitude @ (rz(yaw) @ ry(pitch) @ rx(roll) @ np.diag([1, -1, -1]))
        # The servo turns the antenna in the body to where it should be by what it knew a lag ago.
        which, known = p.get("aim_from", "reported"), t - p.get("lag_s", 0.0)
        body = self.tracks[which].attitude(known)
        x = unit(self.scene.aim(p, known, which) - self.centre(known, which))
        y = np.cross(UP, x)
        overhead = np.linalg.norm(y, axis=-1, keepdims=True) < 1e-6
        y = unit(np.where(overhead, np.cross(body[:, :, 0], x), y))
        command = body.swapaxes(1, 2) @ np.stack([x, y, np.cross(x, y)], -1)
        # Azimuth towards +y_a, then elevation towards +z_a.
        bias = rz(math.radians(p.get("bias_az_deg", 0.0))) @ ry(-math.radians(p.get("bias_el_deg", 0.0)))
        return attitude @ command @ bias

    def gain(self, d, axes, wavelength):
        """Field gain towards unit vectors d; signed."""
        kind = self.pattern["kind"]
        if kind == "isotropic":
            return np.full(len(d), 10 ** (self.pattern.get("gain_dbi", 0.0) / 20))
        x, u, v = turn(axes.swapaxes(1, 2), d).T
        if kind == "circle":
            a = b = self.pattern["diameter_m"]
        else:
            a, b = self.pattern["width_m"], self.pattern["height_m"]
        if kind == "rectangle":
            g = math.sqrt(4 * math.pi * a * b) / wavelength
            g = g * np.sinc(a * u / wavelength) * np.sinc(b * v / wavelength)
        else:
            g = math.sqrt(math.pi * math.pi * a * b) / wavelength
            g = g * jinc(math.pi / wavelength * np.hypot(a * u, b * v))
        return np.where(x > 0, g, 0.0)

    def basis(self, k, axes, centre):
        """Vectors of H and V across unit vectors k from the antenna, whose phase centre is at `centre`."""
        if self.pattern["kind"] == "isotropic":
            up = local_up(centre, self.scene.radius)
            # H lies level, to the left as seen along k; V points upward.
            h = unit(np.cross(up, k))
            return h, np.cross(k, h)
        # Ludwig's third definition, with theta from the boresight and phi from y about it.
        x, u, v = turn(axes.swapaxes(1, 2), k).T
        theta, phi = np.arctan2(np.hypot(u, v), x), np.arctan2(v, u)
        ct, st, cp, sp = np.cos(theta), np.sin(theta), np.cos(phi), np.sin(phi)
        of_theta = np.stack([-st, ct * cp, ct * sp], -1)
        of_phi = np.stack([np.zeros_like(phi), -sp, cp], -1)
        h = cp[:, None] * of_theta - sp[:, None] * of_phi
        v = sp[:, None] * of_theta + cp[:, None] * of_phi
        return turn(axes, h), turn(axes, v)

    def field(self, polarisation, k, axes, centre):
        """Unit field radiated along unit vectors k from a port: complex ENU vectors."""
        h, v = self.basis(k, axes, centre)
        s = math.sqrt(0.5)
        port = {"H": h + 0j, "V": v + 0j, "R": s * (h - 1j * v), "L": s * (h + 1j * v)}
        e = port[polarisation] + self.leak * port[{"H": "V", "V": "H", "R": "L", "L": "R"}[polarisation]]
        return e / np.sqrt(dot(e, e.conj()).real)[:, None]


def jinc(x):
    """2 J1(x)/x by Bessel's integral: the trapezoid rule over a period is exact here."""
    n = int(np.max(np.abs(x), initial=0.0)) + 64
    theta = 2 * np.pi * np.arange(n) / n
    j1 = np.zeros(len(x))
    for angle in theta:
        j1 += np.cos(angle - x * math.sin(angle)) / n
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(np.abs(x) < 1e-6, 1.0, 2 * j1 / x)
