"""The units of a case's parameters: a number of the case that changes one to one with a parameter has its unit."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot, isclose
from typing import Any

from cases import Case, CaseError
from cases.errors import real
from cases.pictures.plots import parameter_unit, with_unit
from reference.sweeping import Axis, Plan

# Units of the numbers of a case, by class and field. Those of the contact parameters depend on the curves.
UNITS = {
    ("Case", "duration"): "s",
    ("Plate", "mass"): "kg",
    ("Plate", "inertia"): "kg m²",
    ("Start", "slip"): "m/s",
    ("Start", "omega"): "rad/s",
    ("Start", "gap"): "m",
    ("Start", "gap_rate"): "m/s",
    ("Gravity", "g"): "m/s²",
    ("RollingResistance", "arm"): "m",
    # Of the curves: a distance from the origin, as the radius of a circle, and a direction, as the slope of a line.
    ("Curve", "outline's distance"): "m",
    ("Curve", "track's distance"): "m",
    ("Curve", "track's direction"): "rad",
}
# Names of parameters in words.
_WORDS = {"mu": "friction coefficient μ", "xi1": "start on the track ξ₁", "xi2": "start on the outline ξ₂"}
# Relative rounding of a difference between two values of a parameter that differ by a hundredth.
_ROUNDING = 1e-9


def parameter_label(plan: Plan, name: str) -> str:
    """The label of a parameter's axis: its name, and its unit if the case shows one."""
    return with_unit(_WORDS.get(name, name), unit_of(plan, name))


def unit_of(plan: Plan, name: str) -> str:
    """The unit of a parameter, "" if it has none or the case does not show one."""
    (axis,) = (axis for axis in plan.axes if axis.name == name)
    others = {other.name: _middle(other) for other in plan.axes if other.name != name}
    low = _middle(axis)
    high = low + 0.01 * (abs(low) or 1.0)
    try:
        before, after = (dict(_numbers(plan.make(**others, **{name: value}))) for value in (low, high))
        case = plan.make(**others, **{name: low})
    except CaseError:
        return ""
    units = _units(case)
    changes = {key: abs(after[key] - before[key]) for key in before.keys() & after.keys() & units.keys()}
    matches = {units[key] for key, change in changes.items() if isclose(change, high - low, rel_tol=_ROUNDING)}
    return matches.pop() if len(matches) == 1 else ""


def _middle(axis: Axis) -> float:
    if len(axis.values):
        return float(axis.values[len(axis.values) // 2])
    return (axis.low * axis.high) ** 0.5 if axis.log else 0.5 * (axis.low + axis.high)


def _units(case: Case) -> dict[tuple[str, str], str]:
    contact = {"xi1": case.track, "xi2": case.plate.outline}
    return UNITS | {("Start", name): parameter_unit(curve) for name, curve in contact.items()}


def _numbers(case: Case) -> Iterator[tuple[tuple[str, str], float]]:
    """The numbers of a case, by class and field."""
    parts: tuple[Any, ...] = (case, case.plate, case.start, *case.effects)
    for part in parts:
        for field, value in vars(part).items():
            number = real(value)
            if number is not None:
                yield (type(part).__name__, field), number
    for name, curve in (("outline", case.plate.outline), ("track", case.track)):
        yield ("Curve", f"{name}'s distance"), hypot(*map(float, curve.point(curve.span[0])))
    yield ("Curve", "track's direction"), float(case.track.tangent_angle(case.track.span[0]))
