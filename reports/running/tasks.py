"""The tasks of a worker: list the settings that a solver offers, find a case's truth, run one setting and judge it.

Whatever a solver does short of ending the process becomes a record.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from types import ModuleType

import numpy as np

import cases
import reference
from adapters import Setting, gate, other_laws, our_part, refusal, refusal_kind, refusal_of_several_contacts
from adapters.processes.worker import settle, without_engines
from cases import Case, CaseError, Impact, NotSupported, Trajectory, Transition
from cases.errors import legible
from cases.files import owned_folder
from reference.certification import Certificate, NotCertified, contradiction, is_within_bars, stored_or_new

from ..judging import claims, distances, grades, impacts, several_contacts, validation
from ..judging.friction_factor import friction_factor, is_defined
from ..judging.friction_sensitivity import LEAST, friction_sensitivity
from ..judging.law_error import law_error
from ..judging.null_motions import null_motions
from ..judging.score import doubt_of_reading
from .clocked_run import run_on_clock
from .records import TRUTH_RTOL, Offer, Run, Truth, is_truth, now
from .solvers import NOT_INSTALLED, solver
from .true_motions import true_motion

# Samples that a figure can show, and the page's player (of differences); of more, evenly spaced ones are kept.
_SHOWN_SAMPLES, _PLAYER_SAMPLES = 1500, 401
# The differences from the truth that the player shows, of the case's plate; of others those of the pose.
_PLAYER_OFF = ("t", "x", "y", "angle", "slip")
_COLUMNS = ("x", "y", "theta", "slip", "xi1", "xi2", "normal_force", "friction_force")
# Limits on the number of an adapter's routes (others are ignored), on the settings of a ladder or grid, and on the
# characters of a setting: far more than would be run or read.
_MOST_ROUTES, _MOST_SETTINGS, _LONGEST_SETTING = 20, 1000, 500


def survey(case: Case, name: str, knobs: str = "ladder") -> tuple[Offer, ...]:
    """The offer of each route of a solver for a case: the settings of its ladder, after the grid of its default
    settings if it has one; or the settings of its grid."""
    try:
        module = solver(name)
    except ImportError as problem:
        return (Offer("", (), NOT_INSTALLED, f"{name} is not installed here ({problem})"),)
    if not hasattr(module, knobs):
        return ()
    try:
        routes = gate.routes(module.routes)[:_MOST_ROUTES]
    except Exception as problem:  # they may also be a property that fails
        return (Offer("", (), "crashed", reason_of_crash(problem)),)
    return tuple(_offer(module, case, legible(route), knobs) for route in routes)


def _offer(module: ModuleType, case: Case, route: str, knobs: str) -> Offer:
    part = ""
    try:
        part = legible(our_part(module, route))
        reason = refusal(module, case, route)
        if reason:
            return Offer(route, (), "unsupported", legible(reason), part, refusal=legible(refusal_kind(reason)))
        settings = tuple(islice(getattr(module, knobs)(case, route), _MOST_SETTINGS + 1))
        if knobs == "ladder" and hasattr(module, "default_grid"):
            first = tuple(islice(module.default_grid(case, route), _MOST_SETTINGS))
            if first[:1] != settings[:1]:
                raise ValueError("its default_grid does not begin with the first setting of its ladder")
            settings = (*first, *settings[1:])
        if len(settings) > _MOST_SETTINGS:
            raise ValueError(f"it has more than {_MOST_SETTINGS} settings")
        one_only = legible(refusal_of_several_contacts(module, case, route))
        return Offer(route, tuple(map(_plain, settings)), our_part=part, one_contact_only=one_only)
    except (Exception, SystemExit) as problem:
        return Offer(route, (), "crashed", f"its {knobs} fails: {reason_of_crash(problem)}", part)


def _plain(given: object) -> Setting:
    """The setting as plain values; raises ValueError if it is too long or cannot be printed in a file."""
    setting = gate.setting(given)
    if legible(setting, _LONGEST_SETTING) != str(setting):
        raise ValueError(f"a setting is longer than {_LONGEST_SETTING} characters, or cannot be printed")
    return setting


def find_truth(case: Case) -> Truth:
    """The certified truth of a case: from the suite's file for its catalogue, certified now for any other case. There
    is none if the certificate and the reference's motion contradict each other. Raises DamagedTruth."""
    is_stored = in_catalogue(case)
    try:
        certificate = stored_or_new(case, use_file=is_stored)
    except NotCertified as problem:
        return Truth(failure=str(problem))
    method = reference.METHODS[0]
    motion = true_motion(case, method)
    # The coarser motion, whose equations are compiled for its tolerance, only serves to know the motion's error.
    contradicted = (
        "" if is_within_bars(case, certificate, motion) else _contradiction(case, certificate, motion, method)
    )
    if contradicted:
        report = "please report the scene"
        if is_stored:
            report = f'please report it with: python -m reference --only "{case.label}" --out certificate.json'
        return Truth(failure=f"{case.label}: {contradicted}; neither is used; {report}")
    certified = certificate.transitions
    events = tuple(replace(event, time=row[2].value) for event, row in zip(motion.transitions, certified, strict=True))
    truth = truth_of(case, motion, events, method)
    return replace(
        truth,
        contact_samples=_contact_samples(motion) if truth.has_several_contacts else {},
        plate_samples={name: _plate_samples(motion, name) for name in motion.plate_names[1:]},
        friction_sensitivity=friction_sensitivity(case, motion, truth.scales),
        error_bars=tuple(row[2].bar for row in certified),
        witnesses=certificate.witnesses,
        centre_bar=_centre_bar(certificate, motion),
        kinds=certificate.kinds if is_stored else (),
    )


