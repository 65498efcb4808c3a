"""Pulses of a run on this machine, read where they lie: shared memory, by iceoryx2.

    import nereus.shm                                   # or a copy of this file, which needs nothing else of nereus

    with nereus.shm.subscribe("nereus") as pulses:      # nereus run ... with [[sink]] kind = "shm"
        for pulse in pulses:
            print(pulse.index, pulse.iq.shape, pulse.reported["aircraft"]["position_m"])
    print(pulses.received, pulses.missed, pulses.ending)

Needs numpy and `pip install iceoryx2` of the version that the program is built with (0.10). Bytes: docs/formats.md.
"""

from __future__ import annotations

import ctypes
import json
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["SharedPulse", "Subscription", "subscribe"]

# 2: receivers have windows of their own.
VERSIONS = (1, 2)
# How long to sleep while there is no pulse, s.
NAP_S = 0.0002
# A reported state in shared memory.
STATE = np.dtype([
    ("position_m", "=f8", 3),
    ("velocity_mps", "=f8", 3),
    ("attitude_quat", "=f8", 4),
    ("age_s", "=f8"),
    ("flags", "=u4"),
    ("reserved", "=u4"),
])


class Header(ctypes.Structure):
    """What lies before a pulse."""

    _fields_ = [
        ("version", ctypes.c_uint32),
        ("flags", ctypes.c_uint32),
        ("sequence", ctypes.c_uint64),
        ("index", ctypes.c_uint64),
        ("time_ns", ctypes.c_int64),
        ("time_frac_ns", ctypes.c_double),
        ("window_start_s", ctypes.c_double),
        ("adc_step", ctypes.c_double),
        ("source", ctypes.c_uint64),
        ("channels", ctypes.c_uint32),
        ("samples", ctypes.c_uint32),
        ("platforms", ctypes.c_uint32),
        ("sample_format", ctypes.c_uint8),
        ("tx_pol", ctypes.c_uint8),
        ("end", ctypes.c_uint8),
        ("windows", ctypes.c_uint8),
    ]

    @staticmethod
    def type_name() -> str:
        """The name that both ends agree upon."""
        return "NereusPulse"


