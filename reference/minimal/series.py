"""Truncated Taylor series in time with bounds on their rounding: the one-sided derivatives of a motion.

If a motion starts degenerate (v = 0 and N = 0 at once, friction exactly at its cone), its next mode is decided by the
first derivative that does not vanish. The same compiled equations that are integrated are evaluated on series instead
of numbers; each coefficient carries a bound on its own error, so "does not vanish" needs no tolerance.

Recurrences for the elementary functions: e.g. Hairer, Nørsett & Wanner, Solving ODE I, section I.8.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from cases.formulas.expression_graph import Node, call
from cases.formulas.expression_graph import sqrt as sqrt_of_node

from ..scales import EPS as EPS  # the equations' modules read it here

# Rounding of a product and of the sum that it is added to.
ROUNDING = 2 * EPS


class Series:
    """c[0] + c[1] t + … + c[K] t^K; e[k] bounds the error of c[k]."""

    __slots__ = ("c", "e", "pair")

    def __init__(self, c: list[float], e: list[float]):
        self.c, self.e = c, e
        # Cache of (sign, sine, cosine) or the hyperbolic functions, which are computed together.
        self.pair: tuple[float, Series, Series] | None = None

    @classmethod
    def constant(cls, value: float, like: Series) -> Series:
        n = len(like.c)
        return cls([value] + [0.0] * (n - 1), [0.0] * n)

    def __neg__(self):
        return Series([-a for a in self.c], self.e)

    def __pos__(self):
        return self

    def __abs__(self):
        """The absolute value of a speed |R_p|, which is never zero; a symbol's sign is unknown when it is compiled."""
        return (self * self) ** 0.5

    def __add__(self, other):
        if not isinstance(other, Series):
            c = [self.c[0] + other, *self.c[1:]]
            return Series(c, [a + EPS * abs(s) for a, s in zip(self.e, c, strict=True)])
        c = [a + b for a, b in zip(self.c, other.c, strict=True)]
        e = [a + b + EPS * abs(s) for a, b, s in zip(self.e, other.e, c, strict=True)]
        return Series(c, e)

    __radd__ = __add__

    def __sub__(self, other):
        if not isinstance(other, Series):
            return self + (-other)
        c = [a - b for a, b in zip(self.c, other.c, strict=True)]
        return Series(c, [a + b + EPS * abs(s) for a, b, s in zip(self.e, other.e, c, strict=True)])

    def __rsub__(self, other):
        return (-self) + other

    def __mul__(self, other):
        if not isinstance(other, Series):
            size, c = abs(other), [a * other for a in self.c]
            return Series(c, [size * bound + ROUNDING * abs(s) for bound, s in zip(self.e, c, strict=True)])
        if len(self.c) == 1:
            ((a,), (error,)), ((b,), (off,)) = (self.c, self.e), (other.c, other.e)
            return Series([a * b], [abs(a) * (off + ROUNDING * abs(b)) + (abs(b) + off) * error])
        c, e = [], []
        left = [(a, abs(a), error) for a, error in zip(self.c, self.e, strict=True)]
        # Reversed, so that each sum runs over two lists in parallel; with the factors of |a| and of a's error.
        right = [(b, off + ROUNDING * abs(b), abs(b) + off) for b, off in zip(other.c, other.e, strict=True)][::-1]
        for k in range(len(left), 0, -1):
            value = bound = 0.0
            for (a, size, error), (b, off, most) in zip(left, right[k - 1 :], strict=False):
                value += a * b
                bound += size * off + most * error
            c.append(value)
            e.append(bound)
        return Series(c, e)

    __rmul__ = __mul__

    def __truediv__(self, other):
        return self * (other**-1 if isinstance(other, Series) else 1.0 / other)

    def __rtruediv__(self, other):
        return self**-1 * other

    def __pow__(self, power):
        """A real power; the base's value must not be zero unless the power is a whole number of at least zero."""
        if power == int(power) and 0 <= power <= 4:
            result = self if power else Series.constant(1.0, self)
            for _ in range(int(power) - 1):
                result = result * self
            return result
        # y = x^p satisfies x y' = p x' y.
        x, value = self.c, self.c[0] ** power
        c, e = [value], [abs(power * value / x[0]) * self.e[0] + 2 * EPS * abs(value)]
        for k in range(1, len(x)):
            total = bound = 0.0
            for i in range(k):
                weight = power * (k - i) - i
                total += weight * x[k - i] * c[i]
                bound += abs(weight) * (
                    abs(x[k - i]) * e[i] + self.e[k - i] * abs(c[i]) + 2 * EPS * abs(x[k - i] * c[i])
                )
            c.append(total / (k * x[0]))
            e.append((bound + abs(total) * self.e[0] / abs(x[0])) / (k * abs(x[0])) + EPS * abs(c[-1]))
        return Series(c, e)

    def __rpow__(self, base):
        return exp(self * log(base))

    def derivative(self) -> Series:
        """d/dt, one order shorter."""
        return Series(
            [k * a for k, a in enumerate(self.c)][1:],
            [k * a for k, a in enumerate(self.e)][1:],
        )

    def leading(self) -> tuple[int, int]:
        """(sign, order) of the first coefficient that exceeds its error bound; (0, K+1) if none does."""
        for k, (c, e) in enumerate(zip(self.c, self.e, strict=True)):
            if abs(c) > e:
                return (1 if c > 0 else -1), k
        return 0, len(self.c)


