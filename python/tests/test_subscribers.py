"""Subscribers of the sinks zmq and shm, beside an HDF5 recording: pyzmq and iceoryx2 judge what the program sends.

A second of pulses at 1 kHz; NEREUS_ALL (tools/python --all): 10,000 pulses. NEREUS names a program to run instead of that
of the package.
"""

import functools
import json
import os
import shlex
import signal
import socket
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from scenes import ROOT

PROGRAM = shlex.split(os.environ.get("NEREUS", "")) or [sys.executable, "-m", "nereus"]
SECONDS = 10.0 if os.environ.get("NEREUS_ALL") else 1.0
PULSES = round(1000 * SECONDS)

# Subscribers as processes of their own: each prints "ready", then, when the run has ended, a line of JSON.
ZMQ = """
import json, sys, zmq
socket = zmq.Context().socket(zmq.SUB)
socket.setsockopt(zmq.RECONNECT_IVL, 10)
socket.setsockopt(zmq.SUBSCRIBE, b"")
socket.setsockopt(zmq.RCVTIMEO, 60_000)
socket.setsockopt(zmq.RCVHWM, 20_000)
socket.connect(sys.argv[1])
print("ready", flush=True)
received, missed, expected = 0, 0, 0
while True:
    topic, text, *samples = socket.recv_multipart()
    header = json.loads(text)
    if topic == b"run":
        continue
    missed += header["sequence"] - expected
    expected = header["sequence"] + 1
    if topic == b"end":
        break
    received += 1
    if received == 1:
        print("began", flush=True)
print(json.dumps({"received": received, "missed": missed}))
"""
SHM = """
import importlib.util, json, sys
spec = importlib.util.spec_from_file_location("shm", sys.argv[2])
shm = importlib.util.module_from_spec(spec)
spec.loader.exec_module(shm)
print("ready", flush=True)
with shm.subscribe(sys.argv[1], timeout_s=60.0, idle_s=60.0) as pulses:
    for pulse in pulses:
        if pulses.received == 1:
            print("began", flush=True)
print(json.dumps({"received": pulses.received, "missed": pulses.missed, "ending": pulses.ending}))
"""


def ports(count: int) -> int:
    """The first of so many ports that are free in a row."""
    for first in range(20_000 + os.getpid() % 10_000, 60_000, count):
        sockets = [socket.socket() for _ in range(count)]
        try:
            for place, each in enumerate(sockets):
                each.bind(("127.0.0.1", first + place))
            return first
        except OSError:
            continue
        finally:
            for each in sockets:
                each.close()
    raise AssertionError("no free ports")


def run_words(sinks: list[dict[str, object]], seconds: float, samples: int = 64) -> list[str]:
    keys = {
        "radar.prf_hz": 1000.0,
        "radar.channels": ["HH", "VV"],
        "radar.window.samples": samples,
        "scene.duration_s": seconds,
        # A machine that is busy elsewhere is no fault of a sink.
        "stream.policy": "slip",
    }
    text = ", ".join("{ " + ", ".join(f"{key} = {json.dumps(value)}" for key, value in sink.items()) + " }" for sink in sinks)
    words = [*PROGRAM, "run", str(ROOT / "configs/live-wire.toml"), "--json", "--force", "--set", f"sink=[{text}]"]
    for key, value in keys.items():
        words += ["--set", f"{key}={json.dumps(value)}"]
    return words


def report(run: "subprocess.Popen[str]") -> dict[str, object]:
    out, err = run.communicate(timeout=120)
    assert run.returncode == 0, err
    return json.loads(out.splitlines()[-1])


def begin(words: list[str], **options: object) -> "subprocess.Popen[str]":
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)  # type: ignore[call-overload]


@functools.cache
def has_shm() -> bool:
    run = begin(run_words([{"kind": "shm", "service": f"probe-{os.getpid()}"}], 0.001))
    _, err = run.communicate(timeout=120)
    return "feature shm" not in err


def needs_shm() -> None:
    pytest.importorskip("iceoryx2")
    if not has_shm():
        pytest.skip("a nereus with the feature shm (tools/python --all builds one, NEREUS names one)")


