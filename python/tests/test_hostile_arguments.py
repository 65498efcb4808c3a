"""Arguments that nobody should give: each is an ordinary exception that says so; none is a panic, a hang or a fault of nereus."""

import datetime
import decimal
import itertools
import json
import os
import random
import resource
import subprocess
import sys

import numpy as np
import pytest

import nereus

#: What a caller can be expected to catch. MemoryError, SystemError, InternalError and panics are not among them.
ORDINARY = (ValueError, TypeError, OSError, OverflowError, nereus.RunError)


def deep(levels, make):
    found = 0
    for _ in range(levels):
        found = make(found)
    return found


def cyclic():
    found = []
    found.append(found)
    return found


FAR = datetime.timezone(datetime.timedelta(hours=23))
#: Name: value. None is legal wherever it is tried.
VALUES = {
    "huge": 10**400,
    "huge negative": -(10**5000),
    "65 bits": 2**64,
    "lone surrogate": "a\ud800b",
    "escaped byte": "\udcff",
    "nul": "a\0b",
    "nan": float("nan"),
    "infinite": float("-inf"),
    "none": None,
    "bytes": b"x",
    "bytearray": bytearray(b"x"),
    "complex": 1j,
    "object": object(),
    "function": len,
    "type": int,
    "set": {1},
    "decimal": decimal.Decimal("1e999"),
    "date": datetime.date(2020, 1, 1),
    "before the first year": datetime.datetime(1, 1, 1, tzinfo=FAR),
    "surrogate key": {"\ud800": 1},
    "nested": [[[1, {"a": [None]}]]],
    "nested surrogate": [{"a": ["\udfff"]}],
    "nested huge": {"a": [1, [10**400]]},
    "deep lists": deep(5000, lambda inner: [inner]),
    "deep dicts": deep(5000, lambda inner: {"a": inner}),
    "cycle": cyclic(),
    "endless": itertools.count(),
    "array of objects": np.array([object()], dtype=object),
    "array of nan": np.array([1.0, np.nan]),
    "array of half characters": np.array(["\ud800"]),
    "array of complex": np.array([1j]),
    "array of bytes": np.array([b"x"]),
    "empty array": np.array([]),
    "array of four axes": np.zeros((1, 2, 1, 2)),
    "masked": np.ma.masked,
    "masked array": np.ma.masked_array([1.0, 2.0], [False, True]),
    "long double": np.longdouble("1e4000"),
    "numpy time": np.datetime64("NaT"),
}
KEYS = ("radar.prf_hz", "scene.seed", "scene.start_utc", "target.0.position_m", "target.0.name", "sink.+", "platform")


def ordinary(use):
    """The exception that `use` raises."""
    with pytest.raises(ORDINARY) as raised:
        use()
    assert not isinstance(raised.value, nereus.InternalError), raised.value
    return raised.value


def refused(use):
    """As `ordinary`, and of those that nereus words."""
    found = ordinary(use)
    assert isinstance(found, nereus.InputError), repr(found)
    return found


def whatever(use):
    """`use` does what it does, or raises what is ordinary."""
    try:
        return use()
    except ORDINARY as error:
        assert not isinstance(error, nereus.InternalError), error
        return None


@pytest.mark.parametrize("name", VALUES)
def test_values_of_scenarios(scene, name):
    value = VALUES[name]
    for key in KEYS:
        refused(lambda: scene.set({key: value}).pulse_count)
    refused(lambda: nereus.Scenario({"scene": value}).pulse_count)
    refused(lambda: nereus.Scenario({"scene": {"duration_s": [value]}}).pulse_count)
    if not isinstance(value, dict):
        refused(lambda: scene.set(value))


@pytest.mark.parametrize("name", [name for name in VALUES if name != "none"])
def test_arguments(scene, name, tmp_path):
    value = VALUES[name]
    with pytest.raises(ORDINARY):
        scene.stream(pulses=value)
    with pytest.raises(ORDINARY):
        scene.stream(pulses=(0, value))
    ordinary(lambda: scene.stream(pace=value))
    ordinary(lambda: scene.record(tmp_path / "a.h5", format=value, progress=False))
    ordinary(lambda: scene.record(tmp_path / "a.h5", pulses=(value, value), progress=False))
    ordinary(lambda: nereus.focus(value))
    ordinary(lambda: nereus.focus(tmp_path, nav=value))
    ordinary(lambda: nereus.open(value))
    ordinary(lambda: nereus.table(value))
    ordinary(lambda: nereus.receive(value))
    ordinary(lambda: nereus.waveform(value, value))
    ordinary(lambda: nereus.trajectory(value, value))
    ordinary(lambda: nereus.pattern(value, value, value))
    ordinary(lambda: nereus.spectrum(value, value, value))
    ordinary(lambda: nereus.targets(value, value))
    whatever(lambda: nereus.receive("127.0.0.1:0", duration_s=value).close())
    whatever(lambda: nereus.table("sigma0", wind_mps=value, incidence_deg=45.0))
    whatever(lambda: nereus.Scenario("[scene]\n", folder=value).pulse_count)
    with scene.stream(pulses=(0, 1)) as stream:
        ordinary(lambda: stream.inject(value))


