"""`prove`: a case's motion as a theorem, by validated integration in ball arithmetic."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from importlib.metadata import version

import flint
from flint import arb, ctx

from cases import BadValue, Case
from cases.errors import whole
from cases.version import __version__

from .equations import equations
from .motion import MotionProof, follow
from .record import DecimalInterval, Proof, ProvedPhase, ProvedTransition, outward, statement
from .scene import Scene, exact_scene
from .single_contact import second_contact

# Digits beyond those that are asked for. The set of states grows by the wrapping effect; where the first are not
# enough, the proof begins again with the next.
RESERVES = (14, 40, 120)
MOST_DIGITS = 1000
# Order of the Taylor series per digit of the tolerance: near the least time in trials with 20 to 60 digits.
ORDER_PER_DIGIT = 1.1
ALL = 10**6

METHOD = (
    "validated Taylor integration in ball arithmetic (Arb), one exact start; zeros of the conditions isolated by "
    "interval Newton; the mode after each event by strict inequalities"
)
CONDITIONS = {
    "slip": "the slip velocity does not vanish",
    "normal_force": "the normal force does not vanish",
    "painleve": "the normal equation's coefficient does not vanish (no paradox)",
    "cone_forward": "friction stays inside its cone, on the side of a forward slip",
    "cone_backward": "friction stays inside its cone, on the side of a backward slip",
    "turn": "the rotation does not vanish",
    "fit": "the curvatures of outline and track differ",
    "track_start": "the contact does not reach the start of the track",
    "track_end": "the contact does not reach the end of the track",
    "outline_start": "the contact does not reach the start of the outline",
    "outline_end": "the contact does not reach the end of the outline",
    "rest": "friction and resistance stay inside their bounds while the plate rests",
}
ASSUMPTIONS = (
    "rigid plate, Coulomb friction as in the paper's (28)-(34), no impact while the contact lasts",
    "the numbers of the scene as listed",
    "the track is a simple curve",
    "each motion considered stays in one mode for some time after each event",
    "Arb, python-flint, and SymPy's derivatives and trigonometric simplification are correct",
)


def prove(
    case: Case, digits: int = 20, transitions: int | None = None, report: Callable[[str], None] | None = None
) -> Proof:
    """Prove the motion of a case: its modes, and an enclosure of each transition's time of relative width 10^-digits.

    `transitions`: how many of them at most (None: the whole motion). `report` is called with a text at each transition.
    The proof ends where a condition cannot be proved; its status is then "unproved", and its reason says why.
    Raises NotSupported for a case outside the class that proofs cover, BadValue for invalid arguments.
    """
    if not isinstance(case, Case):
        raise BadValue(f"prove was given {type(case).__name__}; give a Case, for example cases.load(name)")
    digits = whole("digits of the proof", digits, 1, MOST_DIGITS)
    most = ALL if transitions is None else whole("transitions of the proof", transitions, 1, ALL)
    scene, began = exact_scene(case), time.process_time()
    precision, cap = ctx.prec, ctx.cap
    try:
        for reserve in RESERVES:
            working = digits + reserve
            ctx.prec = bits_of(working)
            motion = follow(equations(scene), order_of(working), arb(10) ** -working, most, report)
            if _is_narrow(motion, digits) and (motion.status != "unproved" or not motion.covered):
                break
        return _record(case, scene, motion, digits, working, time.process_time() - began)
    finally:
        ctx.prec, ctx.cap = precision, cap


def order_of(working: int) -> int:
    return max(20, round(ORDER_PER_DIGIT * working))


def bits_of(working: int) -> int:
    return round(working * 3.33) + 64


def _is_narrow(motion: MotionProof, digits: int) -> bool:
    return all(2 * t.time.rad() <= t.time.mid() * arb(10) ** -digits for t in motion.transitions)


def _record(case: Case, scene: Scene, motion: MotionProof, digits: int, working: int, cpu: float) -> Proof:
    def ends(ball: arb) -> DecimalInterval:
        return outward(ball, digits + 3)

    transitions = tuple(
        ProvedTransition(
            before=str(t.before),
            after=str(t.after),
            time=ends(t.time),
            xi1=ends(t.state["xi1"] + scene.track_turns * arb.pi() / 2),
            state={name: ends(ball) for name, ball in t.state.items() if name != "xi1"},
            cause=t.cause,
            decision=t.reason,
            rolling_share=None if t.share is None else ends(t.share),
        )
        for t in motion.transitions
    )
    phases = tuple(
        ProvedPhase(str(p.regime.mode), ends(p.begin), ends(p.end), tuple(CONDITIONS[g] for g in p.guards), p.steps)
        for p in motion.phases
    )
    contact = second_contact(scene, case.track, case.plate.outline, motion.xi1_range)
    end, first_mode = ends(motion.end), str(motion.first_mode or "none")
    return Proof(
        case=case.label,
        status=motion.status,
        reason=motion.reason,
        statement=statement(case.label, first_mode, transitions, motion.status, end),
        first_mode=first_mode,
        transitions=transitions,
        phases=phases,
        end=end,
        scene=scene.described(),
        proved=(contact.sentence,) if contact.proved else (),
        assumptions=(*ASSUMPTIONS, *(() if contact.proved else (contact.sentence,))),
        method=METHOD,
        precision={
            "digits": digits,
            "working_digits": working,
            "bits": bits_of(working),
            "order": order_of(working),
        },
        versions={
            "slip-to-roll": __version__,
            "python": sys.version.split()[0],
            "python-flint": version("python-flint"),
            "flint": flint.__FLINT_VERSION__,
            "sympy": version("sympy"),
        },
        cpu_s=round(cpu, 3),
    )
