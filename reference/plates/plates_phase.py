"""Regimes of several plates, and their equations with numbers.

The state is (x, y, θ) of every plate, then (vx, vy, ω) of every plate.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple, cast

from cases import Case, Gravity, Mode, PerfectlyRough
from cases.free_plates import plate_contacts, plates_of
from cases.polygon_features import Region, regions, size_of_plate

from ..minimal.assembly import parameter_values
from ..minimal.effects import SLIP_SIGN
from ..minimal.modes import Phase, Regime
from ..several.contact_law import coefficients
from ..several.equations import ContactRows
from .plate_places import flush
from .plates_system import PlateContactForm, plates_system

# Forces of idle contacts are below this part of the plates' weight or of 1 N/kg: a thousand times their roundings.
SLACK = 1e-9
# A contact passes from an edge to a corner this part of the polygon's reach beyond the border, some hundred roundings:
# it begins inside the next region.
BORDER = 1e-13


class PlatesRegime(NamedTuple):
    """Contacts, by their numbers among `plate_contacts`, with their modes (FLIGHT: open), and the plates at rest.

    Contacts of plates at rest are closed and have no equations. `idle`: closed contacts whose force vanishes for the
    whole phase, such as that of two plates that slide with one velocity. `regions`: for each contact of a disc with a
    polygon (its number, that of the region).
    """

    contacts: tuple[int, ...]
    modes: tuple[Mode, ...]
    resting: frozenset[int] = frozenset()
    idle: frozenset[int] = frozenset()
    regions: tuple[tuple[int, int], ...] = ()

    @property
    def closed(self) -> tuple[int, ...]:
        """The numbers of the closed contacts."""
        return tuple(n for n, mode in zip(self.contacts, self.modes, strict=True) if mode is not Mode.FLIGHT)


class PlatesPhase(Phase):
    """A regime of several plates with its equations and numbers; integrators read it as any other phase."""

    __slots__ = ()

    def __reduce__(self):
        return plates_phase, (self.case, self.regime)


def regime_of(phase: Phase) -> PlatesRegime:
    """The regime of a phase of several plates."""
    return cast(PlatesRegime, phase.regime)


def moving_contacts(case: Case, regime: PlatesRegime) -> list[tuple[int, Mode]]:
    """The contacts with equations, by number, and their modes: those of which not both sides are at rest."""
    every, results = plate_contacts(case), list[tuple[int, Mode]]()
    for number, mode in zip(regime.contacts, regime.modes, strict=True):
        one = every[number]
        if one.body in regime.resting and (one.base is None or one.base in regime.resting):
            continue
        results.append((number, mode))
    return results


@lru_cache(maxsize=512)
def plates_phase(case: Case, regime: PlatesRegime) -> PlatesPhase:
    """The equations of that regime with the case's parameters."""
    every, plates, gravity = plate_contacts(case), plates_of(case), case.effect(Gravity)
    forms, values = list[PlateContactForm](), dict[str, float]()
    slack = SLACK * max(plate.mass for plate in plates) * max(gravity.g if gravity is not None else 0.0, 1.0)
    moving = moving_contacts(case, regime)
    order = {number: k for k, (number, _) in enumerate(moving)}
    seconds = flush(case, [number for number, mode in moving if mode is Mode.ROLL])
    for k, (number, mode) in enumerate(moving):
        one = every[number]
        mu, stick = coefficients(cast(Case, one))
        kind = ContactRows.OPEN if mode is Mode.FLIGHT else ContactRows.STICK if mode is Mode.ROLL else ContactRows.SLIP
        region, side = None, "line" if one.base is None else "disc"
        if one.base is not None and (around := regions(plates[one.base])):
            region = around[dict(regime.regions)[number]]
            side = "corner" if region.corner else "edge"
        shares = order[seconds[number]] if number in seconds else None
        rubs, is_corner = stick > 0.0 and one.effect(PerfectlyRough) is None, one.circle.radius == 0.0
        forms.append(PlateContactForm(one.body, one.base, kind, rubs, is_corner, side, shares))
        sign = SLIP_SIGN.get(mode, 0.0)
        values |= {f"k_{k}": -sign * mu if sign else 0.0, f"sigma_{k}": sign, f"stick_{k}": stick}
        values[f"slack_{k}"] = slack if number in regime.idle else 0.0
        if is_corner:
            values |= {f"cx_{k}": one.circle.x, f"cy_{k}": one.circle.y}
        if region is not None:
            values |= _region_values(region, k, BORDER * size_of_plate(plates[cast(int, one.base)]))
        if one.line is not None:
            (px, py), (tx, ty) = one.line.point, one.line.direction
            values |= {f"px_{k}": float(px), f"py_{k}": float(py), f"tx_{k}": float(tx), f"ty_{k}": float(ty)}
    for b, plate in enumerate(plates):
        values |= {f"radius_{b}": size_of_plate(plate), f"w_{b}": 1.0 / plate.mass, f"v_{b}": 1.0 / plate.inertia}
    values["gx"], values["gy"] = gravity.vector if gravity is not None else (0.0, 0.0)
    system = plates_system(tuple(forms), len(plates), regime.resting)
    parameters = parameter_values(case, values, system)
    lengths = tuple(size for plate in plates for size in (size_of_plate(plate), size_of_plate(plate), 1.0))
    smallest = min(map(size_of_plate, plates))
    places = tuple(range(6 * len(plates)))
    return PlatesPhase(cast(Regime, regime), system, parameters, smallest, lengths, places, case)


def _region_values(region: Region, k: int, slack: float) -> dict[str, float]:
    """The numbers of a contact with a polygon: its corner, or the tangent and height of its edge, and both borders."""
    # The tangent runs clockwise around the polygon, as around a disc.
    x, y = (region.x, region.y) if region.corner else (-region.tx, -region.ty)
    values = {f"ex_{k}": x, f"ey_{k}": y, f"height_{k}": region.x * region.ty - region.y * region.tx}
    for end, (u, v, c) in (("low", region.low), ("high", region.high)):
        values |= {f"{end}x_{k}": u, f"{end}y_{k}": v, f"{end}_{k}": c + slack}
    return values
