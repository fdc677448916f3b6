"""A refusal is one sentence, and says which of two it is: the engine cannot, by a documented limit, or its adapter does
not yet."""

from __future__ import annotations

import pickle
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import cases
from adapters import Refusal, refusal, refusal_kind, refusal_of_several_contacts
from adapters.interface import has
from adapters.lookup import engine
from cases import (
    Belt,
    Case,
    CoulombFriction,
    Curve,
    Drive,
    Flight,
    Gravity,
    Impact,
    Load,
    NotSupported,
    PerfectlyRough,
    Plate,
    RollingResistance,
    Start,
    StartPose,
    Support,
    Unilateral,
    UnknownName,
    curves,
    disc,
    library,
)
from reports.running import tasks
from tests.sampling import quick_every
from tests.scenes.elliptic import ellipse

from .engines import routes
from .test_motions import CORNERS, GRIP, SCENES, SPEED, belts_in_v, groove, spline

CANNOT, NOT_YET = "the engine cannot: ", "the adapter does not yet"
G, PUSH = Gravity(9.81), Unilateral()
STATIC = CoulombFriction(0.1, mu_static=0.2)
ELLIPSE = Plate(ellipse(0.2, 0.1), 1.0, 0.0125)


def on(track: Curve, *effects, plate: Plate | None = None) -> Case:
    """A plate on a track under gravity."""
    return Case(track, plate or disc(0.1, 1.0), (G, *effects), Start(0.0, None if plate is None else -1.2), 1.0)


ROCKS = SCENES["block on a hill"]()
GEAR = Case(library.line(0.2), Plate.gear(0.1, 6, 0.02, 1.0), CORNERS, Start(0.0, xi2=0.3), 1.0)
EDGE = Plate(Curve(lambda s: (s, 0), domain=(-1, 1)), 1.0, 0.1)
STRAIGHT = Case(Curve(lambda s: (curves.sin(s), curves.cos(s))), EDGE, (G, PUSH), Start(0.0, 0.0), 1.0)
BOWL = library.circle(1.0)
WAVE = Support(library.cosine(0.1, 9.0), "wave")


def variant_of(name: str, route: str, label: str) -> Case:
    """The first variant of a case that the route refuses."""
    return next(case for case in cases.select(label) if refusal(engine(name), case, route))


def with_support(support: Support, **changes) -> Case:
    """The disc in a groove of two planes, with another second one."""
    return replace(groove(), supports=(support,), **changes)


