"""Wind, sea spectra, their directions and moments.

    sigma_h^2 = int int Psi dKx dKy over the whole plane,  Psi = S(K) Phi(K, phi)/K,  int Phi dphi = 1
    Phi = 1/(2 pi) + A(K) cos 2 phi, phi from the wind: the symmetrised spectrum, as scattering sees it

S in m^3, Psi in m^4, K in rad/m. Below 0.3 m/s of wind at 10 m the sea is flat.
"""

import numpy as np

G = 9.81
K_CAPILLARY = 370.0
C_CAPILLARY = 0.23
CALM_U10_MPS = 0.3


def cardone(ustar, z):
    """Neutral profile U(z) over the sea; heights in m."""
    cm = 100 * ustar
    z0 = (0.684 / cm + 4.28e-5 * cm**2 - 0.0443) / 100
    return ustar / 0.4 * np.log(z / z0)


def cardone_ustar(u, z):
    """Friction velocity that gives wind u at height z, by halving the bracket to the last digit."""
    low, high = 0.004, 3.0
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if cardone(middle, z) < u else (low, middle)
    return (low + high) / 2


def wu_ustar(u10):
    return u10 * np.sqrt((0.8 + 0.065 * u10) * 1e-3)


class Wind:
    def __init__(self, ustar):
        self.ustar = ustar
        self.u10, self.u12, self.u19 = (float(cardone(ustar, z)) for z in (10.0, 12.5, 19.5))
        self.calm = self.u10 < CALM_U10_MPS


def elfouhaily(k, u10, omega_c, ustar):
    """Bl, Bh, S and Delta of Elfouhaily et al. 1997; the low-frequency cut-off L stands on Bh too."""
    kp = G / u10**2 * omega_c**2
    c = lambda k: np.sqrt(G / k * (1 + (k / K_CAPILLARY) ** 2))
    cp = c(kp)
    omega = u10 / cp
    gamma = 1.7 if omega_c <= 1 else 1.7 + 6 * np.log10(omega_c)
    s = 0.08 * (1 + 4 * omega_c**-3)
    root = np.sqrt(k / kp) - 1
    low = np.exp(-1.25 * (kp / k) ** 2)
    peak = gamma ** np.exp(-(root**2) / (2 * s**2))
    bl = 0.5 * 6e-3 * np.sqrt(omega) * cp / c(k) * low * peak * np.exp(-omega / np.sqrt(10) * root)
    am = 0.01 * (1 + (1 if ustar < C_CAPILLARY else 3) * np.log(ustar / C_CAPILLARY))
    bh = 0.5 * max(am, 0.0) * C_CAPILLARY / c(k) * low * np.exp(-0.25 * (k / K_CAPILLARY - 1) ** 2)
    delta = np.tanh(
        np.log(2) / 4 + 4 * (c(k) / cp) ** 2.5 + 0.13 * ustar / C_CAPILLARY * (C_CAPILLARY / c(k)) ** 2.5
    )
    return bl, bh, (bl + bh) / k**3, delta


JOINT = 4.0  # rad/m, between the two branches of Fung and Lee


def fung_lee_gravity(k, u19):
    return 1.4e-3 / k**3 * np.exp(-0.74 * G**2 / (k**2 * u19**4))


def fung_lee_capillary(k, ustar):
    """In cm inside; Km = 3.63 rad/cm."""
    p = 5 - np.log10(100 * ustar)
    k = k / 100
    r = 1 + (k / 3.63) ** 2
    s = 0.875 * (2 * np.pi) ** (p - 1) * (3 * r - 2) * 981 ** ((1 - p) / 2) * (k * r) ** (-(p + 1) / 2)
    return s * 1e-6


def fung_lee(k, wind):
    return np.where(k < JOINT, fung_lee_gravity(k, wind.u19), fung_lee_capillary(k, wind.ustar))


SPREAD_M2 = 1.5e-4
TOP = 2e4  # rad/m, where the moments of the golden values end


class FungLeeSpreading:
    """A(K) = a1 (1 - exp(-b K^2)), with a1 such that the slopes have the ratio R across to along."""

    def __init__(self, wind):
        mss = lambda f: integral(lambda k: k**2 * fung_lee(k, wind) * f(k), 1e-3, TOP)
        self.mss = mss(np.ones_like)
        self.d = mss(lambda k: np.exp(-SPREAD_M2 * k**2)) / self.mss
        self.r = (3e-3 + 1.92e-3 * wind.u12) / (3.16e-3 * wind.u12)
        a1 = (1 - self.r) / (1 + self.r) / (1 - self.d) / np.pi
        self.a1 = min(max(a1, 0.0), 0.5 / np.pi)

    def second(self, k):
        return self.a1 * -np.expm1(-SPREAD_M2 * k**2)


def integral(f, low, high):
    """int f dK in ln K: Gauss-Legendre of 16 nodes on panels of 0.02 or less, broken at the joint."""
    if high <= low:
        return 0.0
    node, weight = np.polynomial.legendre.leggauss(16)
    edges = [low, *(k for k in (JOINT,) if low < k < high), high]
    total = 0.0
    for a, b in zip(np.log(edges[:-1]), np.log(edges[1:])):
        panels = int(np.ceil((b - a) / 0.02))
        half = (b - a) / panels / 2
        middle = a + half * (2 * np.arange(panels) + 1)
        # The nodes never touch an edge: each panel sees one branch.
        k = np.exp(middle[:, None] + half * node)
        total += half * np.sum(weight * f(k) * k)
    return float(total)


class Spectrum:
    def __init__(self, kind, wind, omega_c=0.84):
        self.wind = wind
        if wind.calm:
            self.s = self.second = np.zeros_like
            return
        own = lambda k: elfouhaily(k, wind.u10, omega_c, wu_ustar(wind.u10))
        self.s = (lambda k: fung_lee(k, wind)) if kind == "fung-lee" else (lambda k: own(k)[2])
        if kind == "elfouhaily":
            self.second = lambda k: own(k)[3] / (2 * np.pi)
        else:
            self.second = FungLeeSpreading(wind).second

    def psi(self, ku, kc):
        """Psi_sym at wave vectors along and across the wind; 0 at the origin."""
        k = np.hypot(ku, kc)
        none = k < 1e-9
        k = np.where(none, 1.0, k)
        directional = 1 / (2 * np.pi) + self.second(k) * (ku**2 - kc**2) / k**2
        return np.where(none, 0.0, self.s(k) * directional / k)

    def slope_variances(self, low, high):
        """Along and across the wind, of the waves of low < |K| < high."""
        half = integral(lambda k: k**2 * self.s(k), low, high) / 2
        uneven = integral(lambda k: k**2 * self.s(k) * self.second(k), low, high) * np.pi / 2
        return half + uneven, half - uneven

    def height_variance(self, low, high=TOP):
        return integral(self.s, low, high)

    def peak(self):
        k = np.geomspace(1e-4, 10.0, 200_001)
        return float(k[np.argmax(self.s(k))])
