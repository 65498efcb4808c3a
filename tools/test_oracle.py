#!/usr/bin/env python3
"""Parts of the oracle against golden values, published vectors and plain sums."""

import csv
import json
import math
import os
import sys
import tomllib
import unittest
from pathlib import Path
from types import SimpleNamespace

try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(0)

from oracle import scattering as sc
from oracle import spectra
from oracle.echo import Echoes, all_at_once, light_time, one_by_one, pulse, rate, received_pulse
from oracle.frames import UP, Unfit, dot, unit
from oracle.scene import Antenna, Scene, Track
from oracle.sea import Sea, Surface
from oracle.streams import block, uniform

GOLDEN = Path(os.environ.get("NEREUS_GOLDEN", Path(__file__).parent.parent / "tests/data/golden"))
# The golden values carry 13 digits.
PRINTED = 1e-11


def golden(name):
    with open(GOLDEN / f"{name}.csv") as file:
        rows = list(csv.DictReader(file))
    return SimpleNamespace(**{key.split("=")[0]: np.array([float(r[key]) for r in rows]) for key in rows[0]})


def cells(*columns):
    return zip(*columns)


class Judge(unittest.TestCase):
    def near(self, got, want, rel, floor=0.0):
        got, want = np.asarray(got), np.asarray(want)
        error = np.abs(got - want) / np.maximum(np.abs(want), floor if floor else 1e-300)
        error = np.where((got == 0) & (want == 0), 0.0, error)
        self.assertLessEqual(np.max(error), rel, f"at {np.argmax(error)}: {got.flat[np.argmax(error)]}")


class Streams(Judge):
    def test_published_key_streams(self):
        # RFC 7539, A.1 number 1 (20 rounds); draft-strombergson-chacha-test-vectors, TC1 (8 rounds): zero keys.
        for rounds, text in (
            (20, "76b8e0ada0f13d90405d6ae55386bd28bdd219b8a08ded1aa836efcc8b770dc7"),
            (8, "3e00ef2f895f40d67f5bb8e81f09a5a12c840ec3ce9a7f3b181be188ef711a1e"),
        ):
            made = block(np.zeros((8, 1), np.uint32), rounds)[:8, 0].astype("<u4").tobytes()
            self.assertEqual(made.hex(), text)

    def test_streams_have_addresses(self):
        row = uniform(7, 16, np.array([-3, -2, 5]), np.array([4, -9, 0]), 8)
        self.assertEqual(row.shape, (8, 3))
        self.assertTrue(np.all((row >= 0) & (row < 1)))
        for n, address in enumerate([(-3, 4), (-2, -9), (5, 0)]):
            np.testing.assert_array_equal(row[:, n], uniform(7, 16, *map(np.array, address), 8)[:, 0])
        self.assertEqual(len(np.unique(row)), row.size)


class Water(Judge):
    def test_permittivity(self):
        g = golden("permittivity")
        for f, t, s, *want in cells(g.f_hz, g.T_c, g.S_psu, g.mw_re, g.mw_im, g.ks_re, g.ks_im):
            mw, ks = sc.meissner_wentz(f, t, s), sc.klein_swift(f, t, s)
            self.near([mw.real, mw.imag, ks.real, ks.imag], want, PRINTED)

    def test_fresnel(self):
        g = golden("fresnel")
        for f, t, s, theta, a, b, c, d in cells(
            g.f_hz, g.T_c, g.S_psu, g.theta_deg, g.rv_re, g.rv_im, g.rh_re, g.rh_im
        ):
            rv, rh = sc.fresnel(sc.meissner_wentz(f, t, s), np.cos(np.radians([theta])))
            # Near Brewster's angle eps c - r is a difference of numbers of the size of eps c.
            self.near([rv[0], rh[0]], [a + 1j * b, c + 1j * d], PRINTED)

    def test_wind(self):
        g = golden("wind")
        for z, want in ((10.0, g.U10_m_s), (12.5, g.U12p5_m_s), (19.5, g.U19p5_m_s)):
            self.near(spectra.cardone(g.ustar_m_s, z), want, PRINTED)
        g = golden("wind_inverse")
        ustar = np.array([spectra.cardone_ustar(u, 19.5) for u in g.U19p5_m_s])
        self.near(ustar, g.ustar_cardone_m_s, PRINTED)
        self.near(spectra.cardone(ustar, 10.0), g.U10_m_s, PRINTED)
        self.near(spectra.wu_ustar(spectra.cardone(ustar, 10.0)), g.ustar_wu_of_U10_m_s, PRINTED)


