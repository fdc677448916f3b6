"""Random smooth roads: every motion ends within a CPU limit, conserves energy and agrees with a fine integration."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import cases
import reference
from cases import Case, CoulombFriction, Curve, Gravity, Start, Unilateral, disc
from cases.motion.mechanics import energy
from tests.scenes.limits import cpu_limit

G = 9.81
# CPU seconds for one motion, with what it derives and compiles; most take a tenth of one.
PATIENCE = 20.0
ENDINGS = ("completed", "lift_off", "no_fit", "track_end", "second_contact")
SHAPES = {
    "tanh": "{a!r}*tanh({k!r}*(s-{c!r}))",
    "gauss": "{a!r}*exp(-({k!r}*(s-{c!r}))**2)",
    "lorentz": "{a!r}/(1+({k!r}*(s-{c!r}))**2)",
}
# The greatest second derivative of a shape with a = k = 1.
BENDS = {"tanh": 0.77, "gauss": 2.0, "lorentz": 2.0}


def road(rng: np.random.Generator) -> tuple[Case, float] | None:
    """A disc sent along a level line with one to three steps, bumps or notches, and the sharpest one's k (1/m); None
    where it does not fit its start."""
    parts, sharpest = [], 0.0
    radius = 10 ** rng.uniform(-2, -0.7)
    for _ in range(rng.integers(1, 4)):
        kind = str(rng.choice(list(SHAPES)))
        k, c = 10 ** rng.uniform(-0.3, 2.3), rng.uniform(0.5, 5.0)
        # Its curvature is at most the disc's own or a little more, and it is no higher than half a metre.
        a = float(rng.choice([-1, 1])) * min(rng.uniform(0.05, 1.2) / (radius * BENDS[kind] * k * k), 0.5)
        parts.append(SHAPES[kind].format(a=round(a, 12), k=round(k, 3), c=round(c, 3)))
        sharpest = max(sharpest, k)
    domain = [None, (-3.0, 6.0)][rng.integers(2)]
    effects = [Gravity(G), Unilateral(), *([CoulombFriction(rng.uniform(0.05, 0.8))] if rng.integers(2) else [])]
    start = Start(xi1=0.0, slip=rng.uniform(0.3, 4.0), omega=-rng.uniform(0, 4.0) / radius)
    try:
        return Case(Curve(("s", " + ".join(parts)), domain), disc(radius, 1.0), tuple(effects), start, 3.0), sharpest
    except cases.CaseError:
        return None


def by_hand(case: Case, sharpest: float) -> tuple[float, float, str]:
    """(end in s, x there, status) of a disc without friction: Newton's law along the path of its centre, c = R + r n,
    by DOP853 in steps shorter than the sharpest bend of the road; N/m = n · (c̈ + g e_y)."""
    radius, spin = case.plate.radius, case.start.omega

    def centre(s):
        """c, c', c'' by s, the normal, and the speed of the road's parameter."""
        jet = case.track.jet(s)
        p, q = complex(*jet[2:4]), complex(*jet[4:6])
        third = complex(*jet[6:8])
        speed = abs(p)
        speed_1 = (p * q.conjugate()).real / speed
        speed_2 = ((q * q.conjugate()).real + (p * third.conjugate()).real - speed_1**2) / speed
        t = p / speed
        t_1 = q / speed - p * speed_1 / speed**2
        t_2 = third / speed - 2 * q * speed_1 / speed**2 - p * speed_2 / speed**2 + 2 * p * speed_1**2 / speed**3
        return complex(*jet[:2]) + 1j * radius * t, p + 1j * radius * t_1, q + 1j * radius * t_2, 1j * t

    def acceleration(s, u):
        _, c1, c2, n = centre(s)
        along = (-G * c1.imag - (c1 * c2.conjugate()).real * u * u) / abs(c1) ** 2
        return along, ((c1 * along + c2 * u * u + 1j * G) * n.conjugate()).real, c1

    def pressed(t, z):
        return acceleration(*z)[1]

    def fits(t, z):
        return 1.0 / radius - float(case.track.curvature(z[0]))

    def inside(t, z):
        return 1.0 if case.track.domain is None else min(z[0] - case.track.domain[0], case.track.domain[1] - z[0])

    def rises(t, z):
        """The rate of the normal force along the motion, by a difference."""
        h = 1e-7
        return (pressed(t, (z[0] + h * z[1], z[1] + h * acceleration(*z)[0])) - pressed(t, z)) / h

    for event in (pressed, fits, inside):
        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
    rises.direction = 1  # type: ignore[attr-defined]
    _, c1, _, n = centre(0.0)
    # The contact's slip is the centre's speed less that of the rotation: v = ċ·t + ω r, as n points to the centre.
    along = case.start.slip - radius * spin
    first = along / (c1 * (n / 1j).conjugate()).real
    if pressed(0.0, (0.0, first)) <= 0.0:
        return 0.0, float(centre(0.0)[0].real), "lift_off"
    found = solve_ivp(
        lambda t, z: [z[1], acceleration(*z)[0]], (0.0, case.duration), [0.0, first], method="DOP853", rtol=1e-12,
        atol=1e-13, max_step=min(0.02, 0.125 / sharpest), events=(pressed, fits, inside, rises), dense_output=True,
    )  # fmt: skip
    # A force that changes its sign twice within one step changes it around its minimum.
    for t, z in zip(found.t_events[3], found.y_events[3], strict=True):
        if pressed(t, z) < 0.0:
            end = brentq(lambda t: pressed(t, found.sol(t)), max(t - 0.02, 0.0), t, xtol=1e-14)
            return end, float(centre(found.sol(end)[0])[0].real), "lift_off"
    ends = dict(zip(("lift_off", "no_fit", "track_end"), found.t_events, strict=False))
    hit = [name for name, times in ends.items() if len(times)]
    return float(found.t[-1]), float(centre(found.y[0, -1])[0].real), hit[0] if hit else "completed"


def check_road(seed: int) -> None:
    """Every method at a random tolerance: it ends in time, conserves energy, and without friction ends where the
    integration by hand does."""
    rng = np.random.default_rng(seed)
    made = road(rng)
    if made is None:
        return
    case, sharpest = made
    rtol = 10.0 ** -float(rng.integers(2, 15))
    free = case.effect(CoulombFriction) is None
    expected = by_hand(case, sharpest) if free else None
    for method in reference.METHODS:
        with cpu_limit(PATIENCE):
            motion = reference.simulate(case, rtol=rtol, method=method)
        assert motion.status in ENDINGS, (seed, method, motion.reason)
        states = [motion(t) for t in np.linspace(0.0, motion.t[-1], 9)]
        energies = np.array([energy(case, state) for state in states])
        # A hundred times the tolerance, of motions with up to a hundred steps; friction only takes energy. Heights and
        # speeds have it: their sum may be near zero.
        lifted = max(G * abs(float(state.y)) for state in states)
        known = (100.0 * rtol + 1e-11) * (abs(energies[0]) + lifted)
        assert np.all(np.diff(energies) <= known), (seed, method)
        assert not free or np.ptp(energies) <= known, (seed, method)
        if expected and motion.status != "second_contact":  # which is not looked for by hand
            end, x, status = expected
            assert motion.status == status, (seed, method)
            # Ten times more: an error before a steep place is a larger one behind it.
            assert float(motion.t[-1]) == pytest.approx(end, abs=1e3 * rtol + 1e-9), (seed, method)
            assert float(motion.x[-1]) == pytest.approx(x, abs=1e3 * rtol + 1e-9), (seed, method)


ROAD_THAT_NEVER_ENDED = Case(
    Curve(("s", "0.1852*tanh(7.044*(s-2.639))"), (-3, 6)), disc(0.077, 1.0), (Gravity(G), Unilateral()),
    Start(0.0, slip=1.954), 3.0,
)  # fmt: skip


@pytest.mark.parametrize(
    "digits", [range(2, 15, 4), pytest.param(range(2, 15), marks=pytest.mark.slow)], ids=["few", "all"]
)
def test_a_step_that_ends_a_rounding_beyond_its_bound_is_repeated_shorter(digits):
    """The same step came again without end: its end lay beyond a feature's bound by less than its length's rounding."""
    end, x, status = by_hand(ROAD_THAT_NEVER_ENDED, 7.044)
    for method in reference.METHODS:
        for rtol in 10.0 ** -np.array(digits):
            with cpu_limit(PATIENCE):
                motion = reference.simulate(ROAD_THAT_NEVER_ENDED, rtol=rtol, method=method)
            assert (motion.status, float(motion.t[-1])) == (status, pytest.approx(end, abs=1e3 * rtol + 1e-9))
            assert float(motion.x[-1]) == pytest.approx(x, abs=1e3 * rtol + 1e-9)


def test_a_road_of_fractions_is_derived_in_seconds():
    """SymPy's factors of the equations on such a sum were not found within minutes."""
    road = "0.0279*tanh(21.3*s - 87.8) - 0.0002/((112.2*s - 105.4)**2 + 1)"
    case = Case(Curve(("s", road)), disc(0.11, 1.0), (Gravity(G), Unilateral()), Start(0.0, slip=1.85), 0.1)
    with cpu_limit(PATIENCE):
        assert reference.simulate(case).status == "completed"


