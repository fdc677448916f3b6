"""Certificates: the values on which several independent solutions of a case agree, with error bars.

Witnesses: the Taylor method at two tolerances and in quadruple precision within each phase (where heyoka is
installed), DOP853 at its tightest tolerance, and the second formulation, which shares geometry of curves only. The
central value is that of the most precise witness; `bars` computes its error bar. If a witness cannot run, the truth
rests on the others, and the certificate records this. The most precise motion also passes the check of laws, which
compares it with no other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cases import Case, CaseError, Mode

from ..endings import BROKEN_LAW
from ..laws_check.full_check import check
from ..proofs import catalogue
from ..time_limit import OutOfTime, cpu_limit
from .bars import METHOD_ULPS, Bar, Shares, ambiguity, bar, roundings, shares
from .witnesses import EPS, PREDICTION, Witness, quantities, witnesses

SAMPLES = 11
PROVED, WITNESSED = "proved", "witnessed"
CHECK_OF_LAWS = "check of laws"

# Witnesses whose transition times differ by more than this (s) contradict each other, and an end with a wider bar is
# rejected: it is a million times the usual difference, and too coarse to judge engines that come within 1e-8 s.
WIDEST = 1e-7

# A position with a wider bar than this part of the plate's size is rejected: a caliper reads a thousandth, and a figure
# shows it. The same applies to the plate's angle, in radians.
COARSEST = 1e-3


# CPU seconds for the motions from states moved by roundings.
MOST_S = 200


class NotCertified(CaseError):
    """The witnesses disagree on the events, or the error bars are too wide: a solver is wrong, or the result depends on
    roundings."""


@dataclass(frozen=True)
class Certificate:
    """The certified motion of a case: transitions with bars on their times, sample states with bars.

    `samples` maps a quantity to bars at `times`; `witnesses` names the solutions that agree, `missing` has a sentence
    for each solution that could not run.
    """

    case: str
    status: str
    end: Bar
    transitions: tuple[tuple[Mode, Mode, Bar, Bar], ...]  # before, after, time (s), xi1 (rad)
    times: tuple[float, ...]
    samples: dict[str, tuple[Bar, ...]]
    witnesses: tuple[str, ...]
    missing: tuple[str, ...] = ()

    @property
    def confirmations(self) -> dict[str, tuple[str, ...]]:
        """What is confirmed, and by which witnesses."""
        return confirmations(self.witnesses)

    @property
    def kinds(self) -> tuple[str, ...]:
        """For each transition "proved", if the stored proof of the catalogue's case has the same modes up to there, and
        its intervals of time and place are inside the bars, else "witnessed"."""
        proof, count = catalogue.read().get(self.case), 0
        for claim, (before, after, time, xi1) in zip(
            proof.transitions if proof else (), self.transitions, strict=False
        ):
            if (claim.before, claim.after) != (str(before), str(after)):
                break
            if not (claim.time.inside(*time) and claim.xi1.inside(*xi1)):
                break
            count += 1
        return (PROVED,) * count + (WITNESSED,) * (len(self.transitions) - count)


def confirmations(names: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """What witnesses with those names confirm: the second formulation predicts no places or poses, and forces are
    compared with the laws, not with each other."""
    first = tuple(name for name in names if name != PREDICTION)
    by_laws = (CHECK_OF_LAWS,)
    return {
        "sequence, status and times": names,
        "places and poses": first,
        "forces and impacts": by_laws,
        "uniqueness": by_laws,
    }


def certify(case: Case) -> Certificate:
    """Compute the case's motion with error bars.

    Raises NotCertified, with the witnesses and their answers, if they contradict each other or their bars are too wide,
    with the law, the place and the time if the motion of one breaks a law, and if it takes too long.
    """
    try:
        able, missing = witnesses(case)
    except FloatingPointError as problem:
        raise NotCertified(f"{case.label}: {problem}") from problem
    if any(one.status == BROKEN_LAW for one in able):
        raise NotCertified(f"{case.label}: {_faults(case, able)}")
    if not able:
        raise NotCertified(f"{case.label}: no witness reaches the end of the motion: {'; '.join(missing)}")
    if len(able) < 2:
        raise NotCertified(f"{case.label}: a certificate needs at least two witnesses; {'; '.join(missing)}")
    if faults := _faults(case, able[:1]):
        raise NotCertified(f"{case.label}: {faults}")
    # The samples end at the earliest end, so that every witness has a state there.
    times = np.linspace(0.0, min(witness.end for witness in able), SAMPLES)
    method = "taylor" if "taylor 1e-12" in [witness.name for witness in able] else "dop853"
    try:
        with cpu_limit(MOST_S):
            moves = shares(case, times, method)
            _check_events(case, able, moves, method)
    except OutOfTime:
        law = _faults(case, able) or f"{able[0].name} finds {able[0].answer}"
        late = f"the effect of roundings takes more than {MOST_S} s of CPU time to compute"
        raise NotCertified(f"{case.label}: {law}; {late}") from None
    certificate = _certificate(case, able, missing, times, moves, METHOD_ULPS[method] * EPS)
    _check_bars(case, certificate, able, moves)
    return certificate


def _certificate(
    case: Case, able: list[Witness], missing: list[str], times: np.ndarray, moves: Shares, rounding: float
) -> Certificate:
    centre = able[0]
    states = [witness.states(times) for witness in able if witness.motion is not None]
    sample_roundings = roundings(case, centre, times, rounding)
    gyration = case.plate.gyration
    transitions = []
    for i, same in enumerate(zip(*(witness.transitions for witness in able), strict=True)):
        first = same[0]
        time = bar([t.time for t in same], rounding * first.time + float(moves.times[i]))
        along = float(case.track.speed(first.xi1))
        size = max(abs(first.xi1), gyration / along if along else 1.0)  # at a corner the parameter is an angle
        place = bar([t.xi1 for t in same], rounding * size + float(moves.places[i]), case.track.period)
        transitions.append((first.before, first.after, time, place))
    return Certificate(
        case=case.label,
        status=centre.status,
        end=bar([witness.end for witness in able], rounding * centre.end + moves.end),
        transitions=tuple(transitions),
        times=tuple(times.tolist()),
        samples={
            q: tuple(
                bar([state[q][i] for state in states], float(sample_roundings[q][i] + moves.samples[q][i]))
                for i in range(len(times))
            )
            for q in quantities(case)
        },
        witnesses=tuple(witness.name for witness in able),
        missing=tuple(missing),
    )


# --- witnesses that contradict each other -----------------------------------------------------------------------------


def _check_events(case: Case, able: list[Witness], moves: Shares, method: str) -> None:
    """Raise NotCertified if two witnesses differ in their events, or in a time by more than `WIDEST`, or if a few
    roundings of the state change the events."""
    centre = able[0]
    for other in able[1:]:
        if other.events != centre.events:
            fault = _faults(case, able) or _conditioning(
                moves if moves.ill else moves._replace(ill=ambiguity(case, method))
            )
            raise NotCertified(f"{case.label}: {_contradiction(centre, other)}; {fault}")
    for other in able[1:]:
        for one, same in zip(centre.transitions, other.transitions, strict=True):
            if abs(one.time - same.time) > WIDEST:
                message = f"{centre.name} finds {one.after} at {one.time!r} s, {other.name} at {same.time!r} s"
                fault = _faults(case, able) or _conditioning(moves, bool(np.any(moves.times > WIDEST)))
                raise NotCertified(f"{case.label}: {message}; {fault}")

    if moves.ill:
        raise NotCertified(f"{case.label}: all witnesses find {centre.answer}, but {_conditioning(moves)}")


def _faults(case: Case, able: list[Witness]) -> str:
    """Which motion of a witness breaks which law, where and when; "" if none does."""
    parts = []
    for one in able:
        laws = check(case, one.motion) if one.motion is not None else ()
        parts += [f"{one.name} breaks a law, {laws[0]}"] if laws else []
    return "; ".join([*parts, "please report the scene"]) if parts else ""


def _contradiction(one: Witness, other: Witness) -> str:
    return f"{one.name} finds {one.answer}; {other.name} finds {other.answer}"


def _conditioning(moves: Shares, spreads: bool = False) -> str:
    """The likely cause of a contradiction: the scene, if moving its state by roundings shows it, else a solver."""
    if moves.ill:
        return f"{moves.ill}: the scene is ill-conditioned, change a parameter a little"
    if spreads:
        return (
            "roundings of its state have as large an effect: the scene is ill-conditioned, change a parameter a little"
        )
    return "roundings of its state have no such effect, so one of the two may be wrong: please report the scene"


def _check_bars(case: Case, certificate: Certificate, able: list[Witness], moves: Shares) -> None:
    """Raise NotCertified if the error bar of the motion's end, or of the plate's position or angle, is too wide."""
    if certificate.end.bar > WIDEST:
        other = max(able, key=lambda witness: abs(witness.end - certificate.end.value))
        wide = f"the end ({certificate.status}) is known to {certificate.end.bar:.2g} s only, more than {WIDEST:g} s"
        ends = f"{able[0].name} finds {able[0].end!r} s, {other.name} {other.end!r} s"
        raise NotCertified(f"{case.label}: {wide} ({ends}); {_conditioning(moves, moves.end > WIDEST)}")
    outline = case.plate.outline
    size = float(np.ptp(outline.point(np.linspace(*outline.span, 721)), axis=1).max())
    for quantity, unit, limit in (("x", "m", COARSEST * size), ("y", "m", COARSEST * size), ("theta", "rad", COARSEST)):
        bars = certificate.samples[quantity]
        i = int(np.argmax([one.bar for one in bars]))
        if bars[i].bar > limit:
            t = certificate.times[i]
            some = [witness for witness in able if witness.motion is not None]
            values = [float(witness.states(np.array([t]))[quantity][0]) for witness in some]
            far = int(np.argmax(np.abs(np.array(values) - values[0])))
            precision = (
                f"{quantity} at {t:.4g} s is known to {bars[i].bar:.2g} {unit} only, more than {limit:.2g} {unit}"
            )
            values_text = f"{some[0].name} finds {values[0]:.9g}, {some[far].name} {values[far]:.9g}"
            fault = _conditioning(moves, bool(moves.samples[quantity][i] > 0.1 * limit))
            raise NotCertified(f"{case.label}: {precision}, a thousandth of the plate ({values_text}); {fault}")