# Engine and route, a label or a case, and words of the limit or of the reason; the kind is that of the first word.
ROWS = [
    ("exudyn native", "disc_rolling_to_rest", "cannot", "no such parameter"),
    ("exudyn native", "slider_on_belt", "cannot", "dynamicFriction"),
    ("exudyn native", "slider_on_belt_falling_law", "cannot", "StribeckFunction"),
    ("exudyn native", on(BOWL, STATIC, PUSH), "cannot", "mu_static"),
    ("exudyn native", on(BOWL, CoulombFriction(0.1)), "not yet", "Unilateral"),
    ("exudyn native", "guided_loop", "not yet", ""),
    ("exudyn native", "disc_in_cosine", "not yet", "track"),
    ("exudyn native", "half_disc_rocking", "not yet", ""),
    ("exudyn native", on(BOWL, PUSH, plate=ELLIPSE), "not yet", "outline"),
    ("exudyn native", spline(), "not yet", "lines and circles"),
    ("exudyn native", SCENES["varying belt in a drum"](), "not yet", "constant speed"),
    ("exudyn integrator", on(BOWL, PUSH, Flight(), Impact(0.5)), "not yet", "restitution"),
    ("pymunk native", on(BOWL, STATIC, PUSH), "cannot", "coefficient"),
    ("pymunk native", "slider_on_belt", "cannot", "Shape.friction"),
    ("pymunk native", "guided_loop", "not yet", "bilateral guide"),
    ("pymunk native", GEAR, "not yet", "point inwards"),
    ("pymunk assisted", "sliding_box", "not yet", "curves with corners"),
    ("pymunk assisted", on(BOWL, PUSH, Flight(), Impact(0.5)), "not yet", "restitution"),
    ("pymunk assisted", groove(), "not yet", "several fixed curves (supports)"),
    ("pymunk assisted", "box_on_shaken_table", "not yet", "curves with corners"),
    ("pymunk assisted", "row_of_discs", "not yet", "several plates (others)"),
    ("box2d native", on(BOWL, STATIC, PUSH), "cannot", "friction is one number"),
    ("box2d native", on(BOWL), "not yet", "bilateral guide"),
    ("box2d native", STRAIGHT, "not yet", "convex"),
    ("box2d native", GEAR, "not yet", "point inwards"),
    ("box2d native", on(BOWL, Load(fx=1.0), PUSH), "not yet", "does not support Load"),
    ("box2d native", on(library.line(), CoulombFriction(0.1), RollingResistance(0.01), PUSH, plate=ELLIPSE), "cannot",
     "multiple of the shape's radius"),
    ("box2d native", SCENES["varying belt in a parabola"](), "not yet", "only lines and circles"),
    ("box2d native", on(library.line(), *GRIP[1:], Belt(SPEED), Drive(x="0.1*sin(t)")), "not yet", "not both"),
    ("box2d native", belts_in_v("1", "1 - t"), "not yet", "tangent speed that they are made with"),
    ("box2d native", belts_in_v("1 - t", "1"), "not yet", "tangent speed that they are made with"),
    ("pybullet assisted", "slider_on_belt", "not yet", ""),
    ("pybullet assisted", on(BOWL), "not yet", "bilateral guide"),
    ("pybullet assisted", on(BOWL, PUSH, plate=ELLIPSE), "not yet", "no circle"),
    ("pybullet assisted", on(BOWL, PUSH, Load(fx=1.0)), "not yet", "Load"),
    ("pybullet assisted", on(BOWL, PUSH, PerfectlyRough()), "not yet", "PerfectlyRough"),
    ("pybullet assisted", on(BOWL, PerfectlyRough(), RollingResistance(0.01)), "not yet", "support PerfectlyRough"),
    ("pybullet assisted", on(BOWL, PUSH, Flight(), Impact(0.5)), "not yet", "Flight and Impact"),
    ("pymunk native", with_support(Support(Curve(lambda s: (s, 0.1 * s * s - 3.0)), "valley")), "not yet",
     "must have ends, and the support 'valley' has none."),
    ("exudyn native", with_support(WAVE, start=StartPose(0.0, 2.0)), "not yet",
     "A plate may touch the support 'wave' in several places"),
    ("exudyn native", with_support(Support(library.circle(3.0), "bowl", (CoulombFriction(0.3), Belt(1.0)))), "not yet",
     "Belts run on straight supports only here, and 'bowl' is none."),
    ("exudyn native", with_support(Support(library.line(-np.pi / 9), "right", (STATIC,))), "cannot", "dynamicFriction"),
    ("exudyn native", with_support(Support(library.line(-np.pi / 9), "right", (PerfectlyRough(),))), "cannot",
     "is a constraint"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("solver", "scene", "kind", "words"),
    ROWS,
    ids=[f"{solver}, {scene if isinstance(scene, str) else words}" for solver, scene, _, words in ROWS],
)
def test_a_refusal_names_the_engine_s_limit_or_what_its_adapter_lacks(solver, scene, kind, words):
    name, route = solver.split()
    pytest.importorskip(f"adapters.{name}")
    case = variant_of(name, route, scene) if isinstance(scene, str) else scene
    reason = refusal(engine(name), case, route)
    assert reason and reason.endswith(".") and reason.count(". ") == 0
    assert words in reason or words in refusal_kind(reason)
    assert refusal_kind(reason).startswith(CANNOT) if kind == "cannot" else refusal_kind(reason) == NOT_YET


def test_neighbours_of_refused_scenes_are_accepted():
    bowl = with_support(Support(library.circle(3.0), "bowl"))
    on_belt = replace(groove(), effects=(*groove().effects, Belt(1.0)))
    for name in ("exudyn", "pymunk"):
        assert refusal(engine(name), bowl, "native") is refusal(engine(name), on_belt, "native") is None
    guided, flying = on(BOWL), on(BOWL, PUSH, Flight(), Impact(0.0))
    assert refusal(engine("pymunk"), guided, "assisted") is refusal(engine("pymunk"), flying, "assisted") is None
    assert refusal(engine("exudyn"), guided, "integrator") is None
    assert refusal(engine("exudyn"), on(BOWL, PUSH, plate=ELLIPSE), "integrator") is None


def test_a_driven_track_with_corners_needs_a_declaration():
    pymunk, case = engine("pymunk"), cases.load("box_on_shaken_table")
    without = SimpleNamespace(CAPABILITIES={"native": ("corners",)}, refuses=pymunk.refuses)
    why = "The native route does not support a driven track together with corners or supports."
    assert refusal(without, case, "native") == why


@pytest.mark.parametrize(("name", "route"), routes())
def test_an_effect_that_nobody_modelled_is_refused_by_its_name_and_corners_by_theirs(name, route):
    class Magnetism:
        pass

    assert "Magnetism" in engine(name).refuses(SimpleNamespace(effects=(G, Magnetism())), route)
    if not has(engine(name), route, "corners"):
        assert "corners" in (refusal(engine(name), ROCKS, route) or "")
        assert "corners" in (refusal(engine(name), SCENES["disc over an edge"](), route) or "")


@pytest.mark.parametrize("name", ["exudyn", "box2d", "pybullet"])
def test_an_unknown_route_is_told_with_those_there_are(name):
    adapter = pytest.importorskip(f"adapters.{name}")
    with pytest.raises(UnknownName, match=adapter.routes[0]):
        adapter.refuses(cases.load("disc_in_circle"), "magic")


def test_several_contacts_are_refused_in_one_sentence():
    rocking, pymunk = cases.load("disc_rocking_in_groove"), engine("pymunk")
    assert refusal_of_several_contacts(pymunk, rocking, "native") == ""
    for case, route, words in (
        (rocking, "assisted", "touches its track in several places, which the assisted route does not support"),
        (replace(rocking, plate=cases.load("ellipse_on_line").plate), "native", "computed for round plates only"),
    ):
        assert words in refusal_of_several_contacts(pymunk, case, route)


@quick_every(8)
@pytest.mark.parametrize("label", cases.names())
def test_every_refusal_of_the_catalogue_is_one_sentence(label):
    for name, route in routes():
        for case in cases.select(label):
            reason = refusal(engine(name), case, route)
            assert reason is None or (reason.endswith(".") and ". " not in reason), (case.label, route, reason)


def test_the_kind_reaches_the_report_s_rows_from_an_adapter_and_from_a_program(monkeypatch):
    reason = Refusal("It has no belts.", "manual, belts")
    assert pickle.loads(pickle.dumps(reason)).limit == "manual, belts"
    (offer,) = tasks.survey(cases.load("disc_rolling_to_rest"), "pymunk")[:1]
    assert (offer.outcome, offer.refusal) == ("unsupported", "the engine cannot: no such attribute of pymunk.Shape")

    def run(model):
        raise NotSupported(reason, reason.limit)

    program = SimpleNamespace(
        NAME="mine", routes=("process",), build=lambda *_: None, run=run, read=None, refuses=lambda *_: None
    )
    monkeypatch.setattr(tasks, "solver", lambda name: program)
    row = tasks.Run("case", "mine", "process", tasks.Setting.of(), 1, outcome="")
    row, _ = tasks.attempt(row, cases.load("disc_in_circle"))
    assert (row.outcome, row.reason, row.refusal) == ("unsupported", str(reason), "the engine cannot: manual, belts")