def of_u10(kind, u10, omega_c=0.84):
    wind = SimpleNamespace(u10=u10, calm=False)
    return spectra.Spectrum(kind, wind, omega_c)


class Spectra(Judge):
    def test_elfouhaily(self):
        g = golden("spectrum_elfouhaily")
        for u10, omega_c, ustar, k, *want in cells(
            g.U10_m_s,
            g.Omega_c,
            g.ustar_m_s,
            g.K_rad_m,
            g.Bl,
            g.Bh,
            g.S_m3,
            g.Delta,
            g.Psi_down_m4,
            g.Psi_cross_m4,
        ):
            self.near(spectra.wu_ustar(u10), ustar, PRINTED)
            got = spectra.elfouhaily(k, u10, omega_c, ustar)
            # Exponents of up to 300: a digit of the exponent is 300 of the value.
            self.near(got, want[:4], 300 * PRINTED, 1e-290)
            s = of_u10("elfouhaily", u10, omega_c)
            zero, k = np.zeros(1), np.array([k])
            # Across, 1 - Delta of a Delta of 0.99.. is left: its digits are those of Delta.
            self.near(s.psi(k, zero), want[4], 300 * PRINTED, 1e-290)
            self.near(s.psi(zero, k), want[5], 300 * PRINTED, want[4] + 1e-290)

    def test_moments(self):
        # The golden integrals are Simpson sums good to 1e-6.
        g = golden("spectrum_moments")
        for u10, low, high, hs, total, up, cross in cells(
            g.U10_m_s, g.K_lo, g.K_hi, g.Hs_m, g.mss_total, g.mss_up, g.mss_cross
        ):
            s = of_u10("elfouhaily", u10)
            self.near(4 * math.sqrt(s.height_variance(low, high)), hs, 1e-6)
            along, across = s.slope_variances(low, high)
            self.near([along + across, along, across], [total, up, cross], 1e-6)

    def test_slopes_are_moments_of_psi(self):
        s = spectra.Spectrum("fung-lee", spectra.Wind(0.36))
        phi = 2 * np.pi * np.arange(64) / 64

        def moment(f):
            ring = lambda k: np.mean(
                2 * np.pi * k**2 * f(phi) ** 2 * k * s.psi(k * np.cos(phi), k * np.sin(phi))
            )
            return spectra.integral(lambda k: np.vectorize(ring)(k), 3.0, 70.0)

        # 64 points take every harmonic of Psi; the sums themselves are rounding.
        self.near([moment(np.cos), moment(np.sin)], s.slope_variances(3.0, 70.0), 1e-12)

    def test_fung_lee(self):
        g = golden("spectrum_fung_lee_pm")
        for u19, ustar, k, gravity, capillary in cells(
            g.U19p5_m_s, g.ustar_m_s, g.K_rad_m, g.S_grav_m3, g.S_cap_m3
        ):
            self.near(spectra.fung_lee_gravity(k, u19), gravity, 1000 * PRINTED, 1e-290)
            self.near(spectra.fung_lee_capillary(k, ustar), capillary, PRINTED)

    def test_fung_lee_spreading(self):
        g = golden("spreading_fung_lee")
        for u12, ustar, mss, d, r, a1, k, phi, want in cells(
            g.U12p5_m_s, g.ustar, g.mss, g.D, g.R, g.a1, g.K_rad_m, g.phi_deg, g.Phi
        ):
            s = spectra.FungLeeSpreading(spectra.Wind(spectra.cardone_ustar(u12, 12.5)))
            # The golden mss is a trapezoid sum across the joint: 1e-4 asked, half a step of 4e-4 times
            # the jump of 1 % of K^3 S there to be expected.
            self.near([s.mss, s.d, s.r, s.a1], [mss, d, r, a1], 1e-5)
            got = 1 / (2 * np.pi) + s.second(k) * np.cos(2 * np.radians(phi))
            self.near(got, want, 1e-5)

    def test_calm_is_flat(self):
        s = spectra.Spectrum("elfouhaily", spectra.Wind(0.01))
        self.assertEqual(float(s.psi(np.array([3.0]), np.array([1.0]))[0]), 0.0)
        self.assertEqual(s.slope_variances(1.0, 70.0), (0.0, 0.0))


def towards(theta, phi):
    return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


