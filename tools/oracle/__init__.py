"""What tools/oracle.py computes with: the printed equations in numpy, and nothing of nereus.

frames      vectors, rotations, geodetic places, polarisation bases
scene       the scenario as meant: tracks, antennas, targets
streams     ChaCha8 random numbers by address
spectra     wind, sea spectra, directions, moments
scattering  permittivity, Bragg and specular scattering of a facet
sea         the moving surface, the patch of facets, what each facet returns
echo        delays, amplitudes, samples
"""
