#!/usr/bin/env python3
"""CRSD files against sarkit, which shares no code with nereus: its checker, its reader, and a processor on top of it.

    tests/python/test_crsd.py [--nereus target/debug/nereus] [--keep FOLDER] [--only NAME]

Short recordings of mars-1 (monostatic), mars-4 (bistatic), a recorded flight with errors of its reports, a satellite, and
alternating polarisations behind a converter are made and exported. Of each file

* `crsdcheck --thorough` passes, warnings included;
* samples, times, positions and axes are those of the recording: samples bit by bit, times to 1e-15 s of a double's rounding,
  positions to the rounding of Earth-centred coordinates (2e-9 m), every channel;
* the image that tools/focus_crsd.py makes of the file alone equals that of `nereus focus --nav reported` to -50 dB;
* gains that its arrays give are those of the closed form of the aperture, the sweep is that of the replica, the noise power that of
  samples without echo, the echo of a point what intensity, irradiance and gains predict, and the covariance of positions that of the
  errors that were asked for.

A short test of the run's own sink goes with the first. Without what tests/python/requirements.txt lists (installed into
target/crsd-venv where pip can) the test is skipped.
"""
import argparse
import contextlib
import io
import os
import subprocess
import sys
import tempfile

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LIMIT_DB = -50.0
PLACE = {"scene.origin_lat_deg": "54.2", "scene.origin_lon_deg": "7.9", "scene.origin_h_m": "40"}
SMALL = {"scene.duration_s": "0.3", "scene.patch_size_m": "[96.0,96.0]", "radar.noise_figure_db": "4"}
FLIGHT = {
    "scene.duration_s": "0.6",
    "stream.pace": "fast",
    "platform.1.errors.preset": "navigation",
    "platform.1.errors.position": "{bias_m=[0.5,-0.3,0.2]}",
    "platform.1.errors.attitude": "{bias_deg=[0.05,-0.03,0.1]}",
}
IN_TURN = {
    "stream.pace": "fast",
    "scene.duration_s": "0.2",
    "radar.tx_polarisation": "alternating",
    "radar.prf_hz": "500",
    "radar.adc": "{bits=10,full_scale_dbw=-95.0}",
}
# Name: scenario, keys, middle (East, North) and side of the image, pixel, m; type of collection.
CASES = {
    "mars-1": ("mars-1", PLACE | SMALL, (0.0, 0.0, 48.0, 1.0), "MONOSTATIC"),
    "mars-4": ("mars-4", PLACE | SMALL, (0.0, 0.0, 48.0, 1.0), "BISTATIC"),
    "flight": ("calibration", FLIGHT, (0.0, 0.0, 100.0, 2.0), "BISTATIC"),
    "satellite": ("spaceborne", PLACE | {"scene.earth": "flat", "scene.duration_s": "0.1"}, (0.0, 0.0, 200.0, 5.0), "MONOSTATIC"),
    "in-turn": ("mars-1", PLACE | SMALL | IN_TURN, (0.0, 0.0, 48.0, 1.0), "MONOSTATIC"),
}


def with_sarkit():
    """Goes on where sarkit and sigmf are: here, or in an environment of the tests' own."""
    try:
        import h5py  # noqa: F401
        import sarkit.crsd  # noqa: F401
        import sigmf  # noqa: F401

        return
    except ImportError:
        pass
    environment = os.path.join(TOP, "target", "crsd-venv")
    python = os.path.join(environment, "bin", "python")
    wanted = os.path.join(TOP, "tests", "python", "requirements.txt")
    if os.path.realpath(sys.prefix) == os.path.realpath(environment):
        skip("sarkit or sigmf is not in target/crsd-venv")
    try:
        if not os.path.exists(python):
            subprocess.run([sys.executable, "-m", "venv", environment], check=True)
        has = subprocess.run([python, "-c", "import h5py, sarkit.crsd, sigmf"], stderr=subprocess.DEVNULL)
        if has.returncode != 0:
            subprocess.run([python, "-m", "pip", "install", "--quiet", "--no-compile", "--requirement", wanted], check=True)
    except (OSError, subprocess.CalledProcessError):
        skip("sarkit (pip cannot install tests/python/requirements.txt)")
    os.execv(python, [python, os.path.abspath(sys.argv[0]), *sys.argv[1:]])


