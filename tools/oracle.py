#!/usr/bin/env python3
"""Recomputes pulses of a noiseless recording from first principles and compares them with /iq.

    oracle.py RECORDING.h5 [--rows 0,7,19 | --count 4] [--limit-db -100] [--json]

Needs numpy and h5py, and nothing of nereus: what is computed here follows the printed equations, by
other means wherever there are any. The scenario comes from the attribute `config`; from the columns
come the true (and reported) states of the platforms and the start of each window. Nothing of /truth is used.

For every emission whose echo meets the window, transmitter, receiver and target:

    light time    tau1 = |x_s(t+tau1) - x_T(t)|/c,  tau2 = |x_R(t+tau1+tau2) - x_s(t+tau1)|/c
    amplitude     a = sqrt(P lambda^2/((4 pi)^3 L)) g_t g_r/(R_t R_r) (e_r . S e_t),  bases (v, h)
    direct path   a = sqrt(P lambda^2/((4 pi)^2 L)) g_t g_r/R (e_r . e_t)
    samples       s(t) = a exp(-j 2 pi f0 tau) q(t - t_m - tau)
                  q(t) = int_0^Tc p(u) exp(-j 2 pi f0 r u) h(t - u) du,  r = d tau/dt

h is the impulse response of the receive filter in closed form (1 up to 0.4 fs, raised cosine to 0 at
0.5 fs), so q is made in the time domain by Gauss-Legendre quadrature: no spectrum, no FFT, no period.

The transmit antenna is that of the instant of emission, the receive antenna that of the instant of
reception. Between pulses, positions are cubic Hermite on position and velocity, attitudes slerp.

Printed is 20 log10(||recorded - computed|| / ||computed||) by pulse and channel. Single precision of the
samples allows -150 dB; f64 phases of X band at 6 ms of delay allow -135 dB. Exit 0: all below the limit;
1: not; 2: the recording cannot be judged (noise, converter, file patterns or waveforms).
"""
import argparse
import json
import math
import sys
import tomllib

import numpy as np

C = 299_792_458.0
EARTH_RADIUS_M = 6_371_000.0
UP = np.array([0.0, 0.0, 1.0])
# The pulse radiates from 0 to Tc; the filter rings beyond. Echoes are computed when they come this
# near to the window.
GUARD_SAMPLES = 32


class Unfit(Exception):
    """The recording cannot be judged."""


def unit(x):
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def dot(a, b):
    return np.sum(a * b, axis=-1)


# ---------------------------------------------------------------- rotations


def rx(a):
    return np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])


def ry(a):
    return np.array([[math.cos(a), 0, math.sin(a)], [0, 1, 0], [-math.sin(a), 0, math.cos(a)]])


def rz(a):
    return np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])


def matrix(q):
    """Rotation matrix of a Hamilton quaternion, scalar first."""
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


# ---------------------------------------------------------------- where things are


class Track:
    """A recorded trajectory: rows of position, velocity, attitude at times in s after pulse 0."""

    def __init__(self, group, times):
        self.t = times
        self.p = group["position_m"][:]
        self.v = group["velocity_mps"][:]
        self.q = group["attitude_quat"][:]
        for k in range(1, len(self.q)):  # the same rotation, the nearer sign
            if dot(self.q[k], self.q[k - 1]) < 0:
                self.q[k:] *= -1

    def _row(self, t):
        return int(np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, max(len(self.t) - 2, 0)))

    def position(self, t):
        return self._motion(t)[0]

    def velocity(self, t):
        return self._motion(t)[1]

    def _motion(self, t):
        k = self._row(t)
        dt = t - self.t[k]
        if len(self.t) == 1:
            return self.p[k] + self.v[k] * dt, self.v[k]
        h = self.t[k + 1] - self.t[k]
        if not 0 <= dt <= h:  # outside the rows: constant acceleration
            a = (self.v[k + 1] - self.v[k]) / h
            if dt > h:
                k, dt = k + 1, dt - h
            return self.p[k] + self.v[k] * dt + a * dt * dt / 2, self.v[k] + a * dt
        # Hermite about the straight line through the nearer row, so that no digit of large coordinates is lost.
        d = self.p[k + 1] - self.p[k]
        c2 = (3 * d / h - 2 * self.v[k] - self.v[k + 1]) / h
        c3 = (self.v[k] + self.v[k + 1] - 2 * d / h) / (h * h)
        p = self.p[k] + dt * (self.v[k] + dt * (c2 + dt * c3))
        return p, self.v[k] + dt * (2 * c2 + dt * 3 * c3)

    def attitude(self, t):
        """Body to ENU."""
        if len(self.t) == 1:
            return matrix(self.q[0])
        k = self._row(t)
        s = (t - self.t[k]) / (self.t[k + 1] - self.t[k])
        a, b = self.q[k], self.q[k + 1]
        angle = math.atan2(np.linalg.norm(b - a * dot(a, b)), dot(a, b))
        if angle < 1e-12:
            return matrix(a + s * (b - a))
        return matrix((math.sin((1 - s) * angle) * a + math.sin(s * angle) * b) / math.sin(angle))