class Scattering(Judge):
    def test_alpha(self):
        g = golden("spm_alpha")
        for re, im, ti, ts, phi, *want in cells(
            g.eps_re, g.eps_im, g.thi_deg, g.ths_deg, g.dphi_deg,
            g.vv_re, g.vv_im, g.vh_re, g.vh_im, g.hv_re, g.hv_im, g.hh_re, g.hh_im,
        ):  # fmt: skip
            ti, ts, phi = (np.radians([a]) for a in (ti, ts, phi))
            a = sc.alpha(
                re + 1j * im, np.cos(ti), np.cos(ts), np.sin(ti), np.sin(ts), np.cos(phi), np.sin(phi)
            )
            want = np.array(want).reshape(4, 2) @ [1, 1j]
            # eps is printed with 13 digits; sin(180 deg) is 1e-16.
            self.near(a.ravel(), want, 10 * PRINTED, np.max(np.abs(want)))

    def test_facets(self):
        g = golden("facet_scatter")
        spm = [getattr(g, f"spm_{p}_{c}") for p in ("vv", "vh", "hv", "hh") for c in ("re", "im")]
        glint = [getattr(g, f"go_sigma0_{p}") for p in ("vv", "vh", "hv", "hh")]
        for f, u, phiw, ti, ts, phi, zx, zy, *want in cells(
            g.f_hz, g.U10_elf_U12p5_coxmunk, g.phiw_deg, g.thi_deg, g.ths_deg, g.dphi_deg, g.slope_x, g.slope_y,
            *spm, *glint,
        ):  # fmt: skip
            ti, ts, phi, phiw = (math.radians(a) for a in (ti, ts, phi, phiw))
            ki = -towards(ti, math.pi)[None]  # azimuth 0
            ks = towards(ts, phi)[None]
            n = np.array([[-zx, -zy, 1.0]])
            n = n / np.linalg.norm(n)
            x = np.array([1.0, 0.0, 0.0])
            ex = x - (n @ x)[:, None] * n
            ex = ex / np.linalg.norm(ex)
            ey = np.cross(n, ex)
            self.assertTrue(-np.sum(ki * n) > 0 and np.sum(ks * n) > 0)
            turned = lambda a, b: (
                a * math.cos(phiw) + b * math.sin(phiw),
                b * math.cos(phiw) - a * math.sin(phiw),
            )
            k = 2 * math.pi * f / 299_792_458.0
            eps = sc.meissner_wentz(f, 20.0, 35.0)
            kx, ky = sc.bragg_vector(ki, ks, k, ex, ey)
            spectrum = of_u10("elfouhaily", u)
            # Mirror directions: K_B is rounding, and so is what the golden file has.
            if np.hypot(kx, ky)[0] > 1e-6:
                amplitude = sc.bragg(ki, ks, n, k, eps, spectrum.psi(*turned(kx, ky)))
                spm = np.array(want[:8]).reshape(4, 2) @ [1, 1j]
                self.near(amplitude.ravel(), spm, 1e-8, np.max(np.abs(spm)))
            zu, zc, qn, there = sc.specular_slopes(ki, ks, n, ex, ey)
            self.assertTrue(there[0])
            density = sc.slope_density(*turned(zu, zc), *sc.cox_munk(u))
            amplitude = sc.specular(ki, ks, qn, eps, density)
            sigma = np.array(want[8:])
            self.near(np.abs(amplitude.ravel()) ** 2, sigma, 1e-8, np.max(sigma) + 1e-280)

    def test_slope_density(self):
        g = golden("slope_pdf")
        clean = [
            row for row in cells(g.slick, g.U12p5, g.skew, g.zx_downwind, g.zy_cross, g.pdf) if row[0] == 0
        ]
        self.assertGreaterEqual(len(clean), 50)
        for _, u, skew, zx, zy, want in clean:
            # Exponents of some tens.
            self.near(
                sc.slope_density(zx, zy, *sc.cox_munk(u), u if skew else None), want, 100 * PRINTED, 1e-290
            )

    def test_reciprocity(self):
        # S[p, q](ks, ki) = s_p s_q S[q, p](-ki, -ks), s_v = 1, s_h = -1, whatever the tilt.
        ki, ks = -towards(0.7, 2.9)[None], towards(0.5, 0.4)[None]
        n = np.array([[-0.1, 0.2, 1.0]]) / math.sqrt(1.05)
        eps = 55 - 38j
        sign = np.outer([1, -1], [1, -1])
        there = sc.bragg(ki, ks, n, 200.0, eps, np.ones(1))
        back = sc.bragg(-ks, -ki, n, 200.0, eps, np.ones(1))
        self.near(there[0], sign * back[0].T, 1e-13, np.max(np.abs(there)))
        qn = np.sum((ks - ki) * n, axis=-1)
        there, back = sc.specular(ki, ks, qn, eps, np.ones(1)), sc.specular(-ks, -ki, qn, eps, np.ones(1))
        self.near(there[0], sign * back[0].T, 1e-13, np.max(np.abs(there)))

    def test_taper(self):
        self.near(
            sc.taper(70.0 * np.array([0.5**0.5, 1.0, 2**0.5, 9.0, 0.1]), 70.0), [0, 0.5, 1, 1, 0], 1e-12, 1.0
        )


