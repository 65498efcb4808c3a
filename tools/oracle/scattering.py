"""Permittivity of sea water; Bragg and specular scattering of a facet. Time convention exp(+j w t).

Matrices are [n, 2, 2], receive then transmit, in the order v, h of the bases h = z x k/|z x k|, v = h x k
of the directions of propagation. Squared moduli are sigma0 per true area of the facet. Unit vectors: ki from
the transmitter, ks to the receiver, n the normal, ex and ey = n x ex the axes of the facet.
"""

import numpy as np

from .frames import basis, dot

EPS0 = 8.8541878128e-12


def meissner_wentz(f_hz, t, s):
    """Double Debye fit of 2012."""
    f = f_hz * 1e-9
    e0 = (3.70886e4 - 82.168 * t) / (421.854 + t)
    e1 = 5.7230 + 2.2379e-2 * t - 7.1237e-4 * t**2
    n1 = (45 + t) / (5.0478 - 7.0315e-2 * t + 6.0059e-4 * t**2)
    e2 = 3.6143 + 2.8841e-2 * t
    n2 = (45 + t) / (0.13652 + 1.4825e-3 * t + 2.4166e-4 * t**2)
    sigma35 = 2.903602 + 8.607e-2 * t + 4.738817e-4 * t**2 - 2.991e-6 * t**3 + 4.3047e-9 * t**4
    r15 = s * (37.5109 + 5.45216 * s + 1.4409e-2 * s**2) / (1004.75 + 182.283 * s + s**2)
    al0 = (6.9431 + 3.2841 * s - 9.9486e-2 * s**2) / (84.850 + 69.024 * s + s**2)
    al1 = 49.843 - 0.2276 * s + 1.98e-3 * s**2
    sigma = sigma35 * r15 * (1 + (t - 15) * al0 / (al1 + t))
    e0 *= np.exp(-3.3330e-3 * s + 4.74868e-6 * s**2)
    e1 *= np.exp(-6.28908e-3 * s + 1.76032e-4 * s**2 - 9.22144e-5 * s * t)
    if t <= 30:
        n1 *= 1 + s * (2.3232e-3 - 7.9208e-5 * t + 3.6764e-6 * t**2 - 3.5594e-7 * t**3 + 8.9795e-9 * t**4)
    else:
        n1 *= 1 + s * (9.1873715e-4 + 1.5012396e-4 * (t - 30))
    n2 *= 1 + s * (-1.99723e-2 + 9.0588e-5 * (t + 30))
    e2 *= 1 + s * (-2.04265e-3 + 1.57883e-4 * t)
    loss = sigma / (2 * np.pi * EPS0 * f_hz)
    return (e0 - e1) / (1 + 1j * f / n1) + (e1 - e2) / (1 + 1j * f / n2) + e2 - 1j * loss


def klein_swift(f_hz, t, s):
    """Single Debye fit of 1977."""
    es = 87.134 - 0.1949 * t - 1.276e-2 * t**2 + 2.491e-4 * t**3
    es *= 1 + 1.613e-5 * s * t - 3.656e-3 * s + 3.210e-5 * s**2 - 4.232e-7 * s**3
    tau = 1.768e-11 - 6.086e-13 * t + 1.104e-14 * t**2 - 8.111e-17 * t**3
    tau *= 1 + 2.282e-5 * s * t - 7.638e-4 * s - 7.760e-6 * s**2 + 1.105e-8 * s**3
    d = 25 - t
    b = 2.033e-2 + 1.266e-4 * d + 2.464e-6 * d**2 - s * (1.849e-5 - 2.551e-7 * d + 2.551e-8 * d**2)
    sigma = s * (0.182521 - 1.46192e-3 * s + 2.09324e-5 * s**2 - 1.28205e-7 * s**3) * np.exp(-d * b)
    w = 2 * np.pi * f_hz
    return 4.9 + (es - 4.9) / (1 + 1j * w * tau) - 1j * sigma / (w * EPS0)


def root(eps, sine2):
    """sqrt(eps - sin^2) on the branch that decays downwards: Im <= 0."""
    r = np.sqrt(eps - sine2 + 0j)
    return np.where(r.imag > 0, -r, r)


def fresnel(eps, cosine):
    r = root(eps, 1 - cosine**2)
    return (eps * cosine - r) / (eps * cosine + r), (cosine - r) / (cosine + r)


def alpha(eps, ci, cs, si, ss, cosine, sine):
    """Bragg amplitudes of first order in the facet's own bases; cosine and sine of phi_s - phi_i."""
    ri, rs = root(eps, si**2), root(eps, ss**2)
    vi, vs, hi, hs = eps * ci + ri, eps * cs + rs, ci + ri, cs + rs
    vv = (eps * si * ss - cosine * ri * rs) / (vi * vs)
    vh = rs * sine / (hi * vs)
    hv = ri * sine / (vi * hs)
    hh = cosine / (hi * hs)
    return (eps - 1) * np.stack([np.stack([vv, vh], -1), np.stack([hv, hh], -1)], -2)


