"""What an adapter must define, and the types it uses. `adapters.lookup` finds adapters by name.

An adapter is one module or package with

    NAME: str                                       the engine's name in every table
    routes: tuple[str, ...]                         "native" (the engine's own shapes and contact), "assisted" (our
                                                    contact point, the engine's contact law and step), "integrator"
                                                    (our contact point and our contact law, the engine's step alone)
    refuses(case, route) -> str | None              why this route cannot model the case, in one sentence, or None: a
                                                    `Refusal` with the engine's documented limit that says so, or a
                                                    plain text if the engine could and the adapter does not yet
    ladder(case, route) -> tuple[Setting, ...]      from coarse to fine, all knobs tightened together
    build(case, route, setting) -> model            not timed
    run(model) -> None                              the only part that is timed
    read(model) -> Trajectory                       not timed; raises EngineFailure for a run without a motion
    version() -> str                                of the engine

Optional, for the separation of errors by their causes (`reports.study error_parts`):

    grid(case, route) -> tuple[Setting, ...]        every combination of a few values of the step `h` and of one or
                                                    more knobs of the model; each knob's values appear from coarse to
                                                    fine, so the first setting is the coarsest, the last the finest

Optional, for the time breakdown:

    bare_run(case, route, setting, without) -> Callable[[], None]
                                                    a function that makes as many steps as `run`, without recording
                                                    ("notes"); with "callback", also without the callback's content;
                                                    with "binding", also without the binding
    ENGINE: str                                     without that function: the Python package with the engine's compiled
                                                    code, for a profile, if it is not called NAME

Optional, for the range of errors with default settings:

    default_grid(case, route) -> tuple[Setting, ...]
                                                    the default settings and their neighbours: all combinations of a few
                                                    usual values of parameters that the engine leaves to its user, such
                                                    as step, facets and stiffness; the first one is the
                                                    ladder's (`Setting.combinations`)

Optional:

    KNOWN: str                                      the engine's package and the versions that the adapter was tested
                                                    with, as a pip requirement: "pymunk>=6.11". Users can select each
                                                    of them, as "pymunk@6.11.1". Read from the source, not imported
    OUR_PARTS: dict[str, str]                       by route, what of it is not the engine's own, in a phrase; such a
                                                    route is not ranked. Routes called assisted and integrator have one
    CAPABILITIES: dict[str, tuple[str, ...]]        by route, what it supports beyond a smooth plate on a smooth track
                                                    with constant coefficients, in words of `WORDS`; `refusal` rejects
                                                    what a route lacks before `refuses` is called. (Up to version 0.2
                                                    each word was a tuple of routes of its own, such as SLIP_LAWS; both
                                                    forms are read)
    refuses_several_contacts(case, route) -> str | None
                                                    why a route that has "several contacts" does not report those of
                                                    this case, in one sentence, or None
    OWN_EFFECTS: tuple[type, ...]                   the effects of other packages that it supports (classes derived from
                                                    `cases.ContactEffect`); `refusal` rejects all others
    MEANINGS: tuple[Meaning, ...]                   how the engine interprets its parameters of friction, restitution
                                                    and rolling resistance, and for which cases its law differs

`adapters.gate` checks all return values: plain numbers and texts of ordinary size, or the row reports the fault. The
`dense` output of a motion is dropped.

The first setting of a ladder has the engine's default settings and is marked: `Setting.of(rung="defaults", ...)`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cases import Case

# Names that every adapter must define.
PARTS = ("NAME", "routes", "refuses", "ladder", "build", "run", "read", "version")

# Name of the first rung of a ladder: `Setting.of(rung=DEFAULTS, …)`.
DEFAULTS = "defaults"

# What a route may support, as words of CAPABILITIES.
WORDS = {
    "slip laws": "a friction coefficient that depends on the slip velocity (`CoulombFriction.by_speed`)",
    "corners": "the corners of a track or an outline",
    "several contacts": "it reports each contact of a plate that touches its track in several places",
    "several plates": "further plates (`Case.others`)",
    "free polygons": "a polygon among several plates",
    "supports": "further fixed curves (`Case.supports`)",
    "belts and supports": "belts as well as supports",
    "fixed rotation and supports": "plates that do not turn as well as supports",
    "any shape": "several plates, or plates on supports, of any outline on any curve",
    "pairs": "effects of a pair of bodies (`Case.pairs`)",
    "driven contacts": "a driven track (`Drive`) with corners, with supports that move with it, or several contacts",
    "every scene": "whatever a case may have",
}


def has(adapter: Any, route: str, word: str) -> bool:
    """Whether a route of an adapter has a word of `WORDS`."""
    declared = getattr(adapter, "CAPABILITIES", {}).get(route, ())
    return any(
        each in declared or route in getattr(adapter, each.upper().replace(" ", "_"), ())
        for each in (word, "every scene")
    )


# The functions of an adapter, with the optional ones.
FUNCTIONS = {
    *("refuses", "refuses_several_contacts", "ladder", "default_grid", "grid"),
    *("build", "run", "read", "version", "bare_run"),
}


class EngineFailure(RuntimeError):
    """The engine ran without a usable motion: it stopped with an error, or its numbers are not finite."""


class Refusal(str):
    """Why a route does not support a case, in one sentence: the engine cannot, or its adapter does not yet.

    `limit`: which documented limit of the engine says so, in a phrase; "" if the adapter does not do it yet. A plain
    text of an adapter is of the latter kind.
    """

    limit: str

    def __new__(cls, reason: str, limit: str = "") -> Refusal:
        self = super().__new__(cls, reason)
        self.limit = limit
        return self

    def __reduce__(self):
        return Refusal, (str(self), self.limit)


def refusal_kind(reason: str | Exception) -> str:
    """Which of the two a refusal is, given as text or as NotSupported, in a phrase for tables."""
    limit = getattr(reason, "limit", "")
    return f"the engine cannot: {limit}" if limit else "the adapter does not yet"


# What routes of these names have that is not their engine's.
_OUR_PARTS = {
    "assisted": "our contact geometry around {}'s step",
    "integrator": "our contact geometry and contact law around {}'s integrator",
}


def our_part(adapter: Any, route: str) -> str:
    """What of a route is not its engine's own, in a phrase; "" for an engine by itself."""
    own = getattr(adapter, "OUR_PARTS", {})
    return str(own[route]) if route in own else _OUR_PARTS.get(route, "").format(adapter.NAME)