class Moving(Judge):
    def surface(self, nx=12, ny=9, wind_rad=0.5, **more):
        spectrum = spectra.Spectrum("elfouhaily", spectra.Wind(0.36))
        return Surface(nx, ny, 2.0, spectrum, wind_rad, 5, **more)

    def test_fields_are_real_plain_sums(self):
        s = self.surface()
        nx, ny = s.shape
        x, y = np.meshgrid(2.0 * np.arange(nx), 2.0 * np.arange(ny), indexing="ij")
        fields = s.fields(3.7)
        for name, h in s.coefficients(3.7).items():
            plain = np.zeros((nx, ny), complex)
            for kx, ky, c in zip(s.kx.ravel(), s.ky.ravel(), h.ravel()):
                plain += c * np.exp(1j * (kx * x + ky * y))
            # 108 terms of rounding each.
            scale = np.max(np.abs(plain))
            self.assertGreater(scale, 0.01, name)
            self.near(plain.imag + 1.0, 1.0, 1e-13 * scale / min(scale, 1.0))
            self.near(fields[name], plain.real, 1e-12, scale)

    def test_velocities_are_derivatives(self):
        s, t, step = self.surface(capillary=True, depth_m=8.0), 11.0, 1e-3
        f = {k: s.fields(t + k * step) for k in (-2, -1, 0, 1, 2)}
        for place, speed in (("z", "uz"), ("dx", "ux"), ("dy", "uy")):
            slope = 8 * (f[1][place] - f[-1][place]) - (f[2][place] - f[-2][place])
            # Fourth order: (w step)^4/30 with w < 5 rad/s; rounding 1e-16 m/step.
            self.near(slope / (12 * step), f[0][speed], 1e-11, np.max(np.abs(f[0][speed])))

    def test_waves_go_with_the_wind_and_disperse(self):
        s = self.surface(wind_rad=0.3)
        h0, h1 = (s.coefficients(t)["z"] for t in (0.0, 0.05))
        moving = s.kx * math.cos(0.3) + s.ky * math.sin(0.3) > 0
        alive = (np.abs(h0) > 0) & moving
        self.assertGreater(np.sum(alive), 30)
        turn = np.angle(h1[alive] / h0[alive])
        self.near(turn, -np.sqrt(9.81 * np.hypot(s.kx, s.ky)[alive]) * 0.05, 1e-12, 1.0)

    def test_variance_is_that_of_the_spectrum(self):
        spectrum = spectra.Spectrum("elfouhaily", spectra.Wind(0.36))
        got, count = 0.0, 60
        for seed in range(count):
            s = Surface(48, 48, 4.0, spectrum, 0.5, seed)
            got += np.mean(s.fields(0.0)["z"] ** 2) / count
        k = s.kx, s.ky
        ku = k[0] * math.cos(0.5) + k[1] * math.sin(0.5)
        kc = k[1] * math.cos(0.5) - k[0] * math.sin(0.5)
        power = np.where(np.abs(s.a) > 0, 2 * spectrum.psi(ku, kc) * s.kx[1, 0] ** 2, 0.0)
        # Each mode's power is exponential: the deviation of the mean over seeds; four of them allowed.
        self.near(got, np.sum(power), 4 * math.sqrt(np.sum(power**2) / count) / np.sum(power))

    def test_across_the_wind_is_half_and_half(self):
        # Wind to the North: cos(90 deg) is 6e-17 here, and the waves along x get the symmetric spectrum.
        s = self.surface(8, 8, math.radians(90.0))
        self.assertTrue(np.all(np.abs(s.a[1:4, 0]) > 0) and np.all(np.abs(s.a[5:, 0]) > 0))
        self.assertTrue(np.all(s.a[:, 5:] == 0) and np.all(np.abs(s.a[1:4, 1:4]) > 0))
        self.assertTrue(np.all(s.a[4] == 0) and np.all(s.a[:, 4] == 0) and s.a[0, 0] == 0)


