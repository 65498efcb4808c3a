"""Echoes: delays, amplitudes, samples."""

import math

import numpy as np

from .frames import C, basis, dot, split

# The pulse radiates from 0 to Tc; the filter rings beyond. Echoes are computed when they come this
# near to the window.
GUARD_SAMPLES = 32


def light_time(tx, rx, t, where):
    """Both legs from an emission at t; where(t) places all scatterers at times t [n]."""
    start = tx.centre(np.array([t]))
    tau1 = np.zeros(len(where(np.array([t]))))
    for _ in range(20):
        tau1 = np.linalg.norm(where(t + tau1) - start, axis=-1) / C
    x = where(t + tau1)
    tau2 = np.zeros_like(tau1)
    for _ in range(20):
        tau2 = np.linalg.norm(rx.centre(t + tau1 + tau2) - x, axis=-1) / C
    return tau1, tau2


def direct_time(tx, rx, t):
    start, tau = tx.centre(np.array([t])), np.zeros(1)
    for _ in range(20):
        tau = np.linalg.norm(rx.centre(t + tau) - start, axis=-1) / C
    return tau


def rate(tau, t, step=1e-3):
    """d tau/dt by a central difference of the light time, fourth order."""
    f = {k: tau(t + k * step) for k in (-2, -1, 1, 2)}
    return (8 * (f[1] - f[-1]) - (f[2] - f[-2])) / (12 * step)


class Echoes:
    """Of one pair and one emission: delay, its rate, and the amplitude in each channel of the pair [c, n]."""

    def __init__(self, tau, rate, amplitudes):
        self.tau, self.rate, self.amplitudes = tau, rate, amplitudes

    def only(self, these):
        return Echoes(self.tau[these], self.rate[these], self.amplitudes[:, these])


def carried(scene, tau, rate, amplitudes):
    """Echoes of these amplitudes after the phase of the way."""
    return Echoes(tau, rate, np.array(amplitudes) * np.exp(-2j * np.pi * np.mod(scene.f0 * tau, 1.0)))


def link(scene, tx):
    """Wavelength, power after losses, field attenuation per metre."""
    power = tx.table["power_w"] * 10 ** (-scene.radar.get("losses_db", 0.0) / 10)
    return C / scene.f0, power, 10 ** (-scene.radar.get("atmosphere_db_per_km", 0.0) / 20e3)


def scattered(scene, pair, t, polarisations, where, matrices):
    """Echoes of scatterers at where(t), of scattering matrices(ki, ks)."""
    tx, rx = (scene.antennas[name] for name in pair)
    wavelength, power, per_metre = link(scene, tx)
    tau1, tau2 = light_time(tx, rx, t, where)
    tau = tau1 + tau2
    r = rate(lambda s: np.add(*light_time(tx, rx, s, where)), t)
    reflection = where(t + tau1)
    now = np.array([t])
    ki, rt = split(reflection - tx.centre(now))
    ks, rr = split(rx.centre(t + tau) - reflection)
    scene.judge_horizon(tx.centre(now), reflection)
    scene.judge_horizon(rx.centre(t + tau), reflection)
    t_axes, r_axes = tx.axes(now), rx.axes(t + tau)
    scale = math.sqrt(power * wavelength**2 / (4 * math.pi) ** 3)
    scale = scale * tx.gain(ki, t_axes, wavelength) * rx.gain(-ks, r_axes, wavelength)
    scale = scale / (rt * rr) * per_metre ** (rt + rr)
    (vi, hi), (vs, hs) = basis(ki), basis(ks)
    s = matrices(ki, ks)
    amplitudes = []
    for receive, transmit in polarisations:
        e = tx.field(transmit, ki, t_axes, tx.centre(now))
        et = np.stack([dot(vi, e), dot(hi, e)], -1)
        e = rx.field(receive, -ks, r_axes, rx.centre(t + tau))
        er = np.stack([dot(vs, e), dot(hs, e)], -1)
        amplitudes.append(scale * np.einsum("np,npq,nq->n", er, s, et))
    return carried(scene, tau, r, amplitudes)


def of_targets(scene, pair, t, polarisations):
    where = lambda s: scene.positions + scene.velocities * s[:, None]
    return scattered(scene, pair, t, polarisations, where, lambda ki, ks: scene.matrices)