def sign(value: Series | float, rounding: float = 0.0) -> int:
    """The sign just after time zero of a series, or of a constant, whose value at zero has an error of `rounding`."""
    if isinstance(value, Series):
        value = Series(value.c, [max(value.e[0], rounding), *value.e[1:]]) if rounding else value
        return value.leading()[0]
    return (value > rounding) - (value < -rounding)


def _of_number(name: str, x):
    """An elementary function of a number: its value, or its node."""
    if isinstance(x, Node):
        return sqrt_of_node(x) if name == "sqrt" else call(name, x)
    return getattr(math, name)(x)


def _solve(x: Series, value: float, slope: Callable[[Series], Series]) -> Series:
    """y with y(0) = value and y' = slope(y)·x', order by order."""
    n = len(x.c)
    y = Series(
        [value] + [0.0] * (n - 1),
        [abs(slope(Series([value], [0.0])).c[0]) * x.e[0] + EPS * abs(value)] + [0.0] * (n - 1),
    )
    if n == 1:
        return y
    dx = x.derivative()
    for k in range(1, n):
        partial = Series(y.c[:k], y.e[:k])
        rate = slope(partial) * Series(dx.c[:k], dx.e[:k])
        y.c[k], y.e[k] = rate.c[k - 1] / k, rate.e[k - 1] / k
    return y


def exp(x):
    return _solve(x, exp(x.c[0]), lambda y: y) if isinstance(x, Series) else _of_number("exp", x)


def _from_slope(function: Callable[[float], float], slope: Callable[[Series], Series]):
    """The elementary function with that closed-form derivative, for numbers and series."""

    def elementary(x):
        if not isinstance(x, Series):
            return _of_number(function.__name__, x)
        return _by_slope(x, elementary(x.c[0]), slope)

    # Pickled by its name in this module.
    elementary.__name__ = elementary.__qualname__ = function.__name__
    return elementary


log = _from_slope(math.log, lambda x: x**-1)
atan = _from_slope(math.atan, lambda x: (1 + x * x) ** -1)
asin = _from_slope(math.asin, lambda x: (1 - x * x) ** -0.5)
acos = _from_slope(math.acos, lambda x: -((1 - x * x) ** -0.5))


def _by_slope(x: Series, value: float, slope: Callable[[Series], Series]) -> Series:
    """The function of x with that value at its start and that slope."""
    n = max(len(x.c) - 1, 1)
    s = slope(Series(x.c[:n], x.e[:n]))
    first = s.c[0] if isinstance(s, Series) else s
    c, e = [value], [abs(first) * x.e[0] + EPS * abs(value)]
    if len(x.c) > 1:
        rate = s * x.derivative()
        c += [a / (k + 1) for k, a in enumerate(rate.c)]
        e += [a / (k + 1) for k, a in enumerate(rate.e)]
    return Series(c, e)