SCENARIO = """
[scene]
duration_s = 1.0
facet_m = 1.0
patch_size_m = [16.0, 12.0]
[sea]
wind_ustar_mps = 0.36
wind_towards_deg = 30.0
spectrum = "elfouhaily-fung-lee"
averaging = "points"
[sea.scattering]
tilt_average = false
light_wind = "published"
bragg = "frozen"
[sea.shadow]
enabled = false
[radar]
carrier_hz = 10e9
sample_rate_hz = 100e6
prf_hz = 222.0
waveform = { kind = "lfm", bandwidth_hz = 60e6, pulse_s = 0.333e-6 }
[[transmitter]]
name = "tx"
platform = "aircraft"
power_w = 1.0
antenna = { kind = "rectangle", width_m = 4.0, height_m = 0.05 }
pointing = { kind = "beside", platform = "aircraft", across_m = -3000.0 }
[[receiver]]
name = "rx"
platform = "aircraft"
antenna = { kind = "rectangle", width_m = 4.0, height_m = 0.05 }
pointing = { kind = "beside", platform = "aircraft", across_m = -3000.0 }
"""
CHANNELS = [("tx", "rx", p) for p in ("HH", "HV", "VH", "VV")]


def scene_of(*changes):
    text = SCENARIO
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    config = tomllib.loads(text)
    t = np.arange(4) / 222.0
    p = np.array([0.0, -3000.0, 3000.0]) + np.outer(t, [222.0, 0.0, 0.0])
    # Body x East, y South, z down.
    q = np.tile([0.0, 1.0, 0.0, 0.0], (4, 1))
    track = Track(t, p, np.tile([222.0, 0.0, 0.0], (4, 1)), q)
    scene = Scene(config, {"aircraft": {"true": track, "reported": track}}, CHANNELS)
    return scene, Sea(config, scene, 7)


class Bases(Judge):
    """Vectors of H and V across a ray: what any basis is, and what makes these two."""

    def antenna(self, kind, radius=math.inf):
        antenna = Antenna.__new__(Antenna)
        antenna.pattern, antenna.scene, antenna.leak = {"kind": kind}, SimpleNamespace(radius=radius), 0.0
        return antenna

    def test_bases_are_unit_orthogonal_and_those_of_the_boresight(self):
        rng = np.random.default_rng(3)
        k = unit(rng.normal(size=(200, 3)))
        axes, centre = np.eye(3)[None], np.zeros((1, 3))
        for kind in ("isotropic", "rectangle"):
            h, v = self.antenna(kind).basis(k, axes, centre)
            for a, b, want in ((h, h, 1), (v, v, 1), (h, v, 0), (h, k, 0), (v, k, 0)):
                self.near(1 + dot(a, b), np.full(200, 1.0 + want), 1e-12)
            self.near(2 + np.cross(k, h), 2 + v, 1e-12)
            h, v = self.antenna(kind).basis(np.array([[1.0, 0.0, 0.0]]), axes, centre)
            self.near(h, [[0.0, 1.0, 0.0]], 1e-15, 1.0)
            self.near(v, [[0.0, 0.0, 1.0]], 1e-15, 1.0)

    def test_ludwig_s_third_definition_follows_great_circles(self):
        # Carried along the great circle from the boresight, a vector keeps its angle to that circle.
        rng = np.random.default_rng(4)
        k = unit(rng.normal(size=(200, 3)))
        h, _ = self.antenna("rectangle").basis(k, np.eye(3)[None], np.zeros((1, 3)))
        x = np.array([1.0, 0.0, 0.0])
        normal = unit(np.cross(x, k))
        self.near(2 + dot(h, normal), 2 + normal[:, 1], 1e-12)
        self.near(2 + dot(h, np.cross(normal, k)), 2 + np.cross(normal, x)[:, 1], 1e-12)

    def test_isotropic_antennas_are_level_where_they_are(self):
        rng = np.random.default_rng(5)
        k, centre = unit(rng.normal(size=(200, 3))), np.array([[4e5, -2e5, 5e5]])
        h, v = self.antenna("isotropic", 6.371e6).basis(k, np.eye(3)[None], centre)
        up = unit(centre + np.array([0.0, 0.0, 6.371e6]))
        self.near(1 + dot(h, up), np.ones(200), 1e-12)
        self.assertGreater(np.min(dot(v, up)), 0.0)