def of_sea(scene, sea, pair, t, polarisations):
    facets = sea.facets(t)
    # Straight on from where the facets are at the emission.
    where = lambda s: facets.place + facets.velocity * (s - t)[:, None]
    return scattered(scene, pair, t, polarisations, where, lambda ki, ks: sea.matrices(facets, ki, ks))


def direct(scene, pair, t, polarisations):
    tx, rx = (scene.antennas[name] for name in pair)
    wavelength, power, per_metre = link(scene, tx)
    now = np.array([t])
    tau = direct_time(tx, rx, t)
    k, distance = split(rx.centre(t + tau) - tx.centre(now))
    scene.judge_horizon(tx.centre(now), rx.centre(t + tau))
    t_axes, r_axes = tx.axes(now), rx.axes(t + tau)
    g = tx.gain(k, t_axes, wavelength) * rx.gain(-k, r_axes, wavelength)
    a = math.sqrt(power) * wavelength / (4 * math.pi) * g / distance * per_metre**distance
    at, to = tx.centre(now), rx.centre(t + tau)
    fields = [(rx.field(p[0], -k, r_axes, to), tx.field(p[1], k, t_axes, at)) for p in polarisations]
    return carried(scene, tau, rate(lambda s: direct_time(tx, rx, s), t), [a * dot(*f) for f in fields])


# ---------------------------------------------------------------- samples


def impulse_response(x):
    """h/fs at x = t fs of the receive filter: a raised cosine of 0.9 fs and roll-off 1/9."""
    z = (0.2 * x) ** 2
    pole = np.abs(1 - z) < 1e-7
    shape = np.cos(0.1 * np.pi * x) / np.where(pole, 1.0, 1 - z)
    # At z = 1 both vanish: cos(pi sqrt(z)/2)/(1 - z) -> pi/4.
    return 0.9 * np.sinc(0.9 * x) * np.where(pole, np.pi / 4, shape)