def truth_of(case: Case, motion: Trajectory, events: Sequence[Transition], method: str) -> Truth:
    """The truth by a motion that is known at every time, with these transitions, without error bars."""
    return Truth(
        method=method,
        transitions=tuple(events),
        scales=several_contacts.scales(case, motion, events, null_motions(case)),
        first_mode=motion.first_mode,
        status=motion.status,
        reason=motion.reason,
        samples=_samples(motion),
    )


def _contradiction(case: Case, certificate: Certificate, motion: Trajectory, method: str) -> str:
    coarser = reference.simulate(case, rtol=10.0 * TRUTH_RTOL, method=method)
    return contradiction(case, certificate, motion, coarser, method)


def _contact_samples(motion: Trajectory) -> dict[str, dict[str, np.ndarray]]:
    """Samples of each contact of a motion with several, for the player; parameters only while it is closed."""
    times, samples = _shown_times(motion), {}
    assert motion.contact_columns is not None, "a motion with several contacts has the columns of each"
    for name in motion.contact_names:
        now = motion.contact_columns(name, times)
        samples[name] = {
            "t": times,
            "xi1": np.where(np.isnan(now.slip), np.nan, now.xi1),
            "normal_force": now.normal_force,
            "friction_force": now.friction_force,
            "normal_low": now.normal_range[0],
            "normal_high": now.normal_range[1],
        }
    return samples


def _shown_times(motion: Trajectory) -> np.ndarray:
    """Evenly spaced times, and those of the transitions."""
    events = [event.time for event in motion.transitions]
    return np.union1d(np.linspace(motion.t[0], motion.t[-1], _SHOWN_SAMPLES - len(events)), events)


def _plate_samples(motion: Trajectory, name: str) -> dict[str, np.ndarray]:
    """Samples of the pose of a free plate."""
    times = _shown_times(motion)
    now = motion.plate(name)(times)
    return {"t": times, "x": np.asarray(now.x), "y": np.asarray(now.y), "theta": np.asarray(now.theta)}


def in_catalogue(case: Case) -> bool:
    """Whether it is a case of the catalogue; a script may give the same name to a different case."""
    try:
        return cases.load(case.name, **case.parameters) == case
    except CaseError:
        return False