def skip(what):
    print(f"skipped: {os.path.basename(sys.argv[0])}: {what}")
    sys.exit(0)


def run(nereus, *arguments):
    ended = subprocess.run([nereus, *arguments], capture_output=True, text=True)
    if ended.returncode != 0:
        raise AssertionError(f"nereus {' '.join(arguments)}: {ended.stderr}")
    return ended.stdout


def check_file(path):
    """What crsdcheck reports, as its own command does."""
    import sarkit.verification._crsdcheck as crsdcheck

    words = io.StringIO()
    with contextlib.redirect_stdout(words):
        failed = crsdcheck.main(["--thorough", "-v", path])
    assert not failed, f"crsdcheck --thorough {path}:\n{words.getvalue()[:4000]}"


class Scene:
    """The frame of a recording."""

    def __init__(self, h5):
        import numpy as np
        import sarkit.wgs84

        lat, lon, height = (float(h5.attrs[f"origin_{key}"]) for key in ("lat_deg", "lon_deg", "h_m"))
        self.origin = sarkit.wgs84.geodetic_to_cartesian([lat, lon, height])
        a, o = np.radians([lat, lon])
        self.axes = np.array([
            [-np.sin(o), np.cos(o), 0.0],
            [-np.sin(a) * np.cos(o), -np.sin(a) * np.sin(o), np.cos(a)],
            [np.cos(a) * np.cos(o), np.cos(a) * np.sin(o), np.sin(a)],
        ])

    def ecef(self, enu):
        return self.origin + enu @ self.axes


def rotate(quaternion, vector):
    import numpy as np

    w, v = quaternion[:, :1], quaternion[:, 1:]
    cross = np.cross(v, vector)
    return vector + 2 * (w * cross + np.cross(v, cross))


def cubic(times, points, at):
    """Lagrange's cubic through the four nearest, beyond the end through the last four; the sum of its weights' sizes."""
    import numpy as np

    n = len(times)
    first = np.clip(np.searchsorted(times, at, side="right") - 2, 0, n - 4)
    rows = first[:, None] + np.arange(4)
    x = times[rows]
    found, sizes = np.zeros((len(at), 3)), np.zeros(len(at))
    for i in range(4):
        others = [j for j in range(4) if j != i]
        weight = np.prod([(at - x[:, j]) / (x[:, i] - x[:, j]) for j in others], axis=0)
        found += weight[:, None] * (points[rows[:, i]] - points[first])
        sizes += np.abs(weight)
    return points[first] + found, sizes