def received_pulse(scene, x, rates):
    """q at any x (in units of 1/fs after the arrival) for each of the rates: [x, rate].

    What leaves u after the beginning of the pulse arrives (1 + r) u after the beginning of the echo.
    """
    f_max = scene.bandwidth / 2 + scene.fs / 2 + np.max(np.abs(scene.f0 * rates))
    panels = max(1, math.ceil(f_max * scene.pulse_s / 4))  # 4 turns to 32 nodes: exact to 1e-15
    node, weight = np.polynomial.legendre.leggauss(32)
    edge = np.linspace(0.0, scene.pulse_s, panels + 1)
    half = np.diff(edge) / 2
    u = (edge[:-1, None] + half[:, None] * (1 + node)).ravel()
    w = (half[:, None] * weight).ravel() * scene.fs
    chirp = np.pi * scene.mu * (u - scene.pulse_s / 2) ** 2
    out = np.empty((len(x), len(rates)), complex)
    rows = max(1, 4_000_000 // len(u))
    for c, r in enumerate(rates):
        p = (1 + r) * w * np.exp(1j * (chirp - 2 * np.pi * scene.f0 * r * u))
        arrival = (1 + r) * u * scene.fs
        for a in range(0, len(x), rows):
            out[a : a + rows, c] = impulse_response(x[a : a + rows, None] - arrival[None, :]) @ p
    return out


def one_by_one(scene, echoes, x0, samples):
    """The sum over echoes with sample 0 at x0 [n] after each arrival, as it is written: [c, sample]."""
    out = np.zeros((len(echoes.amplitudes), samples), complex)
    for n, x in enumerate(x0):
        q = received_pulse(scene, x + np.arange(samples), echoes.rate[n : n + 1])[:, 0]
        out += np.multiply.outer(echoes.amplitudes[:, n], q)
    return out


# q has no frequency beyond fs/2: over a sample its phase turns by at most +-pi/2, and the Chebyshev
# coefficients fall like J_d(pi/2): J_18 is 2e-18.
TERMS = 18


def nodes(count):
    return np.cos(np.pi * (np.arange(count) + 0.5) / count)


def terms(x, count):
    """Chebyshev polynomials T_0 ... at x: [n, count]."""
    return np.cos(np.arange(count) * np.arccos(np.clip(x, -1, 1))[:, None])


def coefficients(count):
    """From values at the nodes to coefficients."""
    m = 2 / count * terms(nodes(count), count).T
    m[0] /= 2
    return m


def all_at_once(scene, echoes, x0, samples):
    """The same sum for many echoes: q is expanded in the fraction of a sample and in the rate.

    With x0 = i + (1 + xi)/2 and r = r_mid + rho r_half, q(i + j + (1 + xi)/2; r) = sum_de C[i + j, d, e]
    T_d(xi) T_e(rho): echoes are first added up by i into weights of T_d T_e, and what is left is one sum
    over i. Of one_by_one it keeps 1e-13 or so (its own test).
    """
    whole = np.floor(x0).astype(int)
    low, high = int(whole.min()), int(whole.max())
    middle = (echoes.rate.max() + echoes.rate.min()) / 2
    half = max((echoes.rate.max() - echoes.rate.min()) / 2, 1e-15)
    # exp(-j phi rho) needs terms until J_e(phi) is below the last digit.
    phi = 2 * np.pi * scene.f0 * half * scene.pulse_s
    more = 4 + math.ceil(1.5 * phi + 6 * phi ** (1 / 3))
    x = np.add.outer(np.arange(low, high + samples), (1 + nodes(TERMS)) / 2)
    table = received_pulse(scene, x.ravel(), middle + half * nodes(more)).reshape(*x.shape, more)
    table = np.einsum("df,xfg,eg->xde", coefficients(TERMS), table, coefficients(more), optimize=True)
    table = table.reshape(len(x), -1)
    t_xi = terms(2 * (x0 - whole) - 1, TERMS)
    t_rho = terms((echoes.rate - middle) / half, more)
    shares = (t_xi[:, :, None] * t_rho[:, None, :]).reshape(len(x0), -1)
    out = np.zeros((samples, len(echoes.amplitudes)), complex)
    order = np.argsort(whole, kind="stable")
    bounds = np.flatnonzero(np.diff(whole[order])) + 1
    for group in np.split(order, bounds):
        i = whole[group[0]] - low
        out += table[i : i + samples] @ (shares[group].T @ echoes.amplitudes[:, group].T)
    return out.T


def pulse(scene, sea, channels, index, window_start, samples):
    """The samples of a pulse, [channel, sample], and how many echoes met its window."""
    t = scene.emission(index)
    opens = window_start
    closes = window_start + samples / scene.fs
    out = np.zeros((len(channels), samples), complex)
    met = 0
    guard = GUARD_SAMPLES / scene.fs
    for pair in dict.fromkeys((c[0], c[1]) for c in channels):
        rows = [c for c, channel in enumerate(channels) if (channel[0], channel[1]) == pair]
        tx, rx = (scene.antennas[name] for name in pair)
        kinds = []
        if len(scene.positions):
            kinds.append((lambda s, p: of_targets(scene, pair, s, p), one_by_one))
        now = np.array([t])
        if scene.radar.get("direct_path", False) and np.any(tx.centre(now) != rx.centre(now)):
            kinds.append((lambda s, p: direct(scene, pair, s, p), one_by_one))
        if sea:
            kinds.append((lambda s, p: of_sea(scene, sea, pair, s, p), all_at_once))
        polarisations = [channels[c][2] for c in rows]
        for make, add in kinds:
            made = {index: make(t, polarisations)}
            # Emissions that may be in the window: those of the last `reach` seconds before it closes.
            reach = 1.01 * float(np.max(made[index].tau)) + 1e-5 + scene.pulse_s + guard
            m = index
            while scene.emission(m + 1) - t < closes + guard and scene.emission(m + 1) < scene.duration:
                m += 1
            while m >= 0 and scene.emission(m) - t > opens - reach:
                echoes = made[m] if m in made else make(scene.emission(m), polarisations)
                arrival = echoes.tau - (t - scene.emission(m))  # after the emission of `index`
                meets = (arrival <= closes + guard) & (arrival + scene.pulse_s >= opens - guard)
                sent = scene.sequence[m % len(scene.sequence)] if scene.sequence else None
                m -= 1
                if not np.any(meets):
                    continue
                met += int(np.sum(meets))
                part = add(scene, echoes.only(meets), (opens - arrival[meets]) * scene.fs, samples)
                for a, c in enumerate(rows):
                    if sent in (None, channels[c][2][1]):
                        out[c] += part[a]
    return out, met