class Zmq(threading.Thread):
    """Takes messages of a socket until there are enough, or one says that it is the last."""

    def __init__(self, port: int, enough: int) -> None:
        import zmq

        super().__init__(daemon=True)
        self.messages: list[list[bytes]] = []
        self.enough = enough
        self.socket = zmq.Context.instance().socket(zmq.SUB)
        for option, value in ((zmq.RECONNECT_IVL, 10), (zmq.RCVTIMEO, 60_000), (zmq.RCVHWM, 20_000), (zmq.SUBSCRIBE, b"")):
            self.socket.setsockopt(option, value)
        self.socket.connect(f"tcp://127.0.0.1:{port}")
        self.start()

    def run(self) -> None:
        while len(self.messages) < self.enough:
            self.messages.append(self.socket.recv_multipart())
            if self.messages[-1][0] == b"end":
                break


class Shm(threading.Thread):
    """Copies pulses until the run ends."""

    def __init__(self, service: str) -> None:
        super().__init__(daemon=True)
        self.service = service
        self.start()

    def run(self) -> None:
        import nereus.shm

        with nereus.shm.subscribe(self.service, idle_s=60.0) as self.pulses:
            self.kept = [(p.index, p.sequence, p.time_ns, p.reported["aircraft"]["position_m"].copy(), p.iq.copy()) for p in self.pulses]
            self.about = self.pulses.run


def test_every_subscriber_gets_every_pulse_beside_a_recording(tmp_path):
    pytest.importorskip("zmq")
    h5py = pytest.importorskip("h5py")
    shm = has_shm() and pytest.importorskip("iceoryx2")
    first = ports(3)
    sinks: list[dict[str, object]] = [
        {"kind": "hdf5", "path": str(tmp_path / "all.h5")},
        # A subscriber that a busy machine lets sleep for a second is no fault of a sink either.
        {"kind": "zmq", "bind": f"127.0.0.1:{first}", "buffer_pulses": PULSES},
        {"kind": "zmq", "bind": f"127.0.0.1:{first + 2}", "messages": "multipart", "buffer_pulses": PULSES},
    ]
    service = f"test-{os.getpid()}"
    samples = [Zmq(first + channel, PULSES) for channel in range(2)]
    whole = Zmq(first + 2, 2 * PULSES)
    if shm:
        sinks.append({"kind": "shm", "service": service, "buffer_pulses": PULSES})
        shared = Shm(service)
    ended = report(begin(run_words(sinks, SECONDS)))
    assert ended["pulses"] == PULSES and ended["dropped"] == 0
    for thread in [*samples, whole]:
        thread.join(60.0)
        assert not thread.is_alive()
    with h5py.File(tmp_path / "all.h5") as recording:
        iq, index, time_ns = recording["iq"][:], recording["pulse/index"][:], recording["pulse/time_ns"][:]
        position_m = recording["nav/aircraft/reported/position_m"][:]
    assert iq.shape == (PULSES, 2, 64)
    for channel, thread in enumerate(samples):
        got = np.stack([np.frombuffer(message, "<c8") for (message,) in thread.messages])
        np.testing.assert_array_equal(got, iq[:, channel])
    texts = [json.loads(message[1]) for message in whole.messages if message[0] == b"pulse"]
    assert [text["sequence"] for text in texts] == list(range(PULSES))
    np.testing.assert_array_equal([text["time_ns"] for text in texts], time_ns)
    np.testing.assert_array_equal([text["platforms"][1]["position_m"] for text in texts], position_m)
    got = np.stack([np.frombuffer(b"".join(message[2:]), "<c8").reshape(2, 64) for message in whole.messages if message[0] == b"pulse"])
    np.testing.assert_array_equal(got, iq)
    assert json.loads(whole.messages[-1][1])["sequence"] == PULSES
    runs = [json.loads(message[1]) for message in whole.messages if message[0] == b"run"]
    assert len(runs) >= SECONDS and [row["name"] for row in runs[0]["channels"]] == ["HH", "VV"]
    if shm:
        shared.join(60.0)
        assert (shared.pulses.received, shared.pulses.missed, shared.pulses.ending) == (PULSES, 0, "ended")
        for place, values in enumerate((index, range(PULSES), time_ns, position_m, iq)):
            np.testing.assert_array_equal(np.stack([kept[place] for kept in shared.kept]), values)
        assert shared.about["carrier_hz"] == 10e9 and shared.about["platforms"] == ["coast", "aircraft"]