def bragg_vector(ki, ks, k, ex, ey):
    """K_B along the axes of the facet, rad/m."""
    q = k * (ks - ki)
    return dot(q, ex), dot(q, ey)


def bragg(ki, ks, n, k, eps, psi):
    """Amplitude matrix of Bragg scattering over the horizon's bases; psi = Psi_sym(K_B) in m^4. Lit facets only."""
    ci, cs = -dot(ki, n), dot(ks, n)
    vi, hi = basis(ki, n)
    vs, hs = basis(ks, n)
    # h = (-sin phi, cos phi, 0): the angle between the h's is that between the directions.
    cosine, sine = dot(hi, hs), dot(np.cross(hi, hs), n)
    a = alpha(
        eps,
        ci,
        cs,
        np.linalg.norm(np.cross(n, ki), axis=-1),
        np.linalg.norm(np.cross(n, ks), axis=-1),
        cosine,
        sine,
    )
    a = (4 * np.sqrt(np.pi) * k**2 * ci * cs * np.sqrt(psi))[:, None, None] * a
    return rotation(vs, hs, ks).swapaxes(1, 2) @ a @ rotation(vi, hi, ki)


def rotation(v_local, h_local, k):
    """[[v'.v, v'.h], [h'.v, h'.h]]."""
    v, h = basis(k)
    return np.stack(
        [
            np.stack([dot(v_local, v), dot(v_local, h)], -1),
            np.stack([dot(h_local, v), dot(h_local, h)], -1),
        ],
        -2,
    )


def specular_slopes(ki, ks, n, ex, ey):
    """Slopes relative to the facet of the mirror from ki to ks; q_n; whether there is one."""
    q = ks - ki
    length, qn = np.linalg.norm(q, axis=-1), dot(q, n)
    there = (length >= 1e-6) & (qn > 1e-6 * length)
    qn = np.where(there, qn, 1.0)
    return -dot(q, ex) / qn, -dot(q, ey) / qn, qn, there


def specular(ki, ks, qn, eps, density):
    """Amplitude matrix rho sqrt(pi p) (|q|/q_n)^2 of mirrors of the slope density p."""
    q = ks - ki
    length = np.linalg.norm(q, axis=-1)
    m = q / np.where(length < 1e-6, 1.0, length)[:, None]
    t = np.cross(m, ki)
    norm = np.linalg.norm(t, axis=-1, keepdims=True)
    (vi, hi), (vs, hs) = basis(ki), basis(ks)
    t = np.where(norm < 1e-12, hi, t / np.where(norm < 1e-12, 1.0, norm))
    wi, ws = np.cross(t, ki), np.cross(t, ks)
    rv, rh = fresnel(eps, length / 2)
    rho = [[rh * dot(p, t) * dot(q, t) + rv * dot(p, ws) * dot(q, wi) for q in (vi, hi)] for p in (vs, hs)]
    scale = np.sqrt(np.pi * density) * (length / qn) ** 2
    return np.moveaxis(np.array(rho), -1, 0) * scale[:, None, None]


SLOPE_FLOOR = 1e-5


def cox_munk(u12):
    """Slope variances of a clean sea, along and across the wind."""
    return max(3.16e-3 * u12, SLOPE_FLOOR), 3e-3 + 1.92e-3 * u12


def slope_density(zu, zc, su2, sc2, skewed_at_u12=None):
    """Density of the slopes downwind and across; with the Gram-Charlier terms of a clean sea where asked."""
    e, x = -zu / np.sqrt(su2), zc / np.sqrt(sc2)
    p = np.exp(-(e**2 + x**2) / 2) / (2 * np.pi * np.sqrt(su2 * sc2))
    if skewed_at_u12 is None:
        return p
    c21, c03 = 0.01 - 0.0086 * skewed_at_u12, 0.04 - 0.033 * skewed_at_u12
    series = 1 - c21 / 2 * (x**2 - 1) * e - c03 / 6 * (e**3 - 3 * e)
    series = series + 0.40 / 24 * (x**4 - 6 * x**2 + 3) + 0.12 / 4 * (x**2 - 1) * (e**2 - 1)
    series = series + 0.23 / 24 * (e**4 - 6 * e**2 + 3)
    return np.maximum(p * series, 0.0)


def taper(k, cut):
    """Raised cosine in log K, 0 to 1 over the octave about the cut; of the spectrum, not of the amplitude."""
    s = np.clip(np.log2(np.maximum(k, 1e-300) / cut) + 0.5, 0.0, 1.0)
    return (1 - np.cos(np.pi * s)) / 2