class Scene:
    """The scenario as meant, with the recorded tracks."""

    def __init__(self, config, tracks, meta):
        self.tracks = tracks
        scene = config["scene"]
        self.origin = None
        if "origin_lat_deg" in scene:
            self.origin = tuple(scene[f"origin_{k}"] for k in ("lat_deg", "lon_deg", "h_m"))
        curved = scene.get("earth", "curved" if self.origin else "flat") == "curved"
        self.radius = scene.get("earth_radius_factor", 1.0) * EARTH_RADIUS_M if curved else math.inf
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
            first_use = dict.fromkeys(c[-1][1] for c in meta["channels"])
            self.sequence = self.radar.get("tx_sequence", list(first_use))

    def emission(self, m):
        """Emission of pulse m, s after pulse 0."""
        if not self.pri:
            return m / self.radar["prf_hz"]
        return (m // len(self.pri)) * math.fsum(self.pri) + math.fsum(self.pri[: m % len(self.pri)])

    def on_sea(self, x, y, height=0.0):
        return np.array([x, y, height - (x * x + y * y) / (2 * self.radius)])

    def place(self, table):
        """A point given by position_m (third: height above the sea) or by latitude and longitude."""
        if "position_m" in table:
            return self.on_sea(*map(float, table["position_m"]))
        lat0, lon0, h0 = self.origin
        east, north, _ = enu(lat0, lon0, h0) @ (
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
        if table["kind"] == "at":
            return self.place(table) + np.array(table.get("velocity_mps", [0.0] * 3)) * t
        track = self.tracks[table["platform"]][which]
        x, y, _ = track.position(t)
        ahead = unit(track.velocity(t)[:2])
        starboard = np.array([ahead[1], -ahead[0]])
        x, y = np.array([x, y]) + table.get("along_m", 0.0) * ahead + table["across_m"] * starboard
        return self.on_sea(x, y)


def sphere(t):
    """HH and VV of a monostatic radar equal, in forward-scatter alignment and order v, h."""
    sigma = t["rcs_m2"] if "rcs_m2" in t else 10 ** (t["rcs_dbsm"] / 10)
    return np.diag([1, -1]) * math.sqrt(sigma)


def ecef(lat_deg, lon_deg, h):
    a, f = 6378137.0, 1 / 298.257223563
    e2 = f * (2 - f)
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    n = a / math.sqrt(1 - e2 * math.sin(lat) ** 2)
    r = (n + h) * math.cos(lat)
    return np.array([r * math.cos(lon), r * math.sin(lon), (n * (1 - e2) + h) * math.sin(lat)])


def enu(lat_deg, lon_deg, _h):
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    sa, ca, so, co = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
    return np.array([[-so, co, 0], [-sa * co, -sa * so, ca], [ca * co, ca * so, sa]])


# ---------------------------------------------------------------- antennas


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
        return track.position(t) + track.attitude(t) @ self.arm

    def axes(self, t):
        """Antenna to ENU: columns boresight, horizontal, vertical."""
        p = self.pointing
        attitude = self.tracks["true"].attitude(t)
        if p["kind"] == "fixed":
            yaw, pitch, roll = (math.radians(p.get(k, 0.0)) for k in ("yaw_deg", "pitch_deg", "roll_deg"))
            return attitude @ rz(yaw) @ ry(pitch) @ rx(roll)
        # The servo turns the antenna in the body to where it should be by what it knew a lag ago.
        which, known = p.get("aim_from", "reported"), t - p.get("lag_s", 0.0)
        body = self.tracks[which].attitude(known)
        x = unit(self.scene.aim(p, known, which) - self.centre(known, which))
        y = np.cross(UP, x)
        if np.linalg.norm(y) < 1e-6:
            y = np.cross(body[:, 0], x)
        y = unit(y)
        command = body.T @ np.column_stack([x, y, np.cross(x, y)])
        bias = rz(math.radians(p.get("bias_az_deg", 0.0))) @ ry(math.radians(p.get("bias_el_deg", 0.0)))
        return attitude @ command @ bias

    def gain(self, d, axes, wavelength):
        """Field gain towards unit vectors d; signed."""
        kind = self.pattern["kind"]
        if kind == "isotropic":
            return np.full(len(d), 10 ** (self.pattern.get("gain_dbi", 0.0) / 20))
        x, u, v = d @ axes[:, 0], d @ axes[:, 1], d @ axes[:, 2]
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

    def field(self, polarisation, k, axes):
        """Unit field radiated along unit vectors k from a port: complex ENU vectors."""
        y, z = axes[:, 1], axes[:, 2]
        s = math.sqrt(0.5)
        port = {"H": y + 0j, "V": z + 0j, "R": s * (y - 1j * z), "L": s * (y + 1j * z)}
        e = port[polarisation] + self.leak * port[{"H": "V", "V": "H", "R": "L", "L": "R"}[polarisation]]
        e = e - dot(e, k)[:, None] * k
        return e / np.sqrt(dot(e, e.conj()).real)[:, None]


def jinc(x):
    """2 J1(x)/x by Bessel's integral: the trapezoid rule over a period is exact here."""
    n = int(np.max(np.abs(x), initial=0.0)) + 64
    theta = 2 * np.pi * np.arange(n) / n
    j1 = np.mean(np.cos(theta - np.multiply.outer(x, np.sin(theta))), axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(np.abs(x) < 1e-6, 1.0, 2 * j1 / x)


def basis(k):
    """v and h of a propagation direction."""
    h = np.cross(UP, k)
    norm = np.linalg.norm(h, axis=-1, keepdims=True)
    h = np.where(norm < 1e-12, np.array([0.0, 1.0, 0.0]), h / np.where(norm < 1e-12, 1.0, norm))
    return np.cross(h, k), h


# ---------------------------------------------------------------- echoes


def light_time(scene, tx, rx, t):
    """Both legs from an emission at t, to every target."""
    start = tx.centre(t)
    where = lambda s: scene.positions + scene.velocities * s[:, None]
    tau1 = np.zeros(len(scene.positions))
    for _ in range(20):
        tau1 = np.linalg.norm(where(t + tau1) - start, axis=-1) / C
    x = where(t + tau1)
    tau2 = np.zeros_like(tau1)
    for _ in range(20):
        centres = np.array([rx.centre(s) for s in t + tau1 + tau2]).reshape(-1, 3)
        tau2 = np.linalg.norm(centres - x, axis=-1) / C
    return tau1, tau2


def direct_time(tx, rx, t):
    start, tau = tx.centre(t), 0.0
    for _ in range(20):
        tau = np.linalg.norm(rx.centre(t + tau) - start) / C
    return tau


def rate(tau, t, step=1e-3):
    """d tau/dt by a central difference of the light time, fourth order."""
    f = {k: tau(t + k * step) for k in (-2, -1, 1, 2)}
    return (8 * (f[1] - f[-1]) - (f[2] - f[-2])) / (12 * step)


class Echoes:
    """Of one pair and one emission: delay, its rate, and the amplitude in each channel of the pair."""

    def __init__(self, scene, tx_name, rx_name, t, polarisations):
        tx, rx = scene.antennas[tx_name], scene.antennas[rx_name]
        wavelength = C / scene.f0
        power = tx.table["power_w"] * 10 ** (-scene.radar.get("losses_db", 0.0) / 10)
        per_metre = 10 ** (-scene.radar.get("atmosphere_db_per_km", 0.0) / 20e3)
        total = lambda s: np.add(*light_time(scene, tx, rx, s))
        tau1, tau2 = light_time(scene, tx, rx, t)
        tau = tau1 + tau2
        r = rate(total, t)
        bounce = scene.positions + scene.velocities * (t + tau1)[:, None]
        ki, rt = split(bounce - tx.centre(t))
        ks, rr = split(np.array([rx.centre(s) for s in t + tau]).reshape(-1, 3) - bounce)
        t_axes = tx.axes(t)
        r_axes = [rx.axes(s) for s in t + tau]
        one = lambda f: np.concatenate([f(n, slice(n, n + 1)) for n in range(len(tau))]) if len(tau) else tau
        gt = tx.gain(ki, t_axes, wavelength)
        gr = one(lambda n, s: rx.gain(-ks[s], r_axes[n], wavelength))
        scale = math.sqrt(power * wavelength**2 / (4 * math.pi) ** 3)
        scale = scale * gt * gr / (rt * rr) * per_metre ** (rt + rr)
        (vi, hi), (vs, hs) = basis(ki), basis(ks)
        amplitudes = []
        for receive, transmit in polarisations:
            e = tx.field(transmit, ki, t_axes)
            et = np.stack([dot(vi, e), dot(hi, e)], -1)
            e = one(lambda n, s: rx.field(receive, -ks[s], r_axes[n])).reshape(-1, 3)
            er = np.stack([dot(vs, e), dot(hs, e)], -1)
            amplitudes.append(scale * np.einsum("np,npq,nq->n", er, scene.matrices, et))
        if scene.radar.get("direct_path", False) and np.any(tx.centre(t) != rx.centre(t)):
            tau_d = direct_time(tx, rx, t)
            k, distance = split((rx.centre(t + tau_d) - tx.centre(t))[None])
            axes = rx.axes(t + tau_d)
            g = tx.gain(k, t_axes, wavelength) * rx.gain(-k, axes, wavelength)
            a = math.sqrt(power) * wavelength / (4 * math.pi) * g / distance * per_metre**distance
            for c, (receive, transmit) in enumerate(polarisations):
                match = dot(rx.field(receive, -k, axes), tx.field(transmit, k, t_axes))
                amplitudes[c] = np.append(amplitudes[c], a * match)
            tau = np.append(tau, tau_d)
            r = np.append(r, rate(lambda s: direct_time(tx, rx, s), t))
        self.tau, self.rate = tau, r
        self.amplitudes = np.array(amplitudes) * np.exp(-2j * np.pi * np.mod(scene.f0 * tau, 1.0))


def split(x):
    length = np.linalg.norm(x, axis=-1)
    return x / length[:, None], length


def impulse_response(x):
    """h/fs at x = t fs of the receive filter: a raised cosine of 0.9 fs and roll-off 1/9."""
    z = (0.2 * x) ** 2
    pole = np.abs(1 - z) < 1e-7
    shape = np.cos(0.1 * np.pi * x) / np.where(pole, 1.0, 1 - z)
    # At z = 1 both vanish: cos(pi sqrt(z)/2)/(1 - z) -> pi/4.
    return 0.9 * np.sinc(0.9 * x) * np.where(pole, np.pi / 4, shape)


def received_pulse(scene, x0, samples, r):
    """q at the samples x0, x0 + 1, ... (in units of 1/fs after the arrival)."""
    f_max = scene.bandwidth / 2 + scene.fs / 2 + abs(scene.f0 * r)
    panels = max(1, math.ceil(f_max * scene.pulse_s / 4))  # 4 turns to 32 nodes: exact to 1e-15
    node, weight = np.polynomial.legendre.leggauss(32)
    edge = np.linspace(0.0, scene.pulse_s, panels + 1)
    half = np.diff(edge) / 2
    u = (edge[:-1, None] + half[:, None] * (1 + node)).ravel()
    w = (half[:, None] * weight).ravel() * scene.fs
    p = w * np.exp(1j * np.pi * scene.mu * (u - scene.pulse_s / 2) ** 2 - 2j * np.pi * scene.f0 * r * u)
    out = np.empty(samples, complex)
    rows = max(1, 4_000_000 // len(u))
    for a in range(0, samples, rows):
        x = x0 + np.arange(a, min(a + rows, samples))
        out[a : a + rows] = impulse_response(x[:, None] - (u * scene.fs)[None, :]) @ p
    return out


def pulse(scene, channels, index, window_start, samples):
    """The samples of a pulse, [channel, sample], and how many echoes met its window."""
    t = scene.emission(index)
    opens = window_start
    closes = window_start + samples / scene.fs
    out = np.zeros((len(channels), samples), complex)
    met = 0
    guard = GUARD_SAMPLES / scene.fs
    for pair in dict.fromkeys((c[0], c[1]) for c in channels):
        rows = [c for c, channel in enumerate(channels) if (channel[0], channel[1]) == pair]
        # Emissions that may be in the window: those of the last `reach` seconds before it closes.
        tx, rx = (scene.antennas[name] for name in pair)
        reach = 0.0
        if len(scene.positions):
            reach = float(np.max(np.add(*light_time(scene, tx, rx, t))))
        reach = 1.01 * reach + 1e-5 + scene.pulse_s + guard
        m = index
        while scene.emission(m + 1) - t < closes + guard and scene.emission(m + 1) < scene.duration:
            m += 1
        while m >= 0 and scene.emission(m) - t > opens - reach:
            shift = t - scene.emission(m)
            echoes = Echoes(scene, *pair, scene.emission(m), [channels[c][2] for c in rows])
            for n, tau in enumerate(echoes.tau):
                arrival = tau - shift  # after the emission of `index`
                if arrival > closes + guard or arrival + scene.pulse_s < opens - guard:
                    continue
                met += 1
                q = received_pulse(scene, (opens - arrival) * scene.fs, samples, echoes.rate[n])
                for a, c in zip(echoes.amplitudes[:, n], rows):
                    sent = scene.sequence[m % len(scene.sequence)] if scene.sequence else None
                    if sent in (None, channels[c][2][1]):
                        out[c] += a * q
            m -= 1
    return out, met


# ---------------------------------------------------------------- comparing


def decibels(x):
    return 20 * math.log10(x) if x > 0 else -math.inf


def judge(path, rows=None, count=4):
    """Relative errors in dB by row and channel, and what else was noticed."""
    import h5py

    with h5py.File(path, "r") as file:
        config = tomllib.loads(file.attrs["config"])
        text = lambda x: x.decode() if isinstance(x, bytes) else x
        channels = [
            (text(c["transmitter"]), text(c["receiver"]), text(c["polarisations"])) for c in file["channel"][:]
        ]
        index = file["pulse/index"][:]
        start = int(file.attrs["start_time_ns"]), float(file.attrs["start_time_frac_ns"])
        times = (file["pulse/time_ns"][:] - start[0]) * 1e-9
        times = times + (file["pulse/time_frac_ns"][:] - start[1]) * 1e-9
        tracks = {
            p["name"]: {k: Track(file[f"nav/{p['name']}/{k}"], times) for k in ("true", "reported")}
            for p in config["platform"]
        }
        scene = Scene(config, tracks, {"channels": channels})
        n = len(index)
        if n == 0:
            raise Unfit("the recording holds no pulse")
        if rows is None:
            rows = sorted({round(k * (n - 1) / max(count - 1, 1)) for k in range(count)})
        # What the recording says about itself: emission times and phase centres.
        clock = max(abs(times[k] - scene.emission(int(index[k]))) for k in range(n))
        arms = max(
            np.linalg.norm(a.centre(times[k]) - file[f"nav/{name}/phase_centre_m"][k])
            for name, a in scene.antennas.items()
            for k in rows
        )
        samples = file["iq"].shape[2]
        result = []
        for k in rows:
            want, met = pulse(scene, channels, int(index[k]), float(file["pulse/window_start_s"][k]), samples)
            got = file["iq"][k].astype(complex)
            error, level = np.linalg.norm(got - want, axis=-1), np.linalg.norm(want, axis=-1)
            db = [decibels(e / s) if s > 0 else (-math.inf if e == 0 else math.inf) for e, s in zip(error, level)]
            result.append({"pulse": int(index[k]), "echoes": met, "error_db": db, "rms": list(level)})
        names = [text(c) for c in file["channel"]["name"]]
    return {
        "path": str(path),
        "channels": names,
        "worst_db": max(d for r in result for d in r["error_db"]),
        "clock_s": float(clock),
        "phase_centre_m": float(arms),
        "pulses": result,
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("recording")
    parser.add_argument("--rows", type=lambda s: [int(k) for k in s.split(",")], help="rows, e.g. 0,7,19")
    parser.add_argument("--count", type=int, default=4, help="otherwise so many, evenly spread")
    parser.add_argument("--limit-db", type=float, default=-100.0)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    try:
        found = judge(args.recording, args.rows, args.count)
    except (Unfit, OSError) as error:
        print(f"oracle.py: {args.recording}: {error}", file=sys.stderr)
        return 2
    # Emission times may be rounded to a femtosecond or so; phase centres to f64 of their coordinates.
    sound = found["worst_db"] <= args.limit_db and found["clock_s"] < 1e-12 and found["phase_centre_m"] < 1e-8
    if args.json:
        print(json.dumps(found | {"limit_db": args.limit_db, "sound": sound}))
        return 0 if sound else 1
    print(f"{args.recording}: relative rms, dB")
    print("  pulse  echoes  " + "  ".join(f"{c:>8}" for c in found["channels"]))
    for r in found["pulses"]:
        print(f"{r['pulse']:7}  {r['echoes']:6}  " + "  ".join(f"{d:8.1f}" for d in r["error_db"]))
    print(f"  emission times {found['clock_s']:.1e} s, phase centres {found['phase_centre_m']:.1e} m apart")
    print(f"  worst {found['worst_db']:.1f} dB, limit {args.limit_db:g} dB: {'sound' if sound else 'NOT SOUND'}")
    return 0 if sound else 1


if __name__ == "__main__":
    sys.exit(main())