class GoldenEchoes(Judge):
    def scene(self):
        with open(GOLDEN / "echo_scene.json") as file:
            g = json.load(file)
        ends = [
            SimpleNamespace(centre=lambda t, p=np.array(g[p]), v=np.array(g["v" + p]): p + np.outer(t, v))
            for p in ("tx", "rx")
        ]
        place, velocity = (np.array([s[k] for s in g["scat"]]) for k in (0, 1))
        return g, ends, lambda t: place + velocity * t[:, None]

    def test_delays_and_rates(self):
        g, (tx, rx), where = self.scene()
        rows = golden("echo_delays")
        for pulse in np.unique(rows.pulse):
            of = rows.pulse == pulse
            t = pulse / g["prf"]
            tau1, tau2 = light_time(tx, rx, t, where)
            # Printed are 13 digits of 24 us: 1e-17 s.
            self.assertLess(np.max(np.abs(tau1 + tau2 - rows.tau_exact_s[of])), 1e-17)
            self.assertLess(np.max(np.abs(tau1 - rows.tau_tx_leg_s[of])), 1e-17)
            r = rate(lambda s: np.add(*light_time(tx, rx, s, where)), t)
            # A digit of 24 us (4e-21 s) over a step of 1 ms, and the golden difference: 1e-9 of v/c = 1e-6.
            self.assertLess(np.max(np.abs(r - rows.dtau_dt[of])), 1e-15)

    def test_samples(self):
        # The golden samples repeat every N, without Doppler in the pulse: fold so many periods of ours.
        # The filter rings off like 1/x^3: beyond 8 periods there is 1e-9 of it, of changing sign.
        g, (tx, rx), where = self.scene()
        rows, n, periods = golden("echo_refB_filtered"), g["N"], 8
        scene = SimpleNamespace(
            f0=g["f0"], fs=g["fs"], bandwidth=g["B"], pulse_s=g["Tc"], mu=g["B"] / g["Tc"]
        )
        for pulse in (0, 499):
            tau = np.add(*light_time(tx, rx, pulse / g["prf"], where))
            a = (
                np.array([s[2] for s in g["scat"]])
                @ [1, 1j]
                * np.exp(-2j * np.pi * np.mod(g["f0"] * tau, 1.0))
            )
            x0 = (g["t0"] - tau) * g["fs"] - periods * n
            out = one_by_one(scene, Echoes(tau, 0 * tau, a[None]), x0, (2 * periods + 1) * n)
            of = rows.pulse == pulse
            want = rows.re[of] + 1j * rows.im[of]
            # f0 tau is 2.4e5 turns in f64: 4e-11 turns each.
            self.near(out.reshape(-1, n).sum(axis=0), want, 1e-9, np.max(np.abs(want)))

    def test_motion_stretches_the_pulse(self):
        # A delay of rate r makes of a chirp another one, (1 + r) as long and of a rate mu/(1 + r)^2, with a
        # Doppler shift of -f0 r/(1 + r): the same as one that hardly moves, on a carrier of 2^50 Doppler shifts.
        still = 2.0**-50
        for f0, fs, bandwidth, pulse_s, r in (
            (35e9, 250e6, 200e6, 20e-6, 2.8e-5),
            (10e9, 200e6, 164e6, 50e-6, -1.5e-6),
            (10e9, 100e6, 60e6, 0.333e-6, 5e-5),
        ):
            moves = SimpleNamespace(
                f0=f0, fs=fs, bandwidth=bandwidth, pulse_s=pulse_s, mu=bandwidth / pulse_s
            )
            stretch = 1 + r
            rests = SimpleNamespace(
                f0=f0 * r / stretch / still,
                fs=fs,
                bandwidth=bandwidth / stretch,
                pulse_s=stretch * pulse_s,
                mu=moves.mu / stretch**2,
            )
            x = np.linspace(-3.7, pulse_s * fs + 3.7, 40)
            got = received_pulse(moves, x, np.array([r]))
            want = received_pulse(rests, x, np.array([still]))
            # Left is its own stretch, 2 pi B Tc 2^-50 = 5e-11; phases of 1e4 turns of the chirp, in f64.
            self.near(got, want, 1e-9, np.max(np.abs(want)))