def test_far_from_a_steep_step_its_series_have_values():
    """tanh(u) was taken as sinh(u)/cosh(u), which overflows beyond u = 710: where the plate leaves a hill 2.4 m before
    such a step, the series of its normal force had no value."""
    track = Curve(("s", "0.3*exp(-(2*(s-0.6))**2) + 0.0001*tanh(400*(s-3))"))
    case = Case(track, disc(0.01, 1.0), (Gravity(G), Unilateral()), Start(0.0, slip=3.0), 1.0)
    end, _, status = by_hand(case, 2.0)
    for method in reference.METHODS:
        motion = reference.simulate(case, method=method)
        assert (motion.status, status) == ("lift_off", "lift_off")
        assert float(motion.t[-1]) == pytest.approx(end, abs=1e-9)


SLOW = [pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 3, 4, 5, 6, 7)]


# 162: a lift-off that the Taylor method located at 1e-2, with 3e-4 of the forces left, was called a paradox.
# 2514: the force is negative for less than a step of the integration by hand, which passed over it.
@pytest.mark.sampled(2, first=1)
@pytest.mark.parametrize("seed", [1, 2, 162, 2514, *SLOW])
def test_random_roads_a_few(seed):
    check_road(seed)


@pytest.mark.slow
@pytest.mark.parametrize("part", range(50))
def test_random_roads_five_thousand(part):
    for seed in range(100 * part, 100 * part + 100):
        check_road(8 + seed)