def refusal(adapter: Any, case: Case, route: str) -> str | None:
    """Why a route does not support a case, in one sentence, or None: by what the adapter has to declare, then by its
    own `refuses`."""
    from cases.own_effects import own_effects  # imports SymPy, which a command's help does not need

    for effect in own_effects(case.effects):
        if not isinstance(effect, getattr(adapter, "OWN_EFFECTS", ())):
            return f"The {route} route does not support {type(effect).__name__}, an effect of a package of its own."
    for is_there, word, what in _needs(case):
        if is_there and not has(adapter, route, word):
            return f"The {route} route does not support {what}."
    return adapter.refuses(case, route)


def _needs(case: Case) -> Iterator[tuple[object, str, str]]:
    """What a route has to declare: whether the case has it, the word for it ("none": no route has it), and what it is,
    in a phrase."""
    from cases import Drive, Impact
    from cases.own_effects import own_effects
    from cases.scene.free_plates import loads_of, plates_of, why_not_closed_forms
    from cases.scene.limits import Scope, has_spinning_plate, limit
    from cases.scene.piece_case import has_pieces
    from cases.scene.supports import has_belt, has_rolling_resistance, has_slip_law

    several, supports, impact = bool(case.others), bool(case.supports), case.effect(Impact)
    drives, belts, packaged = case.effect(Drive) is not None, has_belt(case), bool(own_effects(case.effects))
    yield case.pairs, "pairs", "effects of a pair of bodies (pairs)"
    yield has_slip_law(case), "slip laws", "friction that depends on the slip velocity"
    if several:
        yield True, "several plates", "several plates (others)"
        reason, polygons = why_not_closed_forms(case), any(plate.radius is None for plate in plates_of(case))
        yield polygons and not reason, "free polygons", "several plates unless all of them are discs"
        yield reason, "any shape", f"several plates but discs and one convex polygon on straight lines: {reason}"
        yield any(loads_of(case)), "none", "a load with several plates"
        yield belts, "none", "a belt with several plates"
        yield drives, "none", "a driven track with several plates"
        yield has_slip_law(case), "none", "friction that depends on the slip velocity with several plates"
        yield has_rolling_resistance(case), "none", "rolling resistance with several plates"
        yield packaged, "none", "an effect of a package of its own with several plates"
        yield impact is None, "none", "contacts without Impact with several plates"
    if supports:
        yield packaged, "none", "an effect of a package with several fixed curves (supports)"
        yield True, "supports", "several fixed curves (supports)"
        newton = impact is not None and impact.law == "newton" and belts
        no_form = not several and (limit(case, Scope.SHAPES) or newton)
        yield no_form, "any shape", "this pair of outline and support: their contacts have no closed form"
        held = not case.plate.turns
        yield held, "fixed rotation and supports", "a plate that does not turn on several fixed curves (supports)"
        yield belts, "belts and supports", "belts together with several fixed curves (supports)"
        # A support may resist rolling where the track does not, and contacts are read without a couple of their own.
        yield has_rolling_resistance(case), "none", "rolling resistance on several fixed curves (supports)"
    # In the frame of the track it turns, which no engine's plate of fixed rotation does.
    yield has_spinning_plate(case), "none", "a plate of infinite inertia on a track that turns"
    yield has_pieces(case), "corners", "curves with corners"
    with_several = drives and (has_pieces(case) or supports)
    yield with_several, "driven contacts", "a driven track together with corners or supports"


