"""Random radars, geometries and places on Earth as scenario files: short, and without a sea or with a tiny one."""
import math
import random
import tomllib

LIGHT_MPS = 299_792_458.0
#: Packets of DIFI hold 25 to 361 samples here, all of them the same.
PACKETS = (40, 64, 100, 128, 200, 250, 300, 361)
FAMILIES = ("coast", "aircraft", "mast", "drone", "overhead", "satellite", "relay", "towers", "at a target")


def log(draw, low, high):
    return math.exp(draw.uniform(math.log(low), math.log(high)))


def placed(draw, family):
    """Ends as (position, velocity), m and m/s; one of them where one platform carries both antennas."""

    def end(away, height, speed, level=True):
        bearing, course = draw.uniform(0, math.tau), draw.uniform(0, math.tau)
        far, fast = log(draw, *away), 0.0 if speed == 0 else log(draw, *speed)
        climb = 0.0 if level else draw.uniform(-0.05, 0.05) * fast
        place = [far * math.sin(bearing), far * math.cos(bearing), log(draw, *height)]
        return place, [fast * math.sin(course), fast * math.cos(course), climb]

    coast = ((300.0, 20e3), (4.0, 60.0), 0)
    aircraft = ((500.0, 30e3), (300.0, 12e3), (60.0, 300.0), False)
    orbit = ((50e3, 600e3), (450e3, 800e3), (7.3e3, 7.6e3))
    if family == "coast":
        return [end(*coast), end(*aircraft)]
    if family == "aircraft":
        return [end(*aircraft)]
    if family == "mast":
        return [end(*coast)]
    if family == "drone":
        return [end((15.0, 400.0), (5.0, 120.0), (1.0, 25.0), False)]
    if family == "overhead":
        # Above the middle: incidence and ground range are near zero.
        return [end((0.01, 5.0), (100.0, 5e3), (10.0, 200.0))]
    if family == "satellite":
        return [end(*orbit)]
    if family == "relay":
        return [end(*orbit), end(*coast)]
    if family == "towers":
        return [end(*coast), end(*coast)]
    # Straight to or from the middle, where Doppler cones close and twist angles hang on rounding.
    (x, y, z), _ = end(*aircraft)
    speed = draw.choice((-1, 1)) * draw.uniform(60.0, 300.0) / math.hypot(x, y)
    return [([x, y, z], [-x * speed, -y * speed, 0.0])]


def origin(draw):
    lat = draw.choice((draw.uniform(-89.9, 89.9), draw.uniform(-60, 60), float(draw.randint(-89, 89)), 0.0))
    lon = draw.choice((draw.uniform(-180, 180), float(draw.randint(-180, 180)), -5.0))
    return lat, lon, draw.choice((0.0, 10.0, 50.0, round(draw.uniform(-100, 4000), 3)))


