#!/usr/bin/env python3
"""Focuses a CRSD file of nereus, and needs nothing but that file.

    focus_crsd.py FILE.crsd [--channel NAME] [--centre-m X,Y] [--size-m X,Y] [--pixel-m M] [--out IMAGE.npz]

Range compression and bistatic back-projection of every vector, without tapers, onto a grid in the plane of the file's scene
coordinates: X along uIAX (East), Y along uIAY (North), from the image area reference point. Positions are those of the file (what
the platforms reported): the transmitter's at TxTime, the receiver's at RcvStart, on the cubic through the four nearest between those.

    I(x) = 1/M sum_m C_m(tau_m) exp(+j 2 pi f0 tau_m),    c tau_m = |x - T(t_m)| + |R(t_m + tau_m) - x|,   t_m = TxTime

C_m: correlation with the pulse that the file has as its support array `replica`, eight cells a sample, cubic between cells. The
phase of a sample against the carrier since TxTime is f0 tau for RefPhi0 = f0 (RcvStart - emission); a file with other reference
phases is turned accordingly. It shares no code with nereus. Needs numpy and sarkit.
"""
import argparse
import sys

import numpy as np
import sarkit.crsd

C = 299_792_458.0
CELLS = 8


class Path:
    """Positions over time: Lagrange's cubic through the four nearest; beyond the ends through the outermost four."""

    def __init__(self, times, points):
        self.times, self.points = times, points

    def at(self, t):
        t = np.atleast_1d(t)
        n = len(self.times)
        count = min(4, n)
        first = np.clip(np.searchsorted(self.times, t, side="right") - count // 2, 0, n - count)
        rows = first[:, None] + np.arange(count)
        x, origin = self.times[rows], self.points[first]
        sum_ = np.zeros((len(t), 3))
        for i in range(count):
            others = [j for j in range(count) if j != i]
            weight = np.prod([(t - x[:, j]) / (x[:, i] - x[:, j]) for j in others], axis=0)
            sum_ += weight[:, None] * (self.points[rows[:, i]] - origin)
        return origin + sum_


def seconds(time):
    return time["Int"] + time["Frac"]


class File:
    """What a processor needs of a CRSD file."""

    def __init__(self, path):
        self.path = path
        try:
            self.file = open(path, "rb")
            self.reader = sarkit.crsd.Reader(self.file)
        except OSError as error:
            sys.exit(f"error: {path}: {error.strerror}")
        except Exception as error:  # sarkit has no type of its own for what is no CRSD
            sys.exit(f"error: {path}: is no CRSD file ({error})")
        self.xml = self.reader.metadata.xmltree
        if self.xml.find("{*}SupportArray/{*}AddedSupportArray[{*}Identifier='replica']") is None:
            sys.exit(f"error: {path}: has no support array 'replica'; allowed: CRSD files of nereus")
        load = sarkit.crsd.XmlHelper(self.xml).load
        self.iarp = load("{*}SceneCoordinates/{*}IARP/{*}ECF")
        plane = "{*}SceneCoordinates/{*}ReferenceSurface/{*}Planar/{*}"
        self.axes = np.array([load(plane + "uIAX"), load(plane + "uIAY")])
        self.channels = [x.text for x in self.xml.findall("{*}Channel/{*}Parameters/{*}Identifier")]
        self.replica = self.read(self.reader.read_support_array, "replica", masked=False)[0].astype(complex)

    def read(self, reader, what, **options):
        """A block of the file; ends the program where it is not there."""
        try:
            return reader(what, **options)
        except (EOFError, OSError, ValueError) as error:
            sys.exit(f"error: {self.path}: {what} cannot be read, the file is cut short or damaged ({error})")

    def points(self, x_m, y_m):
        """Points of the scene's plane, Earth-centred, [y, x, 3]."""
        x, y = np.meshgrid(x_m, y_m)
        return self.iarp + x[..., None] * self.axes[0] + y[..., None] * self.axes[1]


def samples(signal, scale):
    if signal.dtype.names:
        signal = signal["real"].astype(float) + 1j * signal["imag"].astype(float)
    return signal.astype(complex) * scale[:, None]


class Channel:
    def __init__(self, file, name):
        parameters = file.xml.find(f"{{*}}Channel/{{*}}Parameters[{{*}}Identifier='{name}']")
        self.fs = float(parameters.findtext("{*}Fs"))
        signal, pvp = file.read(file.reader.read_channel, name)
        ppp = file.read(file.reader.read_ppps, parameters.findtext("{*}SARImage/{*}TxId"))
        self.samples = samples(signal, pvp["AmpSF"])
        self.sent = seconds(ppp["TxTime"])
        self.transmitter = Path(self.sent, ppp["TxPos"].astype(float))
        start = seconds(pvp["RcvStart"])
        self.receiver = Path(start, pvp["RcvPos"].astype(float))
        pulse = ppp[pvp["TxPulseIndex"]]
        self.pulse_s = float(ppp["TXmt"][0])
        self.leaves = seconds(pulse["TxTime"])
        # First sample after the middle of the pulse: whole seconds apart, so that no digit is lost.
        whole = (pvp["RcvStart"]["Int"] - pulse["TxTime"]["Int"]).astype(float)
        self.opens = whole + (pvp["RcvStart"]["Frac"] - pulse["TxTime"]["Frac"])
        self.f0 = float(pvp["RefFreq"][0])
        # Carrier at the middle of the pulse less reference at the opening, and what turns a sample there: cycles.
        whole = (pulse["PhiX0"]["Int"] - pvp["RefPhi0"]["Int"]).astype(float)
        self.phase = whole + (pulse["PhiX0"]["Frac"] - pvp["RefPhi0"]["Frac"]) + self.f0 * self.opens


def delays(channel, leaves, points):
    """Light time to points [..., 3] for a wave that leaves at a time."""
    start = channel.transmitter.at(leaves)[0]
    out = np.linalg.norm(points - start, axis=-1)
    tau = 2 * out / C
    for _ in range(3):
        middle = float(np.mean(tau))
        at, later = channel.receiver.at(np.array([leaves + middle, leaves + middle + 1e-4]))
        speed = (later - at) * 1e4
        back = np.linalg.norm(points - at - speed * (tau - middle)[..., None], axis=-1)
        tau = (out + back) / C
    return tau


def compress(file, channel, window, doppler):
    """Correlation with the replica, turned by a Doppler, CELLS cells a sample, from the first sample on."""
    m = len(file.replica)
    n = 1 << int(np.ceil(np.log2(len(window) + m)))
    turned = file.replica * np.exp(2j * np.pi * doppler * (np.arange(m) / channel.fs - channel.pulse_s / 2))
    spectrum = np.fft.fft(window, n) * np.conj(np.fft.fft(turned, n)) / np.sum(np.abs(file.replica) ** 2)
    wide = np.zeros(n * CELLS, complex)
    wide[: n // 2], wide[-(n // 2) :] = spectrum[: n // 2], spectrum[n // 2 :]
    return np.fft.ifft(wide) * CELLS


def cubic(cells, at):
    k = np.floor(at).astype(int)
    u = at - k
    n = len(cells)
    return (
        cells[(k - 1) % n] * (-u * (u - 1) * (u - 2) / 6)
        + cells[k % n] * ((u + 1) * (u - 1) * (u - 2) / 2)
        + cells[(k + 1) % n] * (-(u + 1) * u * (u - 2) / 2)
        + cells[(k + 2) % n] * ((u + 1) * u * (u - 1) / 6)
    )


def focus(file, name, points):
    """The image of points [y, x, 3], Earth-centred; the echo of a point of amplitude a is a at its place."""
    channel = Channel(file, name)
    middle = 0.5 * (points[0, 0] + points[-1, -1])
    image = np.zeros(points.shape[:2], complex)
    for row, (window, leaves) in enumerate(zip(channel.samples, channel.leaves)):
        h = 1e-3
        later, sooner = (delays(channel, leaves + s, middle[None])[0] for s in (h, -h))
        cells = compress(file, channel, window, -channel.f0 * (later - sooner) / (2 * h))
        tau = delays(channel, leaves, points)
        # The replica begins at its first edge, half a pulse before the middle.
        lag = (tau - channel.opens[row] - channel.pulse_s / 2) * channel.fs
        inside = (lag >= 0) & (lag <= len(window) - 1)
        turns = channel.f0 * tau - channel.phase[row]
        image += np.where(inside, cubic(cells, np.where(inside, lag, 0.0) * CELLS) * np.exp(2j * np.pi * turns), 0.0)
    return image / len(channel.samples)


def pair(text):
    values = [float(x) for x in text.split(",")]
    return values if len(values) == 2 else values * 2


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("crsd")
    parser.add_argument("--channel", help="[default: the first]")
    parser.add_argument("--centre-m", type=pair, default=[0.0, 0.0])
    parser.add_argument("--size-m", type=pair, default=[128.0, 128.0])
    parser.add_argument("--pixel-m", type=float, default=1.0)
    parser.add_argument("--out", help="complex image, x_m, y_m (npz)")
    args = parser.parse_args()
    file = File(args.crsd)
    name = args.channel or file.channels[0]
    if name not in file.channels:
        sys.exit(f"error: {args.crsd}: has no channel {name}; allowed: {', '.join(file.channels)}")
    counts = [round(side / args.pixel_m) for side in args.size_m]
    x_m, y_m = (c + (np.arange(n) - (n - 1) / 2) * args.pixel_m for c, n in zip(args.centre_m, counts))
    image = focus(file, name, file.points(x_m, y_m))
    peak = np.unravel_index(np.argmax(np.abs(image)), image.shape)
    level = 20 * np.log10(np.abs(image[peak]))
    print(f"{name}: {len(x_m)} x {len(y_m)} pixels, peak {level:.2f} dBW at {x_m[peak[1]]:.2f} m, {y_m[peak[0]]:.2f} m")
    if args.out:
        np.savez(args.out, image=image, x_m=x_m, y_m=y_m)
    return 0


if __name__ == "__main__":
    sys.exit(main())