@pytest.mark.parametrize("source", [10**400, None, b"[scene]\n", "", "a\0b", "\ud800", "[scene]\n\ud800", 1.5, [], object(), float("nan")])
def test_sources(source):
    refused(lambda: nereus.Scenario(source).pulse_count)


@pytest.mark.parametrize("seconds", [float("nan"), float("inf"), -1.0, 1e300, 1e18, -1e-9])
def test_times(scene, seconds):
    sea = {"sea": {"wind_mps": 5.0, "wind_from_deg": 0.0}, "scene.patch_size_m": [8.0, 8.0], "scene.facet_m": 1.0}
    whatever(lambda: nereus.sea(scene.set(sea), seconds))
    for key in ("duration_s", "idle_s"):
        whatever(lambda: nereus.receive("127.0.0.1:0", **{key: seconds}).close())


def test_random_values(scene):
    """Tables, lists and values within each other, as they come."""
    draw = random.Random(36)
    leaves = [value for name, value in VALUES.items() if not name.startswith("deep") and name not in ("cycle", "endless")]
    leaves += [1, -1, 0.5, True, "x", "", 2**63, -(2**63) - 1, 1e308, 5e-324, "2020-01-01T00:00:00Z", np.float32(1), np.arange(3)]

    def value(depth):
        kind = draw.random()
        if depth == 0 or kind < 0.5:
            return draw.choice(leaves)
        if kind < 0.75:
            return [value(depth - 1) for _ in range(draw.randint(0, 3))]
        return {draw.choice(["a", "kind", "path", "\ud800", "", "a.b", 1, None]): value(depth - 1) for _ in range(draw.randint(0, 3))}

    keys = [*KEYS, "radar", "scene", "sea", "sink", "radar.window", "", "a.b.c", "target.99.x", "target.-1", "target.+.x", "\udc80"]
    for _ in range(max(20, round(400 * float(os.environ.get("NEREUS_CASES", "1"))))):
        key, found = draw.choice(keys), value(4)
        whatever(lambda: scene.set({key: found}).pulse_count)
        whatever(lambda: nereus.Scenario({key: found, "radar": found}).pulse_count)


ALONE = """
import json, nereus, sys
path = sys.argv[1]
uses = {
    "Scenario": lambda: nereus.Scenario(path),
    "open": lambda: nereus.open(path),
    "focus": lambda: nereus.focus(path),
    "read": lambda: nereus.reader.open_recording(path),
    "set": lambda: nereus.Scenario(sys.argv[2]).set({"radar.waveform": {"kind": "file", "path": path, "rate_hz": 5e7}}).check(),
}
found = {}
for name, use in uses.items():
    try:
        use()
    except Exception as error:
        found[name] = [type(error).__name__, str(error)]
print(json.dumps(found))
"""


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
@pytest.mark.parametrize("kind", ["pipe", "/dev/zero", "/dev/null"])
def test_pipes_and_devices(scene, kind, tmp_path):
    """In a process of its own, which a pipe would hold up, and a device fill."""
    pytest.importorskip("xarray")
    path = tmp_path / "pipe"
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path = kind
    text = tmp_path / "scene.toml"
    text.write_text(scene.text)
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))  # noqa: E731
    ended = subprocess.run(
        [sys.executable, "-c", "import nereus.reader\n" + ALONE, str(path), str(text)],
        stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, preexec_fn=limit,
    )
    assert ended.returncode == 0, ended.stderr
    found = json.loads(ended.stdout)
    assert sorted(found) == ["Scenario", "focus", "open", "read", "set"], found
    for name, (error, words) in found.items():
        assert error in ("InputError", "ScenarioError", "RecordingError", "ValueError"), (name, error, words)
        assert str(path) in words, (name, words)
        assert "is a pipe or a device; allowed: " in words, (name, words)


def test_a_file_without_end_is_no_scenario(tmp_path):
    path = tmp_path / "long.toml"
    with open(path, "wb") as file:
        file.truncate(1 << 40)
    assert str(path) in str(refused(lambda: nereus.Scenario(path)))
