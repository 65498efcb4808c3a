"""`nereus.ppi`: where targets are, whichever way the platform heads, and what is refused."""

import nereus
import numpy as np
import pytest
from scenes import small

#: East, North and up of the targets from the mast.
TARGETS = [[600.0, 500.0, -15.0], [-700.0, -200.0, -15.0], [-1.0, 1000.0, -15.0]]
SCAN = {"kind": "scan", "rpm": 120.0, "start_deg": 10.0, "encoder_bits": 12, "about": "north"}


def scanning(**pointing):
    """A turn of half a second among three points, on a mast that heads to 77 degrees."""
    antenna = {"kind": "rectangle", "width_m": 1.0, "height_m": 0.05}
    end = {"platform": "mast", "antenna": antenna, "pointing": {**SCAN, **pointing}}
    return nereus.Scenario({
        **small(),
        "scene": {"duration_s": 0.5},
        "radar": {**small()["radar"], "prf_hz": 2000.0, "channels": ["VV"], "window": {"samples": 384, "start_us": 2.0}},
        "fidelity": {"echo": "reference"},
        "platform": [{"name": "mast", "track": {"kind": "fixed", "position_m": [100.0, -200.0, 20.0], "yaw_deg": 77.0}}],
        "transmitter": [{"name": "t", "power_w": 1000.0, **end}],
        "receiver": [{"name": "r", **end}],
        "target": [
            {"name": str(k), "position_m": [east + 100.0, north - 200.0, up + 20.0], "rcs_m2": 100.0}
            for k, (east, north, up) in enumerate(TARGETS)
        ],
    })


def check(power, beam_deg=1.21):
    """Each target has the strongest cell about it within a cell, and within a step and half a beam."""
    step = 360.0 / power.sizes["azimuth"]
    for east, north, up in TARGETS:
        range_m, azimuth_deg = np.linalg.norm([east, north, up]), np.degrees(np.arctan2(east, north))
        away = (power.azimuth.values - azimuth_deg + 180.0) % 360.0 - 180.0
        near = power.values[np.abs(away) < 8.0]
        at, cell = np.unravel_index(np.nanargmax(near), near.shape)
        assert abs(away[np.abs(away) < 8.0][at]) <= step / 2 + beam_deg / 3
        assert abs(power.range.values[cell] - range_m) <= np.diff(power.range.values)[0]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("ppi") / "r.plain"
    scanning().record(path, progress=False)
    return path


@pytest.mark.parametrize("pointing", ["reported", "true"])
@pytest.mark.parametrize("step", [0.5, 2.0])
def test_targets_stand_where_they_are(recorded, pointing, step):
    with nereus.open(recorded) as ds:
        power = nereus.ppi(ds, azimuth_step_deg=step, pointing=pointing)
    assert (power.dims, power.shape) == (("azimuth", "range"), (round(360 / step), 384))
    assert (power.attrs["units"], power.azimuth.attrs["units"], power.attrs["pulses"]) == ("W", "degrees", 1000)
    assert not np.isnan(power.values).any()
    check(power)


def test_azimuths_count_from_the_nose_where_the_encoder_does(tmp_path):
    scanning(about="nose").record(tmp_path / "r.plain", progress=False)
    with nereus.open(tmp_path / "r.plain") as ds:
        check(nereus.ppi(ds))
        check(nereus.ppi(ds, pointing="true"))


def test_a_part_of_a_turn_leaves_the_rest_empty(recorded):
    with nereus.open(recorded) as ds:
        part = nereus.ppi(ds.isel(pulse=slice(0, 250)))
        whole = nereus.ppi(ds)
    seen = ~np.isnan(part.values[:, 0])
    # A quarter of a turn from 10 degrees on.
    assert 90 <= seen.sum() <= 92 and seen[11:99].all()
    assert np.allclose(part.values[11:99], whole.values[11:99], rtol=1e-12)


def test_the_power_is_that_of_the_echo(recorded):
    with nereus.open(recorded) as ds:
        # A replica in place of the first window: its power is 1 at its begin.
        ds = ds.isel(pulse=slice(0, 1)).load()
        iq = np.zeros(ds.iq.shape, np.complex64)
        iq[0, 0, 100 : 100 + ds.replica.size] = ds.replica.values
        ds["iq"] = (ds.iq.dims, iq)
        power = nereus.ppi(ds, azimuth_step_deg=10.0)
    row = power.values[~np.isnan(power.values[:, 0])]
    assert row.shape[0] == 1 and row.argmax() == 100
    assert abs(row.max() - 1.0) < 1e-6


def test_what_it_does_not_take_is_refused(recorded, tmp_path):
    with nereus.open(recorded) as ds:
        for step in (0.0, -1.0, 91.0, float("nan"), "x", None):
            with pytest.raises(nereus.InputError, match="azimuth_step_deg"):
                nereus.ppi(ds, azimuth_step_deg=step)
        with pytest.raises(nereus.InputError, match="allowed: \"reported\", \"true\""):
            nereus.ppi(ds, pointing="wrong")
        with pytest.raises(nereus.InputError, match="the channel 'HH' is unknown"):
            nereus.ppi(ds, "HH")
        with pytest.raises(nereus.InputError, match="has no pulse"):
            nereus.ppi(ds.isel(pulse=slice(0, 0)))
        with pytest.raises(nereus.InputError, match="has no iq"):
            nereus.ppi(ds.drop_vars("iq"))
    nereus.Scenario(small()).record(tmp_path / "still.plain", pulses=(0, 2), progress=False)
    with nereus.open(tmp_path / "still.plain") as ds, pytest.raises(nereus.InputError, match="does not scan"):
        nereus.ppi(ds)