class SharedPulse:
    """A pulse. Its arrays lie in shared memory: they are read-only, and hold the pulse there as long as they live.

    A subscriber may hold four pulses at a time: copy what you keep longer (`pulse.iq.copy()`).
    """

    def __init__(self, sample: Any, header: Header, run: dict[str, Any]) -> None:
        self.index: int = header.index
        self.sequence: int = header.sequence
        self.time_ns: int = header.time_ns
        self.time_frac_ns: float = header.time_frac_ns
        self.window_start_s: float = header.window_start_s
        """First sample after the emission: of all channels, or of the first."""
        self.flags: int = header.flags
        self.tx_pol: int = header.tx_pol
        self.adc_step: float | None = header.adc_step if header.sample_format == 1 else None
        shape = (header.channels, header.samples)
        samples = shape[0] * shape[1] * (4 if header.sample_format == 1 else 8)
        # The length by the header: that of iceoryx2's Slice counts bytes or elements, by its version.
        behind = -(-samples // 8) * 8
        length = header.platforms * STATE.itemsize + behind + 8 * header.windows
        block = (ctypes.c_uint8 * length).from_address(sample.payload().as_ptr())
        block.sample = sample  # type: ignore[attr-defined]  # arrays keep the block, the block keeps the sample
        data = np.frombuffer(block, np.uint8)
        data.flags.writeable = False
        states = data[: header.platforms * STATE.itemsize].view(STATE)
        windows = data[length - 8 * header.windows :].view("=f8")
        alike = np.full(len(run.get("receivers", [])), self.window_start_s)
        self.receiver_window_start_s: NDArray[np.float64] = windows if header.windows else alike
        """The same of every receiver, in the order of the run's description."""
        self.reported: dict[str, Any] = dict(zip(run.get("platforms", []), states))
        """What each platform reports: `position_m`, `velocity_mps`, `attitude_quat`, `age_s`, `flags`."""
        samples_at = data[states.nbytes : states.nbytes + samples]
        if header.sample_format == 1:
            self.iq: NDArray[Any] = samples_at.view("=i2").reshape(*shape, 2)
        else:
            self.iq = samples_at.view(np.complex64).reshape(shape)
        """`[channel, sample]` complex64 in sqrt(W), or ADC codes `[channel, sample, 2]` int16."""

    def volts(self) -> NDArray[np.complex64]:
        """Samples as complex64 in sqrt(W), whatever they are: a copy."""
        if self.adc_step is None:
            return self.iq.copy()
        pairs = (self.iq.astype(np.float32) + np.float32(0.5)) * np.float32(self.adc_step)
        return pairs.view(np.complex64)[..., 0]


class Subscription(Iterator[SharedPulse]):
    """The pulses of a run, in order. Made by `subscribe`."""

    def __init__(self, service: str, timeout_s: float, idle_s: float | None) -> None:
        try:
            import iceoryx2 as iox2
        except ImportError as error:
            raise ImportError("nereus.shm needs iceoryx2: pip install 'iceoryx2==0.10.*'") from error
        iox2.set_log_level_from_env_or(iox2.LogLevel.Fatal)
        self.service = service
        self.received = 0
        """Pulses received."""
        self.missed = 0
        """Pulses published after the first one received that did not come: this program was too slow."""
        self.ending: str | None = None
        """Why there are no more pulses: "ended", "killed" (the run), or "idle"."""
        self._idle_s = idle_s
        self._expected: tuple[int, int] | None = None
        self._run: dict[str, Any] | None = None
        node = iox2.NodeBuilder.new().signal_handling_mode(iox2.SignalHandlingMode.Disabled)
        self._node = node.create(iox2.ServiceType.Ipc)
        until = time.monotonic() + timeout_s
        while not self._open(iox2):
            if time.monotonic() >= until:
                raise TimeoutError(
                    f"shared memory service '{service}': nobody publishes there; start a run with a sink of kind \"shm\""
                )
            time.sleep(0.01)

    def _open(self, iox2: Any) -> bool:
        def builder(part: str, of: Any) -> Any:
            name = iox2.ServiceName.new(f"{self.service}/{part}")
            return self._node.service_builder(name).publish_subscribe(of)

        try:
            pulses = builder("pulses", iox2.Slice[ctypes.c_uint64]).user_header(Header).open()
            run = builder("run", iox2.Slice[ctypes.c_uint8]).open()
        except iox2.PublishSubscribeOpenError:
            return False
        if pulses.dynamic_config.number_of_publishers == 0:
            return False
        self._service = pulses
        try:
            history = pulses.static_config.history_size
            self._pulses = pulses.subscriber_builder().history_request(history).create()
            self._runs = run.subscriber_builder().history_request(1).create()
        except iox2.SubscriberCreateError as error:
            raise RuntimeError(
                f"shared memory service '{self.service}': {error}; allowed: as many subscribers as the sink has (key subscribers)"
            ) from None
        return True

    @property
    def run(self) -> dict[str, Any]:
        """What holds for the whole run: channels, rates, platforms. Empty until the run has sent it."""
        while (sample := self._runs.receive()) is not None:
            self._run = json.loads(bytes(sample.payload().as_memory_view()))
        return self._run or {}

    def __next__(self) -> SharedPulse:
        begun = time.monotonic()
        looked = begun
        while self.ending is None:
            sample = self._pulses.receive()
            if sample is not None:
                pulse = self._take(sample)
                if pulse is not None:
                    return pulse
                continue
            now = time.monotonic()
            if now - looked > 0.5:
                looked = now
                self._node.try_cleanup_dead_nodes()
                if self._service.dynamic_config.number_of_publishers == 0 and not self._pulses.has_samples():
                    self.ending = "killed"
            if self._idle_s is not None and now - begun > self._idle_s:
                self.ending = "idle"
            time.sleep(NAP_S)
        raise StopIteration

    def _take(self, sample: Any) -> SharedPulse | None:
        header: Header = sample.user_header().contents
        if header.version not in VERSIONS:
            raise ValueError(f"shared memory service '{self.service}': version {header.version}, not one of {VERSIONS}")
        if self._expected is not None and self._expected[0] == header.source:
            self.missed += header.sequence - self._expected[1]
        self._expected = (header.source, header.sequence + 1)
        if header.end:
            self.ending = "ended"
            return None
        self.received += 1
        return SharedPulse(sample, header, self.run)

    def __iter__(self) -> Subscription:
        return self

    def __enter__(self) -> Subscription:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Gives the place of a subscriber back; pulses that are held stay readable."""
        self.ending = self.ending or "closed"
        self._pulses.delete()
        self._runs.delete()


def subscribe(service: str = "nereus", *, timeout_s: float = 60.0, idle_s: float | None = None) -> Subscription:
    """Subscribes to the sink of kind `shm` with this `service`, as soon as there is one: an iterator of pulses.

    Waits `timeout_s` for it (`TimeoutError`). The iteration ends with the run, when the run was killed, or after
    `idle_s` without a pulse.
    """
    return Subscription(service, timeout_s, idle_s)
