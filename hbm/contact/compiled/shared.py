"""Numbers that both forms of the box law go by, in JAX and for numba.

Here, since what numba keeps between runs is named by the files of this folder; without numba, which takes long to load.
"""

# Newton's method halves its bracket wherever it leaves it: no root takes more steps than the mantissa has bits.
MOST_STEPS = 60
# A step of Newton's method this small, a share of a segment, is the last: the next one would be its square.
AT_ROOT = 1e-12

# Integrals over a whole segment of the four basis functions of a cubic (values, slopes) times 1 - t, and times t.
WHOLE_START = (7 / 20, 3 / 20, 1 / 20, -1 / 30)
WHOLE_END = (3 / 20, 7 / 20, 1 / 30, -1 / 20)

# A slider that moves by less than this share of the motion's largest value does not move: round-off is below a
# thousandth of it.
SLIDER_STANDS = 1e-12