def compare(h5, path):
    """Samples, times, positions and axes of every channel against the recording."""
    import numpy as np
    import sarkit.crsd

    scene = Scene(h5)
    n = len(h5["pulse/index"])
    ns, part = h5["pulse/time_ns"][:n], h5["pulse/time_frac_ns"][:n]
    window = h5["pulse/window_start_s"][:n]
    times = ((ns - ns[0]) + part) * 1e-9
    reference_ns = int(h5.attrs["start_time_s"]) * 10**9
    codes = {"H": 1, "V": 2, "R": 3, "L": 4}
    file = open(path, "rb")
    reader = sarkit.crsd.Reader(file)
    xml = reader.metadata.xmltree
    fs, f0 = float(h5.attrs["sample_rate_hz"]), float(h5.attrs["carrier_hz"])
    for place, row in enumerate(h5["channel"][:]):
        name, tx, rx, letters = (field.decode() for field in row)
        if len(letters) != 2:
            continue
        used = np.flatnonzero(np.isin(h5["pulse/tx_pol"][:n], [0, codes[letters[1]]]))
        signal, pvp = reader.read_channel(name)
        tx_id = xml.findtext(f"{{*}}Channel/{{*}}Parameters[{{*}}Identifier='{name}']/{{*}}SARImage/{{*}}TxId")
        ppp = reader.read_ppps(tx_id)
        assert np.array_equal(ppp["PulseNumber"], h5["pulse/index"][:n][used]), name
        assert np.array_equal(ppp["Flags"], h5["pulse/flags"][:n][used]), name
        assert np.array_equal(pvp["TxPulseIndex"], np.arange(len(used))), name
        # Samples, bit by bit.
        iq = h5["iq"][:n][used, place]
        if iq.dtype.names:
            step = float(h5["iq"].attrs["adc_step"])
            # Of 16 bits as floating point.
            parts = [signal[part] for part in ("real", "imag")] if signal.dtype.names else [signal.real, signal.imag]
            for ours, theirs in zip("ri", parts):
                assert np.array_equal((iq[ours] + 0.5) * step, theirs.astype(float) * pvp["AmpSF"][:, None]), name
        else:
            assert np.array_equal(iq, signal) and np.all(pvp["AmpSF"] == 1.0), name
        # Times: integers apart, so that nothing is rounded but the last fraction.
        emission = ns[used] - reference_ns
        for table, key, after in ((ppp, "TxTime", float(h5.attrs["pulse_s"]) / 2), (pvp, "RcvStart", window[used])):
            whole = (emission // 10**9 - table[key]["Int"]).astype(float)
            rest = (emission % 10**9 + part[used]) * 1e-9 + after - table[key]["Frac"] - table["TimeOffset"]
            assert np.max(np.abs(whole + rest)) < 1e-15, (name, key, np.max(np.abs(whole + rest)))
            assert np.max(np.abs(table["TimeOffset"])) * fs <= 0.5001, (name, key)
        # Positions, as reported.
        carriers = {}
        for table, antenna, end, after in ((ppp, tx, "Tx", float(h5.attrs["pulse_s"]) / 2), (pvp, rx, "Rcv", window[used])):
            centres = h5[f"nav/{antenna}/reported_phase_centre_m"][:n]
            wanted, sizes = cubic(times, centres, times[used] + after)
            off = np.max(np.abs(table[end + "Pos"] - scene.ecef(wanted)), axis=1)
            # Far beyond the last report, as a satellite's echo comes, weights are large: half an ulp of each product, both ways.
            rounded = 5e-9 + sizes * 2.0**-53 * 2 * np.max(np.abs(centres))
            assert np.all(off < rounded), (name, end, np.max(off - rounded))
            carrier = carriers.setdefault(antenna, platform(h5, antenna))
            check_axes(h5, scene, antenna, carrier, table, end, used)
            speed = h5[f"nav/{carrier}/reported/velocity_mps"][:n][used]
            assert np.max(np.abs(table[end + "Vel"] - speed @ scene.axes)) < 0.02, (name, end)
        # Phases: an echo without delay would have the phase 0 of a recording.
        cycles = (ppp["PhiX0"]["Int"] - pvp["RefPhi0"]["Int"]) + (ppp["PhiX0"]["Frac"] - pvp["RefPhi0"]["Frac"])
        expected = f0 * (float(h5.attrs["pulse_s"]) / 2 - window[used])
        assert np.max(np.abs(cycles - expected)) < 1e-6, name
    file.close()


def mount(h5, antenna):
    import tomllib

    scenario = tomllib.loads(h5.attrs["config"])
    return next(a for a in scenario["transmitter"] + scenario["receiver"] if a["name"] == antenna)


def platform(h5, antenna):
    return mount(h5, antenna)["platform"]


def check_axes(h5, scene, antenna, carrier, table, end, used):
    """Those of the antenna, turned from the true to the reported attitude of its platform; without a boresight H is level."""
    import numpy as np

    n = len(h5["pulse/index"])
    if mount(h5, antenna)["antenna"]["kind"] == "isotropic":
        across, up = table[end + "ACX"], table[end + "Pos"] / np.linalg.norm(table[end + "Pos"], axis=1)[:, None]
        # The flat sea of a scene turns away from the Earth's, and the ellipsoid's vertical from its centre.
        far = np.linalg.norm(table[end + "Pos"] - scene.origin, axis=1) / 6.35e6
        assert np.all(np.abs(np.sum(across * up, axis=1)) < 0.004 + far), (antenna, end)
        axes = np.stack([across, table[end + "ACY"]], axis=1)
        assert np.max(np.abs(axes @ axes.swapaxes(1, 2) - np.eye(2))) < 1e-12, (antenna, end)
        return
    axes = h5[f"nav/{antenna}/boresight_quat"][:n][used]
    states = [h5[f"nav/{carrier}/{kind}/attitude_quat"][:n][used] for kind in ("true", "reported")]
    for axis, key in (([0.0, 1.0, 0.0], "ACX"), ([0.0, 0.0, 1.0], "ACY")):
        inverse = states[0] * [1, -1, -1, -1]
        turned = rotate(states[1], rotate(inverse, rotate(axes, np.array(axis))))
        assert np.max(np.abs(table[end + key] - turned @ scene.axes)) < 1e-12, (antenna, end, key)


def check_gains(xml, reader, h5):
    """The gain of a rectangle half-way to its first null: -3.92 dB, along both axes."""
    import numpy as np
    import tomllib

    scenario = tomllib.loads(h5.attrs["config"])
    wavelength = 299_792_458.0 / float(h5.attrs["carrier_hz"])
    mount = scenario["transmitter"][0]
    assert mount["antenna"]["kind"] == "rectangle"
    gains = reader.read_support_array(f"gain-{mount['name']}")["Gain"]
    element = xml.find(f"{{*}}SupportArray/{{*}}GainPhaseArray[{{*}}Identifier='gain-{mount['name']}']")
    for axis, side in enumerate(("width_m", "height_m")):
        first, step = (float(element.findtext("{*}" + "XY"[axis] + key)) for key in ("0", "SS"))
        line = np.take(gains, gains.shape[1 - axis] // 2, axis=1 - axis)
        cosines = first + step * np.arange(len(line))
        u = 0.5 * wavelength / mount["antenna"][side]
        if u < abs(first):
            assert abs(np.interp(u, cosines, line) + 3.92) < 0.02, (side, np.interp(u, cosines, line))
    area = mount["antenna"]["width_m"] * mount["antenna"]["height_m"]
    intensity = float(xml.findtext("{*}TxSequence/{*}Parameters/{*}TxRefRadIntensity"))
    # P G / (4 pi), G = 4 pi A / lambda^2.
    assert abs(intensity - 10 * np.log10(mount["power_w"] * area / wavelength**2)) < 1e-9, intensity


def check_waveform(xml, reader):
    """The replica against exp(j pi FxRate (t - TXmt/2)^2): phase zero in the middle of the pulse, where PhiX0 is."""
    import numpy as np

    replica = reader.read_support_array("replica", masked=False)[0].astype(complex)
    for sequence in xml.findall("{*}TxSequence/{*}Parameters"):
        ppp = reader.read_ppps(sequence.findtext("{*}Identifier"))[0]
        t = np.arange(len(replica)) / float(xml.findtext("{*}Channel/{*}Parameters/{*}Fs")) - ppp["TXmt"] / 2
        inner = np.abs(t) < 0.4 * ppp["TXmt"]
        lfm = np.exp(1j * np.pi * ppp["FxRate"] * t**2)[inner]
        match = np.vdot(lfm, replica[inner]) / np.linalg.norm(lfm) / np.linalg.norm(replica[inner])
        # The filter leaves ripples of 3e-3 in a pulse of 33 samples.
        assert match.real > 0.999 and abs(match.imag) < 1e-2, match


def check_noise(xml, reader, name):
    """PNCRSD against samples before the first echo: 1 % for 20,000 and more of them, and four standard deviations."""
    import numpy as np

    parameters = xml.find(f"{{*}}Channel/{{*}}Parameters[{{*}}Identifier='{name}']")
    signal, pvp = reader.read_channel(name)
    ratio = np.mean(np.abs(signal[:, :128] * pvp["AmpSF"][:, None]) ** 2) / float(parameters.findtext("{*}PNCRSD"))
    assert abs(ratio - 1) < 0.01 + 4 / np.sqrt(signal[:, :128].size * float(parameters.findtext("{*}BNCRSD"))), ratio


def gain_db(file, antenna, table, end, point):
    """The gain towards a point for each row of a table, from the file's array over direction cosines."""
    import numpy as np
    from sarkit.crsd import interpolate_support_array

    sight = point - table[end + "Pos"]
    sight /= np.linalg.norm(sight, axis=1)[:, None]
    x, y = (np.sum(sight * table[end + axis], axis=1) for axis in ("ACX", "ACY"))
    element = file.xml.find(f"{{*}}SupportArray/{{*}}GainPhaseArray[{{*}}Identifier='gain-{antenna}']")
    steps = [float(element.findtext("{*}" + key)) for key in ("X0", "Y0", "XSS", "YSS")]
    return interpolate_support_array(x, y, *steps, file.reader.read_support_array(f"gain-{antenna}", masked=False)["Gain"])[0]


def check_level(crsd, point, name, rcs_m2):
    """The echo of a point: TxRadInt, gain, spreading, cross section, spreading, gain, RcvRefIrradiance."""
    import focus_crsd
    import numpy as np

    file = focus_crsd.File(crsd)
    channel = file.xml.find(f"{{*}}Channel/{{*}}Parameters[{{*}}Identifier='{name}']")
    sequence = channel.findtext("{*}SARImage/{*}TxId")
    antenna = file.xml.findtext(f"{{*}}TxSequence/{{*}}Parameters[{{*}}Identifier='{sequence}']/{{*}}TxAPCId")
    ppp, (_, pvp) = file.reader.read_ppps(sequence), file.reader.read_channel(name)
    section_db = 10 * np.log10(rcs_m2 / (4 * np.pi))
    sent = ppp["TxRadInt"] + gain_db(file, antenna, ppp, "Tx", point) - 20 * np.log10(np.linalg.norm(ppp["TxPos"] - point, axis=1))
    back = gain_db(file, channel.findtext("{*}RcvAPCId"), pvp, "Rcv", point)
    back -= 20 * np.log10(np.linalg.norm(pvp["RcvPos"] - point, axis=1)) + float(channel.findtext("{*}RcvRefIrradiance"))
    wanted = 20 * np.log10(np.mean(10 ** ((sent + section_db + back) / 20)))
    points = point + np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]])
    found = 20 * np.log10(np.abs(focus_crsd.focus(file, name, points)[0, 0]))
    # Eight points around it have side lobes here; a forgotten factor of two would be 3 dB.
    assert abs(found - wanted) < 1.0, (name, found, wanted)


