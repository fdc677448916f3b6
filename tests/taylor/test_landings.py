"""Landings and second contacts on curves with fine features: no zero of the gap hides between two looks."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import pi

import mpmath as mp
import pytest

import reference
from cases import (
    Case,
    Curve,
    Gravity,
    PerfectlyRough,
    Start,
    Support,
    Unilateral,
    disc,
)
from cases.contact import start_motion
from tests.sampling import quick_every
from tests.scenes import second as second_states
from tests.scenes.ripples import FLYING, G, over_ripples


def first(case: Case) -> float:
    return reference.simulate(case, rtol=1e-13).transitions[0].time


def second(case: Case) -> float:
    return second_states.motion(case, rtol=1e-13).transitions[0].time


FORMULATIONS = pytest.mark.parametrize("solve", [first, second], ids=["first", "second"])


# --- closed forms with many digits ------------------------------------------------------------------------------------


@cache
def exact_over_ripples(name: str) -> mp.mpf:
    """When the disc's centre crosses the curve parallel to the ripples of that name, 30 digits.

    The centre is above the parallel curve's place of parameter s at one time, and so high above it: a function of s,
    looked at in a thousand places to a ripple.
    """
    height, length, _, g = RIPPLES[name]
    begun = start_motion(over_ripples(*RIPPLES[name]))
    with mp.workdps(40):
        a, k, r = mp.mpf(height), mp.mpf(2 * pi / length), mp.mpf("0.1")

        def parallel(s):
            slope = -a * k * mp.sin(k * s)
            speed = mp.sqrt(1 + slope**2)
            return s - r * slope / speed, a * mp.cos(k * s) + r / speed

        def above(s):
            x, y = parallel(s)
            t = (x - mp.mpf(begun.x)) / mp.mpf(begun.vx)
            return mp.mpf(begun.y) + mp.mpf(begun.vy) * t - mp.mpf(g) * t**2 / 2 - y, t

        places = [mp.mpf(length) * n / 1000 for n in range(40_000)]
        low = next(s for s, following in zip(places, places[1:], strict=False) if above(following)[0] < 0)
        s = mp.findroot(lambda s: above(s)[0], (low, low + mp.mpf(length) / 1000), solver="anderson")
        return +above(s)[1]


RIPPLES = {
    # height (m), length (m), gap (m), g: the disc's curvature is 10 1/m, the ripples' up to 6.3, 8.1 and 9.9.
    "1 um by 2.5 mm": (1e-6, 2.5e-3, 1.5e-6, 0.0),
    "1 um by 2.5 mm, under gravity": (1e-6, 2.5e-3, 2.5e-6, 9.81),
    "10 um by 7 mm": (1e-5, 7e-3, 3e-5, 0.0),
    "10 um by 7 mm, from higher": (1e-5, 7e-3, 5.2e-5, 0.0),
    "1 nm by 63 um": (1e-9, 6.3e-5, 7.1e-9, 0.0),
}


def seeds(whole, quick) -> list:
    """Names or seeds of scenes; those outside `quick` are slow."""
    return [seed if seed in quick else pytest.param(seed, marks=pytest.mark.slow) for seed in whole]


FALLING = "1 um by 2.5 mm, under gravity"


@quick_every(2)
@FORMULATIONS
@pytest.mark.parametrize("name", seeds(RIPPLES, [FALLING]))
def test_a_landing_on_fine_ripples_is_the_first_crossing_of_their_parallel_curve(solve, name, accuracy):
    case, exact = over_ripples(*RIPPLES[name]), exact_over_ripples(name)
    # A place is known to 1e-17 m, some of whose roundings the gap is, and it closes at 2 mm/s at least. The second
    # formulation's poses come from an integration, whose steps are rounded too.
    accuracy(
        case=name, solver="reference", route=solve.__name__, quantity="landing / s",
        error=float(solve(case) - exact), tolerance=2e-13 if solve is first else 1e-12,
    )  # fmt: skip


@pytest.mark.parametrize("name", seeds(RIPPLES, ["1 um by 2.5 mm"]))
def test_a_certificate_holds_the_landing_on_fine_ripples(name):
    holds(over_ripples(*RIPPLES[name]), exact_over_ripples(name))


def holds(case: Case, exact: mp.mpf) -> None:
    """Asserts that a certificate of both formulations has the exact time of the landing within a narrow bar."""
    certificate = reference.certify(replace(case, duration=1.01 * float(exact)))
    _, _, time, _ = certificate.transitions[0]
    assert abs(float(time.value - exact)) <= time.bar < 1e-9
    assert "contact frame 1e-13" in certificate.witnesses and len(certificate.witnesses) >= 2


@quick_every(3)
@FORMULATIONS
@pytest.mark.parametrize("above", [1e-11, -1e-11])
def test_a_disc_that_flies_past_a_crest_touches_it_or_not_by_a_hundredth_of_a_nanometre(solve, above):
    height, wide = 1e-5, 1e-4
    track = Curve(("s", f"{height}*exp(-(s/{wide})**2)"), (-1, 1))
    start = Start(-0.2, gap=height + above, slip=3.0)
    case = Case(track, disc(0.1, 1.0), FLYING, start, 0.2)
    if above > 0.0:
        assert reference.simulate(case).transitions == () == second_states.motion(case, rtol=1e-13).transitions
        return
    with mp.workdps(40):
        h, w, r, up = mp.mpf(height), mp.mpf(wide), mp.mpf("0.1"), mp.mpf(height) + mp.mpf("0.1") + mp.mpf(above)

        def touches(s):
            y = h * mp.exp(-((s / w) ** 2))
            slope = -2 * s / w**2 * y
            return up - y - r / mp.sqrt(1 + slope**2)

        s = mp.findroot(touches, (-mp.mpf("2e-8"), -mp.mpf("1e-9")), solver="anderson")
        y = h * mp.exp(-((s / w) ** 2))
        slope = -2 * s / w**2 * y
        exact = (s - r * slope / mp.sqrt(1 + slope**2) + mp.mpf("0.2")) / 3
    assert solve(case) == pytest.approx(float(exact), abs=1e-9)


def rolls_onto_a_bump() -> Case:
    """A disc that rolls towards a bump a tenth of a millimetre wide and a micrometre high."""
    track = Curve(("s", "1e-6*exp(-((s-0.3)/1e-4)**2)"), (-1, 1))
    return Case(track, disc(0.1, 1.0), (Gravity(G), PerfectlyRough(), Unilateral()), Start(0.0, omega=-10.0), 0.5)


def first_end(case: Case) -> tuple[str, float]:
    motion = reference.simulate(case, rtol=1e-13)
    return motion.status, float(motion.t[-1])


def end_in_poses(case: Case) -> tuple[str, float]:
    """The same with a wall far behind, so that the contact has no coordinates of its own."""
    wall = Support(Curve(("-5", "-s"), (-9, 9)), "wall")
    return first_end(replace(case, supports=(wall,)))


def second_end(case: Case) -> tuple[str, float]:
    answer = second_states.motion(case, rtol=1e-13)
    return answer.status, answer.end


@pytest.mark.parametrize("solve", seeds([first_end, end_in_poses, second_end], [first_end, end_in_poses]))
def test_a_fine_bump_ahead_is_a_second_contact_where_the_disc_meets_it(solve):
    # The centre goes at 1 m/s, 0.1 m above the line (the bump is nothing there), until it is 0.1 m from the bump.
    with mp.workdps(40):
        h, w, c, r = mp.mpf("1e-6"), mp.mpf("1e-4"), mp.mpf("0.3"), mp.mpf("0.1")

        def meets(s):
            y = h * mp.exp(-(((s - c) / w) ** 2))
            slope = -2 * (s - c) / w**2 * y
            return y + r / mp.sqrt(1 + slope**2) - r

        # Of all places of the bump the first to be met: before its crest, where the parallel curve is as high.
        grid = [c - w * mp.mpf(n) / 1000 for n in range(1, 4000)]
        s = mp.findroot(meets, next((a, b) for a, b in zip(grid[1:], grid, strict=False) if meets(a) * meets(b) < 0))
        y = h * mp.exp(-(((s - c) / w) ** 2))
        slope = -2 * (s - c) / w**2 * y
        exact = s - r * slope / mp.sqrt(1 + slope**2)
    status, end = solve(rolls_onto_a_bump())
    assert status == "second_contact" and end == pytest.approx(float(exact), abs=1e-11)