@pytest.mark.parametrize("kind", ["zmq", "shm"])
def test_a_subscriber_that_is_killed_or_stopped_costs_nobody_else_a_pulse(tmp_path, kind):
    if kind == "zmq":
        pytest.importorskip("zmq")
        port = ports(1)
        sink = {"kind": "zmq", "bind": f"127.0.0.1:{port}", "messages": "multipart", "buffer_pulses": 1000}
        words = [sys.executable, "-c", ZMQ, f"tcp://127.0.0.1:{port}"]
    else:
        needs_shm()
        service = f"test-{os.getpid()}-killed"
        sink = {"kind": "shm", "service": service, "buffer_pulses": 1000}
        words = [sys.executable, "-c", SHM, service, str(ROOT / "python/nereus/shm.py")]
    good, killed, stopped = everybody = [begin(words) for _ in range(3)]
    try:
        for each in everybody:
            assert each.stdout is not None and each.stdout.readline() == "ready\n"
        # 16 KiB a pulse: what one sleeps through does not fit the buffers of its connection.
        run = begin(run_words([sink, {"kind": "hdf5", "path": str(tmp_path / "all.h5")}], 4.0, samples=1024))
        for each in everybody:
            assert each.stdout is not None and each.stdout.readline() == "began\n"
        killed.send_signal(signal.SIGKILL)
        stopped.send_signal(signal.SIGSTOP)
        time.sleep(3.0)
        stopped.send_signal(signal.SIGCONT)
        ended = report(run)
        counts = json.loads(good.communicate(timeout=60)[0])
        late = json.loads(stopped.communicate(timeout=60)[0])
    finally:
        for each in everybody:
            each.kill()
            each.wait()
    assert ended["pulses"] == 4000 and ended["dropped"] == 0
    assert all(each["dropped"] == 0 for each in ended["sinks"])
    assert (counts["received"], counts["missed"]) == (4000, 0)
    # It knows how many it has missed, and goes on.
    assert late["received"] + late["missed"] == 4000 and late["missed"] > 100, late


def test_a_port_in_use_is_reported_before_anything_is_made(tmp_path):
    port = ports(1)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", port))
        taken.listen()
        sinks = [{"kind": "hdf5", "path": str(tmp_path / "all.h5")}, {"kind": "zmq", "bind": f"127.0.0.1:{port}", "messages": "multipart"}]
        run = begin(run_words(sinks, 1.0))
        _, err = run.communicate(timeout=60)
    assert run.returncode == 2 and f"127.0.0.1:{port}: cannot publish there: Address already in use" in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", ["zmq", "shm"])
def test_the_manual_runs(tmp_path, kind):
    blocks = [rest.split("```")[0] for rest in (ROOT / "docs/formats.md").read_text().split("```py\n")[1:]]
    (block,) = [block for block in blocks if kind in block]
    if kind == "zmq":
        pytest.importorskip("zmq")
        port = ports(1)
        block = block.replace("5555", str(port))
        sink = {"kind": "zmq", "bind": f"127.0.0.1:{port}", "messages": "multipart"}
    else:
        needs_shm()
        block = block.replace('"nereus"', f'"manual-{os.getpid()}"')
        sink = {"kind": "shm", "service": f"manual-{os.getpid()}"}
    reads = begin([sys.executable, "-c", block])
    try:
        time.sleep(0.3)
        report(begin(run_words([sink], 1.0)))
        out, err = reads.communicate(timeout=60)
    finally:
        reads.kill()
    assert reads.returncode == 0, err
    assert "(2, 64)" in out


def test_nobody_publishes():
    pytest.importorskip("iceoryx2")
    import nereus.shm

    with pytest.raises(TimeoutError, match="nobody publishes there"):
        nereus.shm.subscribe("no-such-service", timeout_s=0.0)
