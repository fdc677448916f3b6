"""Decisions of the first formulation in a state, and the accelerations that follow."""

from collections.abc import Sequence

import numpy as np

from cases import Case, Mode
from reference.solver.accelerations import DecisionInstant
from reference.solver.decide import Decision, GroupModes, decide, phase_of, variables
from reference.solver.places import ContactPlace, place, project
from reference.solver.touching import touching_contacts


def decision_in(
    case: Case, body: Sequence[float], speed: float
) -> tuple[DecisionInstant, list[ContactPlace], Decision]:
    """The decision about the contacts that touch in the state (x, y, θ, vx, vy, ω) of one plate; `speed`: the largest
    of its motion so far, m/s."""
    state, touching = project(case, body, list(touching_contacts(case, np.array(body))))
    now, contacts = (
        DecisionInstant(case, 0.0, state, speed, 1e-12),
        [place(at.pair, state, (at.xi1, at.xi2)) for at in touching],
    )
    return now, contacts, decide(now, contacts, {})


def outputs_in(
    now: DecisionInstant, contacts: Sequence[ContactPlace], some: GroupModes
) -> tuple[np.ndarray, list, Sequence]:
    """Accelerations (3,), rates of all variables, and outputs of the equations in some modes."""
    phase, y = phase_of(now.case, contacts, some), variables(now.state, contacts)
    rates = phase.system.rates_of_numbers(0.0, y, phase.parameters)
    return np.array(rates[-3:]), rates, phase.system.outputs_of_numbers(0.0, y, phase.parameters)


def accelerations_of(now: DecisionInstant, contacts: Sequence[ContactPlace], decision: Decision) -> list[np.ndarray]:
    """The accelerations (3,) of each consistent motion; none of a plate that three rows or more hold."""
    result = list[np.ndarray]()
    for modes in decision.motions:
        rows = sum(2 if mode is Mode.ROLL else mode is not Mode.FLIGHT for mode in modes)
        turns = decision.turns if decision.modes == modes else ()
        is_held = decision.rests or rows > 2
        result.append(np.zeros(3) if is_held else outputs_in(now, contacts, GroupModes(modes, turns))[0])
    return result