def refusal_of_several_contacts(adapter: Any, case: Case, route: str) -> str:
    """Why a route does not report the contacts of a plate that touches its track in several places, in one sentence, or
    "": by its `CAPABILITIES`, then by the adapter's own `refuses_several_contacts`."""
    from cases import Drive
    from cases.own_effects import own_effects
    from cases.scene.supports import has_rolling_resistance

    if not has(adapter, route, "several contacts"):
        return f"The plate touches its track in several places, which the {route} route does not support."
    if case.effect(Drive) is not None and not has(adapter, route, "driven contacts"):
        return f"The plate touches its driven track in several places, which the {route} route does not support."
    if has_rolling_resistance(case):
        return f"The {route} route does not report several contacts with rolling resistance."
    if own_effects(case.effects):
        return f"The {route} route does not report several contacts with an effect of a package of its own."
    refuses = getattr(adapter, "refuses_several_contacts", None)
    return (refuses(case, route) or "") if refuses else ""


def _never(case: Case) -> bool:
    return False


@dataclass(frozen=True)
class Meaning:
    """How an engine models one effect (a class of `cases.effects`), on `routes` (on all routes if empty).

    `parameter`: the engine's name for it, and how it combines the numbers of the two bodies; `law`: the engine's law, a
    phrase. `differs(case)`: whether that law differs from the case's. Such a case is still run, and its row reports the
    law and the error. `duration`: of an impact, how long it lasts in the engine; empty for other effects.
    """

    effect: type
    parameter: str
    law: str
    routes: tuple[str, ...] = ()
    differs: Callable[[Case], bool] = _never
    duration: str = ""


def other_laws(adapter, case: Case, route: str) -> tuple[str, ...]:
    """Effects of the case that the route models with a different law, each with that law as a phrase."""
    return tuple(
        f"{meaning.effect.__name__} by another law: {meaning.law}"
        for meaning in getattr(adapter, "MEANINGS", ())
        if (not meaning.routes or route in meaning.routes) and case.effect(meaning.effect) and meaning.differs(case)
    )


@dataclass(frozen=True)
class Setting:
    """One rung of a ladder: the engine's knobs by name, in a fixed order. `str(setting)` is for tables only.

    It reads like a mapping: `"h" in setting`, `setting["h"]`, `setting.get("h")`, `dict(setting)`.
    """

    values: tuple[tuple[str, float | int | str], ...]

    @classmethod
    def of(cls, **values: float | int | str) -> Setting:
        """A setting from keyword arguments, in their order."""
        return cls(tuple(values.items()))

    def but(self, **values: float | int | str | None) -> Setting:
        """A copy with some knobs changed or added, in the same order; None removes a knob."""
        knobs = dict(self.values) | values
        return Setting.of(**{name: value for name, value in knobs.items() if value is not None})

    def combinations(self, **values: Sequence[float | int]) -> tuple[Setting, ...]:
        """All combinations of some knobs' values, the other knobs as they are; this setting is the first. Knobs that it
        does not have are left out."""
        own = {name: dict.fromkeys((self[name], *some)) for name, some in values.items() if name in self}
        return tuple(self.but(**dict(zip(own, chosen, strict=True))) for chosen in product(*own.values()))

    @property
    def is_default(self) -> bool:
        """Whether these are the engine's default settings."""
        return self.get("rung") == DEFAULTS

    def keys(self) -> tuple[str, ...]:
        """The knobs' names."""
        return tuple(name for name, _ in self.values)

    def get(self, name: str, default=None):
        """A knob's value, or the default where the setting has no such knob."""
        return dict(self.values).get(name, default)

    def __contains__(self, name: object) -> bool:
        return name in dict(self.values)

    def __getitem__(self, name: str):
        return dict(self.values)[name]

    def __str__(self) -> str:
        return " ".join(f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in self.values)


class ReturnsOnce:
    """An adapter whose functions return in the calling process only.

    An engine may fork, and both processes may return. Both would then continue the caller's work, and each further call
    would double them again. The child process ends here instead.
    """

    def __init__(self, adapter: Any):
        self._adapter = adapter

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._adapter, name)
        return returns_once(attribute) if name in FUNCTIONS else attribute


def returns_once(function: Callable) -> Callable:
    """The function, changed so that a child process forked inside it ends instead of returning."""

    def call(*args: Any, **keywords: Any) -> Any:
        own = os.getpid()
        try:
            return function(*args, **keywords)
        finally:
            if os.getpid() != own:
                os._exit(0)

    return call