def check_covariance(h5, xml):
    """The receiver's positions: East, North and up of its biases and of the preset's 0.05 m; velocities: 0.005 m/s."""
    import numpy as np
    import sarkit.crsd

    covariance = sarkit.crsd.XmlHelper(xml).load("{*}ErrorParameters/{*}SARImage/{*}Bistatic/{*}PosVelError/{*}RcvPVCov")
    axes = Scene(h5).axes
    position, velocity = (axes @ covariance[block, block] @ axes.T for block in (slice(0, 3), slice(3, 6)))
    assert np.allclose(position, np.diag(np.square([0.5, -0.3, 0.2]) + 0.05**2), atol=1e-6), position
    assert np.allclose(velocity, np.diag([0.005**2] * 3), atol=1e-8), velocity


def compare_images(nereus, recording, crsd, grid, channel):
    import focus_crsd
    import h5py
    import numpy as np

    x, y, side, pixel = grid
    out = recording + ".image.h5"
    run(nereus, "focus", recording, "--nav", "reported", "--channel", channel, f"--centre-m={x},{y}", "--size-m", str(side),
        "--pixel-m", str(pixel), "--doppler-hz", "all", "--interpolation-db", "-70", "--out", out, "--force")
    with h5py.File(out) as image, h5py.File(recording) as h5:
        wanted = image["image"][0]
        east, north = np.meshgrid(image["x_m"][:], image["y_m"][:])
        points = Scene(h5).ecef(np.stack([east, north, np.zeros_like(east)], axis=-1))
    found = focus_crsd.focus(focus_crsd.File(crsd), channel, points)
    difference_db = 10 * np.log10(np.sum(np.abs(found - wanted) ** 2) / np.sum(np.abs(wanted) ** 2))
    assert difference_db < LIMIT_DB, f"{channel}: {difference_db:.1f} dB"
    return difference_db