def _centre_bar(certificate: Certificate, motion: Trajectory) -> float:
    """Error bar of the motion's centre, m: its largest distance from the certified samples, plus their error bars."""
    state = motion(np.minimum(certificate.times, motion.t[-1]))
    off = []
    for values, certified in ((state.x, certificate.samples["x"]), (state.y, certificate.samples["y"])):
        centres, bars = np.array(certified).T
        off.append(np.abs(values - centres) + bars)
    return float(np.hypot(*off).max())


def _samples(motion: Trajectory) -> dict[str, np.ndarray]:
    """Samples of a motion for figures, at even distances and at its transitions: the paper's v, ξ₁, ξ₂ and θ, the
    centre and the contact's forces."""
    times = _shown_times(motion)
    state = motion(times)
    return {"t": times} | {name: np.asarray(getattr(state, name)) for name in _COLUMNS}


def measure(
    case: Case, name: str, route: str, setting: Setting, rung: int, truth: Truth,
    is_hard: bool = False, in_detail: bool = True, true: Trajectory | None = None,
) -> Run:  # fmt: skip
    """Run one setting of one route and judge it, in a process without engines. Only `run` of the solver is timed.

    The run that the others are compared with is the truth's motion, with the times measured when that was computed.
    `is_hard`: the run has its residuals, and no samples for figures; `in_detail`: it has the differences of all
    quantities, else those of the page's player; `true`: the truth's motion, where it need not be computed.

    Raises errors of the machine, which are not results and are not stored: ImportError, MemoryError, OSError.
    """
    row = Run(case.label, name, route, setting, rung, outcome="", when=now())
    try:
        laws = other_laws(solver(name), case, route)
    except ImportError:
        raise
    except Exception as problem:
        return replace(row, outcome="crashed", reason=f"its MEANINGS fail: {reason_of_crash(problem)}")
    row, motion = attempt(row, case, truth.method if is_truth(row, truth) else "")
    if motion is None:
        return row
    return without_engines(_judgement, case, motion, row, truth, laws, is_hard, in_detail, true)


def _judgement(
    case: Case, motion: Trajectory, row: Run, truth: Truth, laws: tuple[str, ...], is_hard: bool, in_detail: bool,
    true: Trajectory | None,
) -> Run:  # fmt: skip
    run = judge(row, case, motion, true or true_motion(case, truth.method), truth, laws)
    if not is_hard:
        return run if in_detail else replace(run, off=_of_player(run.off))
    from ..judging.residuals import examine  # it imports SciPy's integrators, a quarter of a second

    return replace(run, off={}, residuals=examine(case, motion))


def attempt(row: Run, case: Case, truth_method: str = "") -> tuple[Run, Trajectory | None]:
    """The row of a run: unsupported, crashed, or without an outcome yet for a sound motion, with that motion.

    `truth_method`: the run is the truth's motion by that method. Raises errors of the machine: ImportError,
    MemoryError, OSError.
    """
    try:
        module = solver(row.solver)
        settle(row.solver)
        motion = true_motion(case, truth_method) if truth_method else run_on_clock(module, case, row.route, row.setting)
    except NotSupported as problem:
        row = replace(row, outcome="unsupported", reason=legible(problem), refusal=legible(refusal_kind(problem)))
        return row, None
    except (ImportError, MemoryError, OSError):
        raise
    except (Exception, SystemExit) as problem:
        return replace(row, outcome="crashed", reason=reason_of_crash(problem).removeprefix("EngineFailure: ")), None
    row = replace(row, status=legible(motion.status), cost=motion.cost)
    if validation.sound(motion):
        return row, motion
    return replace(row, outcome="crashed", reason=f"it gave {validation.UNSOUND}"), None


def motion_of(case: Case, name: str, route: str, setting: Setting) -> Trajectory:
    """The motion of one setting of one route, timed and not judged; raises all errors of the solver."""
    return run_on_clock(solver(name), case, route, setting)


