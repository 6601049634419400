"""Sine and cosine of an angle in degrees, from `+ - *` alone.

The last bit of a C library's sine depends on the CPU that it runs on; these do not. They serve
start headings and the turns of the movement tables; the step itself needs no trigonometry.
"""

_RAD_PER_DEG = 0.017453292519943295
"""pi / 180, rounded to double."""


def cos_sin_deg(angle_deg: float) -> tuple[float, float]:
    """Return (cosine, sine) of an angle in degrees; at multiples of 90 they are exact.

    The angle is brought to -45 .. 45 degrees, where both series end below 1e-17. Against the C
    library the difference is at most 1e-15 (tests/test_trig.py).

    >>> cos_sin_deg(180.0)
    (-1.0, 0.0)
    >>> round(cos_sin_deg(-30.0)[1], 15)
    -0.5
    """
    quarters = round(angle_deg / 90.0)
    x = (angle_deg - 90.0 * quarters) * _RAD_PER_DEG
    square = x * x
    sine = x * _series(square, _SINE)
    cosine = _series(square, _COSINE)
    match quarters % 4:
        case 0:
            return cosine, sine
        case 1:
            return 0.0 - sine, cosine
        case 2:
            return 0.0 - cosine, 0.0 - sine
        case _:
            return sine, 0.0 - cosine


_SINE = (
    1.0,
    -1 / 6,
    1 / 120,
    -1 / 5040,
    1 / 362880,
    -1 / 39916800,
    1 / 6227020800,
    -1 / 1307674368000,
)
_COSINE = (
    1.0,
    -1 / 2,
    1 / 24,
    -1 / 720,
    1 / 40320,
    -1 / 3628800,
    1 / 479001600,
    -1 / 87178291200,
    1 / 20922789888000,
)


def _series(square: float, coefficients: tuple[float, ...]) -> float:
    total = 0.0
    for coefficient in reversed(coefficients):
        total = total * square + coefficient
    return total
