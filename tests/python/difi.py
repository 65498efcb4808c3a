"""A parser of the three packets of DIFI 1.1 by the tables of the standard: sections 5 (prologue), 9 (context fields) of
VITA 49.2 as far as DIFI takes them. It shares nothing with the sink."""
import struct

import numpy as np


def parse(d):
    header, stream, oui, classes, seconds, ps = struct.unpack(">IIIIIQ", d[:28])
    p = dict(type=header >> 28, count=header >> 16 & 15, stream=stream, time=seconds * 10**12 + ps)
    assert len(d) == 4 * (header & 0xffff), "packet size"
    assert header >> 27 & 1 == 1, "class identifier"
    assert header >> 25 & 3 == 0, "no trailer, nothing reserved"
    assert header >> 22 & 3 == 1 and header >> 20 & 3 == 2, "UTC, picoseconds"
    assert oui == 0x6A621E, "organisation, without pad bits"
    assert ps < 10**12
    tsm, body = header >> 24 & 1, d[28:]
    if p["type"] == 1:
        assert classes == 0 and tsm == 0 and 128 <= len(d) <= 9000
        p["samples"] = np.frombuffer(body, ">i2").reshape(-1, 2)
    elif p["type"] == 4:
        assert classes == 0x00000001 and tsm == 1 and len(d) == 108
        (cif, point, bandwidth, if_ref, rf_ref, offset, scale, level, gain2, gain1, rate, adjust, calibrated, state, form,
         more) = struct.unpack(">IIQqqqhhhhQqIIII", body)
        assert cif & 0x7fffffff == 0x7BB98000 and point == 100
        p.update(changed=cif >> 31, bandwidth=bandwidth / 2**20, rf=rf_ref / 2**20, rate=rate / 2**20, level=level / 128)
        assert (if_ref, offset, scale, gain1, gain2, adjust) == (0,) * 6
        assert calibrated <= seconds and state & 0xfff == 0 and state >> 17 & 7 == 7 and state >> 29 == 7
        # Link-efficient, complex Cartesian, signed fixed point; no repetition, no tags, no fraction.
        assert form >> 12 == 0b1_01_00000_0_000_0000_0000 and form >> 6 & 63 == 15 and form & 63 == 15 and more == 0
    else:
        assert p["type"] == 5 and classes == 0x00010004 and tsm == 1 and len(d) == 44
        cif0, cif1, spec, version = struct.unpack(">IIII", body)
        assert cif0 & 0x7fffffff == 2 and cif1 == 12 and spec == 4
        p["changed"] = cif0 >> 31
        assert version >> 25 >= 21 and 1 <= version >> 16 & 511 <= 366
        assert version >> 10 & 63 == 1 and version >> 6 & 15 == 0 and version & 63 == 0
    return p