class Whole(Judge):
    def test_the_sum_over_facets(self):
        scene, sea = scene_of()
        rng = np.random.default_rng(1)
        n, samples = 300, 80
        a = rng.normal(size=(2, n)) + 1j * rng.normal(size=(2, n))
        x0 = rng.uniform(-70, 40, n)
        x0[:3] = -7.0, 11.0, 11.0 - 1e-13
        for spread in (0.0, 1e-7, 3e-4):  # 3e-4 turns the pulse by a whole turn from end to end
            echoes = Echoes(0 * x0, -3e-7 + spread * rng.uniform(-1, 1, n), a)
            plain, fast = one_by_one(scene, echoes, x0, samples), all_at_once(scene, echoes, x0, samples)
            # 1e-15 of table values, times the Lebesgue constants of two expansions, over 300 echoes.
            self.near(fast, plain, 1e-12, np.max(np.abs(plain)))

    def test_a_pulse_is_that_of_its_facets(self):
        # One facet of a flat sea: sigma0 of the golden kind, by hand.
        scene, sea = scene_of(("0.36", "0.005"), ("[16.0, 12.0]", "[1.0, 1.0]"))
        self.assertTrue(sea.wind.calm)
        facets = sea.facets(0.0)
        self.assertTrue(np.all(facets.place == 0) and np.all(facets.n == UP) and facets.area[0] == 1.0)
        self.assertEqual(sea.slopes, [1e-5, 1e-5])
        down, up = np.array([[0.0, 0.0, -1.0]]), np.array([[0.0, 0.0, 1.0]])
        sea.shadows = False
        s = sea.matrices(facets, down, up)[0]
        # sigma0 = |R(0)|^2/(2 s^2) of a floor of slopes.
        rv, rh = sc.fresnel(sea.eps, np.ones(1))
        self.near(np.abs(s[0, 0]) ** 2, np.abs(rv[0]) ** 2 / 2e-5, 1e-12)
        self.near(np.abs(s[1, 1]) ** 2, np.abs(rh[0]) ** 2 / 2e-5, 1e-12)

    def test_facets_by_hand(self):
        # What is put together from the judged parts, facet by facet: axes, cut, damping, area, phases.
        k = 2 * math.pi * 10e9 / 299_792_458.0
        for splitting, phases in (
            ("consistent", "polcoherent"),
            ("consistent", "single"),
            ("mars2007", "single"),
        ):
            scene, sea = scene_of(
                (
                    "[sea.shadow]",
                    f'splitting = "{splitting}"\nphases = "{phases}"\n[sea.shadow]',
                )
            )
            facets = sea.facets(0.1)
            count = len(facets.area)
            for theta in (0.1, 0.18, 0.8) if splitting == "consistent" else (0.8,):
                ki = np.tile(-towards(theta, -1.2), (count, 1))
                ks = np.tile(towards(theta + 0.05, -1.0), (count, 1))
                got = sea.matrices(facets, ki, ks)
                for f in range(0, count, 17):
                    self.near(
                        got[f], self.by_hand(sea, f, 0.1, k, ki[f], ks[f]), 1e-9, np.max(np.abs(got[f]))
                    )

    def by_hand(self, sea, f, t, k, ki, ks):
        consistent = sea.splitting == "consistent"
        ix, iy = -8 + f // 12, -6 + f % 12
        h = sea.surface.coefficients(t)["z"]
        wave = h * np.exp(1j * (sea.surface.kx * ix + sea.surface.ky * iy))
        along_x = np.array([1, 0, np.sum(1j * sea.surface.kx * wave).real])
        along_y = np.array([0, 1, np.sum(1j * sea.surface.ky * wave).real])
        area = np.linalg.norm(np.cross(along_x, along_y))
        n = np.cross(along_x, along_y) / area
        # The facet's axis is downwind and level but for its tilt: in the plane of the wind and n.
        across = np.cross(n, [math.cos(math.pi / 6), 0.5, 0.0])
        ey = across / np.linalg.norm(across)
        ex = np.cross(ey, n)
        q = ks - ki
        ku, kc = k * q @ ex, k * q @ ey
        spectrum = spectra.Spectrum("elfouhaily-fung-lee", spectra.Wind(0.36))
        psi = spectrum.psi(np.array([ku]), np.array([kc]))
        variances = sc.cox_munk(sea.wind.u12)
        damping = 1.0
        if consistent:
            cut = max(math.pi, k / 3)
            kb = math.hypot(ku, kc)
            octaves = math.log(kb / cut) / math.log(2)
            psi = psi * (
                1.0 if octaves > 0.5 else 0.0 if octaves < -0.5 else (1 + math.sin(math.pi * octaves)) / 2
            )
            variances = spectrum.slope_variances(math.pi, cut)
            # In the amplitude: half the exponent of |R|^2.
            damping = math.exp(-4 * k**2 * (q @ q / 4) * spectrum.height_variance(cut) / 2)
        one = lambda v: v[None]
        bragg = sc.bragg(one(ki), one(ks), one(n), k, sea.eps, psi)[0]
        slopes = -np.array([q @ ex, q @ ey]) / (q @ n)
        density = math.exp(-np.sum(slopes**2 / variances) / 2) / (2 * math.pi * math.sqrt(np.prod(variances)))
        glint = damping * sc.specular(one(ki), one(ks), one(q @ n), sea.eps, np.array([density]))[0]
        u0, u1 = uniform(7, 20, np.array([ix]), np.array([iy]), 2)[:, 0]
        phase0, phase1 = np.exp(2j * math.pi * u0), np.exp(2j * math.pi * u1)
        if sea.phases == "single":
            return np.sqrt(area * (np.abs(bragg) ** 2 + np.abs(glint) ** 2)) * phase0
        return math.sqrt(area) * (bragg * phase1 + glint * phase0)

    def test_the_sea_curves(self):
        scene, sea = scene_of(
            ("0.36", "0.005"), ("duration_s", 'earth = "curved"\npatch_centre_m = [8e4, -5e4]\nduration_s')
        )
        facets = sea.facets(0.0)
        place, n = (a.reshape(16, 12, 3) for a in (facets.place, facets.n))
        down = place[1:] - place[:-1], place[:, 1:] - place[:, :-1]
        # Chords lie on the tangents but for half a metre over R; the drop at 94 km is known.
        self.assertLess(np.max(np.abs(np.sum(down[0] * n[1:], -1))), 1e-7)
        self.assertLess(np.max(np.abs(np.sum(down[1] * n[:, 1:], -1))), 1e-7)
        self.near(place[8, 6], [8e4, -5e4, -(8e4**2 + 5e4**2) / (2 * 6.371e6)], 1e-12)

    def test_a_following_patch_keeps_its_facets(self):
        follow = ("patch_size_m", 'patch = "follow"\npatch_size_m')
        scene, sea = scene_of(follow)
        self.assertEqual(sea.first_key(0.0), [-8, -6])
        self.assertEqual(sea.first_key(3 / 222.0), [-5, -6])
        a, b = sea.facets(0.0), sea.facets(3 / 222.0)
        grid = lambda f, name: np.reshape(f, (16, 12) + np.shape(f)[1:])
        np.testing.assert_array_equal(grid(a.phasors[0], 0)[3:], grid(b.phasors[0], 0)[:-3])
        self.assertLess(np.max(np.abs(grid(a.place, 0)[3:] - grid(b.place, 0)[:-3])), 0.1)
        # Three rows entered: they have the heights of those that left, and phases of their own.
        self.assertGreater(np.min(np.abs(grid(a.phasors[0], 0)[:3] - grid(b.phasors[0], 0)[-3:])), 0.0)

    def test_a_pulse_is_finite_and_depends_on_all(self):
        kept = []
        for change in (
            ("0.36", "0.36"),
            ("30.0", "31.0"),
            ('light_wind = "published"', 'light_wind = "published"\ndisplacement = false'),
            ('light_wind = "published"', 'light_wind = "published"\nsplitting = "mars2007"'),
            ('light_wind = "published"', 'light_wind = "published"\nphases = "single"'),
            ('"elfouhaily-fung-lee"', '"elfouhaily"'),
            ('"elfouhaily-fung-lee"', '"fung-lee"'),
            ("duration_s", 'earth = "curved"\npatch_centre_m = [3.0, -8.0]\nduration_s'),
        ):
            scene, sea = scene_of(change)
            samples, met = pulse(scene, sea, CHANNELS, 1, 28.1e-6, 64)
            self.assertTrue(np.all(np.isfinite(samples)))
            self.assertEqual(met, 192)
            self.assertTrue(np.all(np.linalg.norm(samples, axis=-1) > 0))
            kept.append(samples)
        for other in kept[1:]:
            self.assertGreater(np.linalg.norm(other - kept[0]) / np.linalg.norm(kept[0]), 1e-3)

    def test_what_cannot_be_judged(self):
        for change in (
            ('"elfouhaily-fung-lee"', '"jonswap"'),
            ('averaging = "points"', ""),
            ('averaging = "points"', 'averaging = "cells"'),
            ('averaging = "points"', 'averaging = "points"\nfoam = 1'),
            ('averaging = "points"', 'averaging = "points"\nwaves = "choppy"'),
            ("tilt_average = false", "tilt_average = true"),
            ("tilt_average = false", ""),
            ('light_wind = "published"', ""),
            ("[sea.shadow]", "[[slick]]\nname = 'oil'\n[sea.shadow]"),
            ("wind_towards_deg = 30.0", ""),
            ("[16.0, 12.0]", "[16.5, 12.0]"),
        ):
            with self.assertRaises(Unfit, msg=change):
                scene_of(change)

    def test_shadows_that_cannot_fall(self):
        scene, sea = scene_of(("enabled = false", "enabled = true"))
        self.assertTrue(np.all(np.isfinite(pulse(scene, sea, CHANNELS[:1], 0, 28.1e-6, 64)[0])))
        facets = sea.facets(0.0)
        low = np.tile(-towards(1.5, -math.pi / 2), (192, 1))
        with self.assertRaises(Unfit):
            sea.matrices(facets, low, -low)


if __name__ == "__main__":
    unittest.main()