def _pair(x: Series, first: float, second: float, sign: float) -> tuple[Series, Series]:
    """(a, b) with a' = b x' and b' = sign·a x': sine and cosine, or hyperbolic sine and cosine."""
    if x.pair and x.pair[0] == sign:
        return x.pair[1:]
    n, most = len(x.c), 1.0 if sign < 0 else second  # none of these four is larger than 1 or the hyperbolic cosine
    a = Series([first] + [0.0] * (n - 1), [abs(second) * x.e[0] + EPS * most] + [0.0] * (n - 1))
    b = Series([second] + [0.0] * (n - 1), [abs(first) * x.e[0] + EPS * most] + [0.0] * (n - 1))
    for k in range(1, n):
        for out, other, factor in ((a, b, 1.0), (b, a, sign)):
            total = bound = 0.0
            for i in range(1, k + 1):
                term = i * x.c[i] * other.c[k - i]
                total += term
                bound += i * (abs(x.c[i]) * other.e[k - i] + x.e[i] * abs(other.c[k - i])) + 2 * EPS * abs(term)
            out.c[k], out.e[k] = factor * total / k, bound / k
    x.pair = sign, a, b
    return a, b


def sin(x):
    return _pair(x, sin(x.c[0]), cos(x.c[0]), -1.0)[0] if isinstance(x, Series) else _of_number("sin", x)


def cos(x):
    return _pair(x, sin(x.c[0]), cos(x.c[0]), -1.0)[1] if isinstance(x, Series) else _of_number("cos", x)


def sinh(x):
    return _pair(x, sinh(x.c[0]), cosh(x.c[0]), 1.0)[0] if isinstance(x, Series) else _of_number("sinh", x)


def cosh(x):
    return _pair(x, sinh(x.c[0]), cosh(x.c[0]), 1.0)[1] if isinstance(x, Series) else _of_number("cosh", x)


def tan(x):
    return sin(x) / cos(x)


def tanh(x):
    # Not the quotient of sinh and cosh, which overflow where it is 1.
    return _solve(x, tanh(x.c[0]), lambda y: 1.0 - y * y) if isinstance(x, Series) else _of_number("tanh", x)


def sqrt(x):
    return x**0.5 if isinstance(x, Series) else _of_number("sqrt", x)


def _integral(value: Callable, slope: Callable):
    """An integral up to a number or a series; of the formula's constants, which may have a rounding, the values
    count."""

    def evaluate(x, *rest):
        rest = tuple(one.c[0] if isinstance(one, Series) else one for one in rest)
        if not isinstance(x, Series):
            return value(x, *rest)
        return _by_slope(x, value(x.c[0], *rest), lambda s: slope(s, *rest[1:])[0])

    return evaluate


# Functions that a compiled expression may call.
FUNCTIONS = dict(
    exp=exp, log=log, sqrt=sqrt, pi=math.pi, sin=sin, cos=cos, tan=tan,
    sinh=sinh, cosh=cosh, tanh=tanh, asin=asin, acos=acos, atan=atan, integral=_integral,
)  # fmt: skip


def along(rhs: Callable, y0: Sequence[float], errors: Sequence[float], order: int) -> list[Series]:
    """The solution of y' = rhs(t, y) from time 0 as series of that order; `errors` bounds those of `y0`.

    `rhs` takes and returns sequences of Series (its time is a Series too).
    """
    c = [[v] for v in y0]
    e = [[abs(v)] for v in errors]
    for k in range(order):
        time = Series([0.0, 1.0, *([0.0] * k)][: k + 1], [0.0] * (k + 1))
        rates = rhs(time, [Series(a[:], b[:]) for a, b in zip(c, e, strict=True)])
        for a, b, rate in zip(c, e, rates, strict=True):
            exact = not isinstance(rate, Series)
            a.append((rate if k == 0 else 0.0) if exact else rate.c[k] / (k + 1))
            b.append(0.0 if exact else rate.e[k] / (k + 1))
    return [Series(a, b) for a, b in zip(c, e, strict=True)]
