#!/usr/bin/env python3
"""An independent processor: focuses a recording of nereus in numpy and compares with what `nereus focus` made.

    focus_numpy.py RECORDING.h5 [--image IMAGE.h5] [--channel NAME] [--limit-db -50] [--json]

Reads only the HDF5 recording: samples, replica, emission times, window starts, and phase centres (or reported states and the lever
arms of the scenario text). With --image it takes grid, pulses, tapers and navigation from the attributes of that image, focuses the
same pixels, and prints the difference: rms of the difference over rms of this program's own image. It shares no code with nereus.

    I(x) = sum_m w_m C_m(tau_m) exp(+j 2 pi f0 tau_m) / sum_m w_m,    tau_m for a wave that leaves at t_m + Tc/2

C_m: correlation with the replica, turned by the Doppler of the image's middle, eight cells a sample, cubic between cells. Exit 1 when
the limit is not kept, an image is no number or nothing was compared. Needs numpy and h5py.
"""
import argparse
import json
import sys
import time
import tomllib

import numpy as np

C = 299_792_458.0
CELLS = 8
POLARISATIONS = {"H": 1, "V": 2, "R": 3, "L": 4}


class Path:
    """Phase centre over time: barycentric cubic through four neighbours; beyond the end through four points a few pulses apart."""

    def __init__(self, times, points):
        self.times, self.points = times, points

    def at(self, t):
        n = len(self.times)
        k = int(np.searchsorted(self.times, t))
        rows = np.arange(n) if n <= 4 else np.clip(k - 2, 0, n - 4) + np.arange(4)
        if n > 4 and (t > self.times[-1] or t < self.times[0]):
            gap = max(t - self.times[-1], self.times[0] - t)
            step = min(max(1, int(np.ceil(gap * (n - 1) / (self.times[-1] - self.times[0])))), (n - 1) // 3)
            rows = n - 1 - step * np.arange(4) if t > self.times[-1] else step * np.arange(4)
        x = self.times[rows]
        if np.any(x == t):
            return self.points[rows[x == t][0]]
        middle = self.points[rows[0]]
        weights = np.array([1.0 / np.prod(x[i] - np.delete(x, i)) for i in range(len(x))]) / (t - x)
        return middle + weights @ (self.points[rows] - middle) / weights.sum()

    def speed(self, t, h=1e-3):
        return (self.at(t + h) - self.at(t - h)) / (2 * h)


def rotate(quaternion, vector):
    """Vector turned by quaternions [n, 4], scalar first."""
    w, v = quaternion[:, :1], quaternion[:, 1:]
    cross = np.cross(v, vector)
    return vector + 2 * (w * cross + np.cross(v, cross))


class Recording:
    def __init__(self, path):
        import h5py

        try:
            self.file = h5py.File(path, "r")
        except OSError:
            self.file = h5py.File(path, "r", swmr=True)
        f = self.file
        self.n = len(f["pulse/index"])
        self.index = f["pulse/index"][: self.n]
        ns = f["pulse/time_ns"][: self.n]
        self.times = ((ns - ns[0]).astype(float) + f["pulse/time_frac_ns"][: self.n]) * 1e-9
        self.window_start = f["pulse/window_start_s"][: self.n]
        self.tx_pol = f["pulse/tx_pol"][: self.n]
        self.channels = [[field.decode() for field in row] for row in f["channel"][:]]
        self.f0, self.fs = float(f.attrs["carrier_hz"]), float(f.attrs["sample_rate_hz"])
        self.band, self.tc = float(f.attrs["bandwidth_hz"]), float(f.attrs["pulse_s"])
        self.replica = f["replica"][:].astype(complex)

    def samples(self, row, channel):
        iq = self.file["iq"][row, channel]
        if iq.dtype.names:
            step = self.file["iq"].attrs["adc_step"]
            return (iq["r"] + 0.5) * step + 1j * (iq["i"] + 0.5) * step
        return iq.astype(complex)

    def path(self, kind, antenna, nav):
        if nav == "true":
            return Path(self.times, self.file[f"nav/{antenna}/phase_centre_m"][: self.n])
        scenario = tomllib.loads(self.file.attrs["config"])
        mount = next(a for a in scenario[kind] if a["name"] == antenna)
        base = f"nav/{mount['platform']}/reported/"
        arm = np.array(mount.get("lever_arm_m", [0, 0, 0]), float)
        turned = rotate(self.file[base + "attitude_quat"][: self.n], arm)
        return Path(self.times, self.file[base + "position_m"][: self.n] + turned)

    def boresight(self, antenna, row):
        return rotate(self.file[f"nav/{antenna}/boresight_quat"][row][None], np.array([1.0, 0, 0]))[0]


def taper(name, x):
    """Weights at x, -1/2 to 1/2; zero beyond."""
    inside = np.abs(x) <= 0.5
    if name == "none":
        w = np.ones_like(x)
    elif name == "hann":
        w = np.cos(np.pi * x) ** 2
    elif name == "kaiser":
        w = np.i0(6 * np.sqrt(np.maximum(0, 1 - 4 * x * x))) / np.i0(6)
    elif name == "taylor":
        n, a = 6, np.arccosh(10 ** (35 / 20)) / np.pi
        sigma2 = n * n / (a * a + (n - 0.5) ** 2)
        w = np.ones_like(x)
        for m in range(1, n):
            i = np.arange(1, n)
            up = np.prod(1 - m * m / sigma2 / (a * a + (i - 0.5) ** 2))
            down = 2 * np.prod(1 - m * m / i[i != m] ** 2)
            w = w + 2 * (-1) ** (m + 1) * up / down * np.cos(2 * np.pi * m * x)
    else:
        raise ValueError(f"no taper {name}")
    return np.where(inside, w, 0.0)


def delays(transmitter, receiver, leaves, points):
    """Exact light time to points [..., 3] for a wave that leaves at a time."""
    out = np.linalg.norm(points - transmitter.at(leaves), axis=-1)
    tau = 2 * out / C
    middle = None
    for _ in range(3):
        # The receiver's path over the spread of arrivals (microseconds) is a straight line.
        middle = float(np.mean(tau))
        at, speed = receiver.at(leaves + middle), receiver.speed(leaves + middle)
        back = np.linalg.norm(points - at - speed * (tau - middle)[..., None], axis=-1)
        tau = (out + back) / C
    return tau


def compress(rec, samples, doppler, window, flat):
    """Correlation with the turned replica, CELLS cells a sample, from the first sample on."""
    m = len(rec.replica)
    n = 1 << int(np.ceil(np.log2(len(samples) + m)))
    turned = rec.replica * np.exp(2j * np.pi * doppler * (np.arange(m) / rec.fs - rec.tc / 2))
    q, s = np.fft.fft(turned, n), np.fft.fft(samples, n)
    x = np.fft.fftfreq(n, 1 / rec.fs) / rec.band
    weight = np.ones_like(x) if window == "none" and not flat else taper(window, x)
    filtered = np.divide(weight, q, out=np.zeros_like(q), where=weight != 0) if flat else weight * np.conj(q)
    # An echo that is the turned replica itself, of amplitude 1 and no delay, must come out as 1.
    spectrum = s * filtered / np.fft.ifft(q * filtered)[0].real
    wide = np.zeros(n * CELLS, complex)
    wide[: n // 2], wide[-(n // 2) :] = spectrum[: n // 2], spectrum[n // 2 :]
    return np.fft.ifft(wide) * CELLS


def cubic(cells, at):
    """Cubic (Lagrange) between cells of a periodic row."""
    k = np.floor(at).astype(int)
    u = at - k
    n = len(cells)
    return (
        cells[(k - 1) % n] * (-u * (u - 1) * (u - 2) / 6)
        + cells[k % n] * ((u + 1) * (u - 1) * (u - 2) / 2)
        + cells[(k + 1) % n] * (-(u + 1) * u * (u - 2) / 2)
        + cells[(k + 2) % n] * ((u + 1) * u * (u - 1) / 6)
    )


def closing(transmitter, receiver, leaves, points, h=1e-4):
    """Rate of the delay of points [..., 3], central difference: h^2 of a third derivative of 1e-9 s/s^3."""
    return (delays(transmitter, receiver, leaves + h, points) - delays(transmitter, receiver, leaves - h, points)) / (2 * h)


def focus(rec, channel, points, rows, nav="true", window="none", aperture="none", flat=False, doppler_hz=np.nan):
    """The image of points [y, x, 3]. With doppler_hz a point takes the pulses in which its Doppler is that of the aim within half of it."""
    _, tx_name, rx_name, letters = rec.channels[channel]
    code = POLARISATIONS[letters[1]]
    rows = [r for r in rows if rec.tx_pol[r] in (0, code)]
    transmitter, receiver = rec.path("transmitter", tx_name, nav), rec.path("receiver", rx_name, nav)
    gated = np.isfinite(doppler_hz)
    weights = np.ones(len(rows)) if gated else taper(aperture, (np.arange(len(rows)) + 0.5) / len(rows) - 0.5)
    total = np.zeros(points.shape[:2])
    middle = 0.5 * (points[0, 0] + points[-1, -1])
    image = np.zeros(points.shape[:2], complex)
    for row, weight in zip(rows, weights):
        leaves = rec.times[row] + rec.tc / 2
        h = 1e-3
        later, sooner = (delays(transmitter, receiver, leaves + s, middle[None])[0] for s in (h, -h))
        doppler = -rec.f0 * (later - sooner) / (2 * h)
        samples = rec.samples(row, channel)
        cells = compress(rec, samples, doppler, window, flat)
        tau = delays(transmitter, receiver, leaves, points)
        lag = (tau - rec.window_start[row]) * rec.fs
        inside = (lag >= 0) & (lag <= len(samples) - 1)
        value = cubic(cells, np.where(inside, lag, 0.0) * CELLS)
        if gated:
            h = 1e-4
            tau0 = float(delays(transmitter, receiver, leaves, middle[None])[0])
            look = transmitter.speed(leaves, h) @ rec.boresight(tx_name, row)
            look += receiver.speed(leaves + tau0, h) @ rec.boresight(rx_name, row)
            away = -rec.f0 * closing(transmitter, receiver, leaves, points) - rec.f0 * look / C
            weight = taper(aperture, away / doppler_hz)
        total += weight
        image += np.where(inside, weight * value * np.exp(2j * np.pi * ((rec.f0 * tau) % 1.0)), 0)
    return np.divide(image, total, out=np.zeros_like(image), where=total != 0)


def grid(x, y, height):
    px, py = np.meshgrid(x, y)
    return np.stack([px, py, np.full_like(px, height)], axis=-1)


def kept(entries, limit_db):
    """Whether all images keep the limit: NaN keeps none, and neither does nothing."""
    differences = [entry["difference_db"] for entry in entries]
    return bool(differences) and all(d <= limit_db for d in differences)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("recording")
    parser.add_argument("--image", help="what `nereus focus --out IMAGE.h5` made")
    parser.add_argument("--channel", help="one channel (else all)")
    parser.add_argument("--centre-m", type=float, nargs=2, default=[0.0, 0.0], help="without --image")
    parser.add_argument("--size-m", type=float, default=128.0, help="without --image")
    parser.add_argument("--pixel-m", type=float, default=1.0, help="without --image")
    parser.add_argument("--limit-db", type=float, help="with --image: exit 1 when it differs by more")
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    if args.limit_db is not None and not args.image:
        parser.error("--limit-db needs --image: there is nothing to compare with")
    import h5py

    rec = Recording(args.recording)
    # Channels of calibration bear a word in place of two polarisations and carry no echo.
    echoes = [row[0] for row in rec.channels if len(row[3]) == 2 and set(row[3]) <= set(POLARISATIONS)]
    names = echoes
    made, how, rows, bands = None, {}, range(rec.n), {}
    if args.image:
        with h5py.File(args.image, "r") as f:
            a = {k: v.decode() if isinstance(v, bytes) else v for k, v in f.attrs.items()}
            made = {c.decode() if isinstance(c, bytes) else c: f["image"][i] for i, c in enumerate(a["channels"])}
            points = grid(f["x_m"][:], f["y_m"][:], float(a["height_m"]))
        rows = np.flatnonzero((rec.index >= a["first_pulse"]) & (rec.index < a["end_pulse"]))
        how = {"nav": a["nav"], "window": a["window"], "aperture": a["aperture"], "flat": a["filter"] == "flat"}
        bands = dict(zip(made, np.atleast_1d(a["doppler_hz"])))
        strange = [n for n in made if n not in echoes]
        if strange:
            parser.error(f"channels of the image that are not in the recording: {', '.join(strange)}")
        names = [n for n in names if n in made]
    else:
        side = np.arange(round(args.size_m / args.pixel_m)) * args.pixel_m
        side -= side.mean()
        points = grid(args.centre_m[0] + side, args.centre_m[1] + side, 0.0)
    if args.channel:
        if args.channel not in echoes:
            known = args.channel in [row[0] for row in rec.channels]
            what = "is a calibration channel and carries no echo" if known else "is not in the recording"
            parser.error(f"channel {args.channel} {what}; allowed: {', '.join(echoes)}")
        if args.channel not in names:
            parser.error(f"channel {args.channel} is not in the image; allowed: {', '.join(names)}")
        names = [args.channel]
    report = {"recording": args.recording, "pulses": len(rows), "channels": {}}
    begun = time.monotonic()
    for name in names:
        channel = [row[0] for row in rec.channels].index(name)
        image = focus(rec, channel, points, rows, doppler_hz=bands.get(name, np.nan), **how)
        peak = np.unravel_index(np.argmax(np.abs(image)), image.shape)
        entry = {
            "peak_m": [float(v) for v in points[peak][:2]],
            "peak_dbw": float(20 * np.log10(max(np.abs(image).max(), 1e-200))),
        }
        if made is not None:
            # Two images of nothing but zeros agree in nothing: 0/0.
            with np.errstate(invalid="ignore", divide="ignore"):
                off = np.sum(np.abs(made[name] - image) ** 2) / np.sum(np.abs(image) ** 2)
                entry["difference_db"] = float(10 * np.log10(np.maximum(off, 1e-30)))
        report["channels"][name] = entry
    report["seconds"] = time.monotonic() - begun
    if args.json:
        print(json.dumps(report))
    else:
        for name, entry in report["channels"].items():
            difference = f", differs by {entry['difference_db']:.1f} dB" if "difference_db" in entry else ""
            x, y = entry["peak_m"]
            print(f"{name}: peak {entry['peak_dbw']:.1f} dBW at {x:.2f} m East, {y:.2f} m North{difference}")
    return 0 if args.limit_db is None or kept(report["channels"].values(), args.limit_db) else 1


if __name__ == "__main__":
    sys.exit(main())