def judge(
    row: Run, case: Case, trajectory: Trajectory, motion: Trajectory, truth: Truth, laws: tuple[str, ...] = (),
    same_samples: Callable[[], Trajectory | None] | None = None,
) -> Run:  # fmt: skip
    """The row of a sound trajectory compared with the truth: score, grade and its reason, ledger, distances. `laws`:
    the effects that the solver models by another law than the case's; the reason names them first. `same_samples`: the
    truth as it is read from samples like the trajectory's, None where it cannot be; without it, the doubt is that of
    the trajectory's own samples."""
    assert truth.scale is not None, "a case with a truth has a scale"
    has_forces = claims.forces_hold(case, trajectory)
    if not has_forces:
        trajectory, laws = claims.without_forces(trajectory), (*laws, "its forces do not make its motion")
    has_friction = is_defined(case, trajectory, truth.scale.losses)
    samples = distances.even_samples(trajectory) if has_friction else trajectory
    off = distances.differences(trajectory, motion, case)
    by = motion, truth.scales, truth.transitions
    judgement = several_contacts.judge(case, trajectory, *by, off)
    total, scale = judgement.score, judgement.scale
    if same_samples and total.off - total.doubt > total.pose:
        again = same_samples()
        if again is not None and not has_forces:
            again = claims.without_forces(again)
        true = None if again is None else several_contacts.judge(case, again, *by).scores
        total = total._replace(doubt=max(total.doubt, doubt_of_reading(judgement.scores, true)))
    if judgement.worst:
        laws = (*laws, f"worst at {judgement.worst}")
    friction = friction_factor(case, samples, scale.losses, scale.end)
    distance = distances.distance(off)
    begin, end = float(motion.t[0]), float(motion.t[-1])
    remarks = validation.gaps(trajectory, begin, None if truth.status == "lift_off" else end)
    remarks += validation.jumps(case, trajectory, motion, distance.centre_max) + validation.tips(trajectory, motion)
    impact, rows = case.effect(Impact), tuple[impacts.ImpactRow, ...]()
    if judgement.worst:
        rows = impacts.rows(case, trajectory, motion, judgement.ledger)
    elif impact is not None:
        own = impacts.rebounds(case, trajectory, judgement.transitions)
        rows = impacts.rebound_rows(own, impacts.rebounds(case, motion, truth.transitions))
        if not truth.friction_sensitivity >= LEAST:  # friction says nothing there
            change = float(off["energy_share"][-1]) if len(off["t"]) else 0.0
            remarks.insert(0, impacts.rebound_note(own, impact.restitution, change))
    return replace(
        row,
        outcome="answered",
        reason="; ".join(text for text in [*laws, grades.reason(total, scale, friction), *remarks] if text),
        first_mode=str(judgement.first_mode),
        ledger=judgement.ledger,
        spreads=judgement.spreads,
        score=total,
        friction_factor=friction,
        law=law_error(case, samples),
        grade=str(grades.grade(total.off, total.doubt)),
        sequence=grades.sequence_note(total, scale),
        impacts=rows,
        impulses=impacts.impulses(case, trajectory, motion, judgement.ledger) if impact else (),
        distance=distance,
        off={name: _thin(values) for name, values in off.items()},
    )


def _of_player(off: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    shown = (name for name in off if name in _PLAYER_OFF or " of " in name)
    return {name: _thin(off[name], _PLAYER_SAMPLES) for name in shown}


def _thin(values: np.ndarray, most: int = _SHOWN_SAMPLES) -> np.ndarray:
    if len(values) <= most:
        return values
    return values[np.linspace(0, len(values) - 1, most).round().astype(int)]


def reason_of_crash(problem: BaseException) -> str:
    """An engine's exception in one line. Raises OSError if the call's folder is gone or full: of that an engine may
    make an error of its own, and whoever made the call decides whose fault it is."""
    owned_folder.check_usable(Path.cwd())
    return sentence(problem)


def sentence(problem: BaseException) -> str:
    """An exception in one line."""
    try:
        text = legible(" ".join(str(problem).split()))
    except Exception:  # its text is the engine's own code, too
        text = "(its text cannot be read)"
    return f"{type(problem).__name__}: {text}" if text else type(problem).__name__