def pulses(text, most):
    """So many pulses that at most so many packets of DIFI are sent, but four at least."""
    radar = tomllib.loads(text)["radar"]
    samples = radar["window"]["samples"]
    longest = max(n for n in range(1, 362) if samples % n == 0)
    return max(4, min(12, most // (samples // longest * len(radar["channels"]))))


def scene(seed, converter=None):
    """A scenario, and the name of its family; `converter`: whether it has an ADC, by chance if it is None."""
    draw = random.Random(seed)
    family = FAMILIES[seed % len(FAMILIES)]
    ends = placed(draw, family)
    lat, lon, height = origin(draw)
    carrier = draw.choice((1.3e9, 3.05e9, 5.4e9, 9.4e9, 10e9, 16.7e9, 35e9))
    rate = draw.choice((20e6, 50e6, 100e6, 123.456e6))
    band, packet = rate * draw.uniform(0.3, 0.75), draw.choice(PACKETS)
    samples = packet * draw.choice([k for k in (1, 2, 3, 5) if packet * k >= 64])
    pulse = draw.uniform(0.2, 0.8) * min(samples / rate, 20e-6)
    prf = min(draw.uniform(50.0, 2000.0), 0.45 / (samples / rate))
    target = [round(draw.uniform(-20, 20), 3), round(draw.uniform(-20, 20), 3), round(draw.uniform(0, 10), 3)]
    delay = sum(math.dist(place, target) for place, _ in (ends * 2)[:2]) / LIGHT_MPS
    start = max(0.0, delay - draw.uniform(0.0, 0.5) * samples / rate)
    channels = draw.choice((["VV"], ["HH", "VV"], ["HH", "HV", "VH", "VV"], ["RR", "LR"]))
    if converter is None:
        converter = draw.random() < 0.5
    lines = [
        "[scene]", f"duration_s = {(draw.randint(12, 24) - 0.5) / prf!r}", f"seed = {seed}",
        f"origin_lat_deg = {lat!r}", f"origin_lon_deg = {lon!r}", f"origin_h_m = {height!r}",
        f'earth = "{draw.choice(("flat", "curved"))}"',
        f'start_utc = "20{draw.randint(10, 37)}-0{draw.randint(1, 9)}-{draw.randint(10, 28)}T0{draw.randint(0, 9)}:59:58.{draw.randint(1, 999):03}Z"',
    ]
    if draw.random() < 0.25:
        lines += ["patch_size_m = [8.0, 8.0]", "facet_m = 1.0", "[sea]", "wind_mps = 6.0", "wind_from_deg = 90.0"]
    lines += [
        "[radar]", f"carrier_hz = {carrier!r}", f"sample_rate_hz = {rate!r}", f"prf_hz = {prf!r}",
        f"channels = {channels}".replace("'", '"'), f"noise_figure_db = {draw.uniform(1, 8)!r}",
    ]
    if len(channels) == 4 and draw.random() < 0.5:
        lines.append('tx_polarisation = "alternating"')
    if converter:
        bits = draw.choice((4, 7, 8, 10, 12, 14, 16))
        lines.append(f"adc = {{ bits = {bits}, full_scale_dbw = {draw.uniform(-120, -60)!r} }}")
    sweep = draw.choice(("up", "down"))
    lines += [
        "[radar.waveform]", 'kind = "lfm"', f"bandwidth_hz = {band!r}", f"pulse_s = {pulse!r}", f'sweep = "{sweep}"',
        "[radar.window]", f"samples = {samples}", f"start_us = {start * 1e6!r}",
    ]
    for name, (place, velocity) in zip(("one", "two"), ends):
        kind = "straight" if any(velocity) else "fixed"
        moving = f", velocity_mps = {velocity}" if any(velocity) else ""
        lines += ["[[platform]]", f'name = "{name}"', f'track = {{ kind = "{kind}", position_m = {place}{moving} }}']
        if draw.random() < 0.3:
            bias = [draw.uniform(-2, 2) for _ in range(3)]
            lines.append(f"errors = {{ position = {{ bias_m = {bias} }}, attitude = {{ bias_deg = [0.05, -0.03, 0.1] }} }}")
    for table, name, platform in (("transmitter", "tx", "one"), ("receiver", "rx", ("one", "two")[len(ends) - 1])):
        lines += [f"[[{table}]]", f'name = "{name}"', f'platform = "{platform}"']
        if table == "transmitter":
            lines.append(f"power_w = {log(draw, 1, 1e4)!r}")
        if draw.random() < 0.3:
            lines.append(f'antenna = {{ kind = "isotropic", gain_dbi = {draw.uniform(0, 30)!r} }}')
        else:
            sides = [draw.uniform(3, 60) * LIGHT_MPS / carrier for _ in range(2)]
            lines.append(f'antenna = {{ kind = "rectangle", width_m = {sides[0]!r}, height_m = {sides[1]!r} }}')
            lines.append(f'pointing = {{ kind = "at", position_m = {target} }}')
    lines += ["[[target]]", f"position_m = {target}", f"rcs_m2 = {log(draw, 0.1, 1e4)!r}", "[stream]", 'pace = "fast"', ""]
    return "\n".join(lines), family
