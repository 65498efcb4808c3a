"""Random numbers by address: the key stream of ChaCha8 under the 256-bit key (seed, purpose, index, part).

The key is the four words of 64 bits, little endian; block counter and nonce are 0; two words of 32 bits
make one of 64, the low one first. Only the first block is made: eight words of 64 bits an address.
"""

import numpy as np

SEA_WAVE = 16
FACET_PHASE = 20


def block(key, rounds=8):
    """First block of ChaCha for keys of eight 32-bit words [8, n]: sixteen words [16, n]."""
    key = np.asarray(key, np.uint32)
    start = np.zeros((16, key.shape[1]), np.uint32)
    start[:4] = np.frombuffer(b"expand 32-byte k", "<u4")[:, None]
    start[4:12] = key
    x = start.copy()

    def quarter(a, b, c, d):
        for to, source, turned, left in ((a, b, d, 16), (c, d, b, 12), (a, b, d, 8), (c, d, b, 7)):
            x[to] += x[source]
            x[turned] ^= x[to]
            x[turned] = (x[turned] << np.uint32(left)) | (x[turned] >> np.uint32(32 - left))

    for _ in range(rounds // 2):
        for i in range(4):  # columns
            quarter(i, 4 + i, 8 + i, 12 + i)
        for i in range(4):  # diagonals
            quarter(i, 4 + (i + 1) % 4, 8 + (i + 2) % 4, 12 + (i + 3) % 4)
    return x + start


def uniform(seed, purpose, index, part, count):
    """The first numbers in [0, 1) of the streams at integers index and part: [count, n]."""
    index, part = (np.asarray(a, np.int64).ravel().view(np.uint64) for a in (index, part))
    words = [np.full_like(index, seed), np.full_like(index, purpose), index, part]
    low = np.uint64(0xFFFFFFFF)
    key = [half.astype(np.uint32) for w in words for half in (w & low, w >> np.uint64(32))]
    made = block(key).astype(np.uint64)
    whole = made[0::2] | (made[1::2] << np.uint64(32))
    return (whole[:count] >> np.uint64(11)) * 2.0**-53