def main():
    with_sarkit()
    import h5py
    import sarkit.crsd

    sys.path.insert(0, os.path.join(TOP, "tools"))

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nereus", default=os.path.join(TOP, "target/debug/nereus"))
    parser.add_argument("--keep")
    parser.add_argument("--only", choices=CASES)
    args = parser.parse_args()
    if not os.path.exists(args.nereus):
        skip(f"no {args.nereus}: cargo build")
    folder = args.keep or tempfile.mkdtemp(prefix="nereus-crsd-")
    os.makedirs(folder, exist_ok=True)
    # With few cases without those whose checks others have, too.
    few = float(os.environ.get("NEREUS_CASES", "1")) < 1.0
    for name, (scenario, keys, grid, collect) in CASES.items():
        if args.only not in (None, name) or (few and args.only is None and name in ("mars-1", "mars-4")):
            continue
        recording, crsd = (os.path.join(folder, f"{name}.{ending}") for ending in ("h5", "crsd"))
        direct = os.path.join(folder, f"{name}-direct.crsd")
        sets = [f"--set={key}={value}" for key, value in keys.items()]
        sets += ["--set=sink.0.kind=hdf5", f"--set=sink.0.path={recording}"]
        sets += [f'--set=sink.+={{kind="crsd",path="{direct}"}}']
        run(args.nereus, "run", os.path.join(TOP, "configs", scenario + ".toml"), *sets, "--force")
        run(args.nereus, "export", "crsd", recording, "--out", crsd, "--force")
        with open(crsd, "rb") as export, open(direct, "rb") as sink:
            assert export.read() == sink.read(), "sink and export differ"
        check_file(crsd)
        with h5py.File(recording) as h5:
            compare(h5, crsd)
            with open(crsd, "rb") as file:
                reader = sarkit.crsd.Reader(file)
                check_gains(reader.metadata.xmltree, reader, h5)
                check_waveform(reader.metadata.xmltree, reader)
            channels = [row[0].decode() for row in h5["channel"][:] if len(row[3]) == 2]
        with open(crsd, "rb") as file:
            reader = sarkit.crsd.Reader(file)
            found = reader.metadata.xmltree.findtext("{*}SARInfo/{*}CollectType")
            if name in ("flight", "satellite"):
                check_noise(reader.metadata.xmltree, reader, channels[0])
            if name == "flight":
                with h5py.File(recording) as h5:
                    check_covariance(h5, reader.metadata.xmltree)
        assert found == collect, found
        if name == "satellite":
            with h5py.File(recording) as h5:
                check_level(crsd, Scene(h5).origin, channels[0], 1e5)
        worst = max(compare_images(args.nereus, recording, crsd, grid, c) for c in (channels[0], channels[-1]))
        print(f"{name}: {len(channels)} channels, crsdcheck passes, images differ by {worst:.1f} dB")
    if not args.keep:
        import shutil

        shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
