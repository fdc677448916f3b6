"""One mode's equations as data, and the functions written from them.

All integrators use the same symbolic source: sizes, friction, loads and start are runtime parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import NamedTuple

from cases.derivation import derived
from cases.formulas.expression_code import ON_ARRAYS, ON_FLOATS, python_function
from cases.formulas.expression_graph import ARITHMETIC, ZERO, Node, in_order, node, symbol

from . import series
from .elimination import Elimination, T

# The force and the moment of a load.
LOAD_FORCES = 3

# The order of the series that decide first, and the number of operations up to which they are written as one function,
# which saves nine tenths of each call.
QUICK, SHORT = 2, 64
# That function is written after this number of expansions, which take as long as writing it (15 ms for a disc in a
# circle). A motion has one or two, so that a first one is not delayed.
EXPANSIONS = 50


class CheckLayout(NamedTuple):
    """How many of the checked quantities, the first, are arguments that are compared with 1 if they are smaller, and
    how many, the last, are forces."""

    of_order_one: int = 0
    forces: int = LOAD_FORCES


def checked_with_friction(
    frictions: Iterable[tuple[tuple[Node, ...], int, Node]], arguments: tuple[Node, ...], forces: tuple[Node, ...]
) -> tuple[tuple[Node, ...], CheckLayout]:
    """What is checked along each step: arguments of laws of friction and of loads, then friction forces and the loads'.
    `frictions`: for each slip `checked_arguments` of its law, and its friction force (N)."""
    some = [one for one in frictions if one[0]]
    first = [argument for every, of_order_one, _ in some for argument in every[:of_order_one]]
    others = [argument for every, of_order_one, _ in some for argument in every[of_order_one:]]
    forces = forces or (ZERO,) * LOAD_FORCES if some else forces
    checked = (*first, *others, *arguments, *(force for *_, force in some), *forces)
    return checked, CheckLayout(len(first), len(some) + len(forces))


@dataclass(frozen=True, eq=False)
class Equations:
    """One mode's equations, symbolic: y' = rates(t, y; parameters), outputs, and conditions that end the mode.

    The first `positions` variables are positions, the others velocities. `conditions` must hold for a decision for this
    mode, `condition_rates` are the rates of those that are velocities; `guards` are positive while the mode lasts: the
    conditions and the geometry's limits, without those that the state cannot change. `load_quantities` are checked
    along each step: arguments of functions in a load or in friction's law, then forces: friction by a formula, force
    and moment of the load (N, N m).
    """

    variables: tuple[Node, ...]
    positions: int
    rates: tuple[Node, ...]
    outputs: Elimination
    conditions: dict[str, Node] = field(default_factory=dict)
    condition_rates: dict[str, Node] = field(default_factory=dict)
    guards: dict[str, Node] = field(default_factory=dict)
    load_quantities: tuple[Node, ...] = ()
    check_layout: CheckLayout = CheckLayout()

    def with_slack(self, names: Sequence[str]) -> Equations:
        """The same with a slack (a parameter, m/s²) for guards that stay at zero, as their roundings are no events."""
        slack = {name: self.guards[name] + symbol(slack_name(name)) for name in names if name in self.guards}
        return replace(self, guards=self.guards | slack)

    @property
    def all(self) -> list[Node]:
        """All expressions."""
        named = (self.conditions, self.condition_rates, self.guards)
        return [*self.rates, *self.outputs, *(e for some in named for e in some.values()), *self.load_quantities]

    @property
    def parameters(self) -> tuple[Node, ...]:
        """The symbols that are neither time nor variables: sizes, friction, loads, signs."""
        symbols = frozenset[Node]().union(*(e.symbols for e in self.all))
        return tuple(sorted(symbols - {*self.variables, T}, key=lambda symbol: symbol.name))

    @property
    def constants(self) -> tuple[Node, ...]:
        """The largest parts that depend on parameters alone."""
        moving, constants = {*self.variables, T}, dict[Node, None]()
        for current in in_order(self.all):
            parts = current.args if current.symbols & moving else ()
            constants.update((part, None) for part in parts if isinstance(part, Node) and _is_constant(part, moving))
        constants.update((e, None) for e in self.all if _is_constant(e, moving))
        return tuple(constants)


def slack_name(guard: str) -> str:
    """The name of the parameter that is a guard's slack."""
    return f"slack of {guard}"


def _is_constant(value: Node, moving: set[Node]) -> bool:
    """Whether a node is an operation that only has to be computed once."""
    return value.op not in ("number", "symbol") and not value.symbols & moving


def _function(what: str, functions: Mapping[str, Callable]) -> derived[Callable[..., list]]:
    """A function of the values that the expressions of a system's attribute have."""

    def write(system: System) -> Callable[..., list]:
        expressions = getattr(system, what)
        outputs = list(expressions.values() if isinstance(expressions, Mapping) else expressions)
        return python_function([T, system.variables, system.parameters], outputs, functions, functions is ON_FLOATS)

    return derived(write)


class System:
    """One mode's equations and the functions written from them, each on first use.

    `parameters` are the symbols of `Equations.parameters`, followed by `constants`: the largest parts of the equations
    that depend on these alone. Functions take the values of all of them, so that constants are computed once.
    """

    record = Elimination  # the columns of the outputs

    # (t, y, parameters) -> list of values: on floats; on arrays of shape (n,), a constant value stays a number; on
    # `series.Series`, likewise. Forces are those of the contact per mass, normal and friction.
    rates_of_numbers = _function("rates", ON_FLOATS)
    rates_of_arrays = _function("rates", ON_ARRAYS)
    rates_of_series = _function("rates", series.FUNCTIONS)
    guards_of_numbers = _function("guards", ON_FLOATS)
    guards_of_arrays = _function("guards", ON_ARRAYS)
    conditions_of_numbers = _function("conditions", ON_FLOATS)
    conditions_of_arrays = _function("conditions", ON_ARRAYS)
    conditions_of_series = _function("conditions", series.FUNCTIONS)
    condition_rates_of_arrays = _function("condition_rates", ON_ARRAYS)
    condition_rates_of_numbers = _function("condition_rates", ON_FLOATS)
    outputs_of_arrays = _function("outputs", ON_ARRAYS)
    outputs_of_numbers = _function("outputs", ON_FLOATS)
    forces_of_numbers = _function("forces", ON_FLOATS)
    forces_and_guards_of_numbers = _function("forces_and_guards", ON_FLOATS)
    load_quantities_of_arrays = _function("load_quantities", ON_ARRAYS)

    def __init__(self, equations: Equations):
        self.variables, self.positions = equations.variables, equations.positions
        self.rates, self.outputs = equations.rates, equations.outputs
        self.conditions, self.condition_rates = equations.conditions, equations.condition_rates
        self.guards, self.load_quantities = equations.guards, equations.load_quantities
        self.check_layout = equations.check_layout
        self._expansions = 0
        self.forces = (self.outputs.normal, self.outputs.friction)
        self.forces_and_guards = (*self.forces, *self.guards.values())
        # The places among the conditions of those that have rates.
        self.rated = tuple(i for i, name in enumerate(self.conditions) if name in self.condition_rates)
        self.names = tuple(symbol.name for symbol in equations.parameters)
        self.constants = equations.constants
        self.parameters = (*equations.parameters, *self.constants)

    @derived
    def constants_of_arrays(self):
        """(parameters,) -> list of the values of `constants`, on floats or arrays of shape (n,)."""
        return python_function([self.parameters[: len(self.names)]], self.constants, ON_ARRAYS)

    @derived
    def constants_of_numbers(self):
        """The same on floats, NaN where one has no value; None if there are functions, which NumPy rounds otherwise."""
        if any(n.op not in (*ARITHMETIC, "number", "symbol") for n in in_order(self.constants)):
            return None
        return python_function([self.parameters[: len(self.names)]], self.constants, ON_FLOATS, or_nan=True)

    def expand(self, t, y: Sequence, bounds: Sequence, parameters: Sequence, order: int):
        """The motion from (t, y) and its conditions as series in time of that order, a constant condition as a number.

        `bounds` are those of the errors of `y`. Numbers may be floats, or symbols that compute as floats do.
        """

        def rates(time, state):
            return self.rates_of_series(time + t, state, parameters)

        state = series.along(rates, y, bounds, order)
        time = series.Series([t, 1.0, *([0.0] * order)][: order + 1], [0.0] * (order + 1))
        return state, self.conditions_of_series(time, state, parameters)

    @derived
    def _quick_series(self):
        """The layout of the conditions' series of order QUICK, and the function that computes all their numbers by the
        operations of `expand`; None for long equations."""
        if len(in_order((*self.rates, *self.conditions.values()), {*self.constants})) > SHORT:
            return None
        bounds = [symbol(f"error of {variable.name}") for variable in self.variables]
        values = self.expand(T, self.variables, bounds, self.parameters, QUICK)[1]
        are_series = [isinstance(value, series.Series) for value in values]
        numbers = [
            number
            for value in values
            for number in ((*value.c, *value.e) if isinstance(value, series.Series) else (value,))
        ]
        return are_series, python_function([T, self.variables, bounds, self.parameters], map(node, numbers), ON_FLOATS)

    def condition_series(self, t, y, bounds, parameters, order: int) -> list[series.Series | float]:
        """The conditions of `expand`, after some times by a function written for this order if there is one, whose
        numbers are the same to the last bit."""
        self._expansions += 1
        quick = self._quick_series if order == QUICK and self._expansions > EXPANSIONS else None
        if quick is None:
            return self.expand(t, y, bounds, parameters, order)[1]
        are_series, function = quick
        numbers, terms = iter(function(t, y, bounds, parameters)), order + 1
        return [
            series.Series(list(islice(numbers, terms)), list(islice(numbers, terms))) if is_series else next(numbers)
            for is_series in are_series
        ]

    @derived
    def _approach_of_series(self):
        """(t, y, parameters) -> [free approach] on `series.Series`, and the places of the named parameters that are
        exponents; constants are computed from named parameters that are series, too."""
        inner = in_order([self.outputs.free_approach])
        exponents = {n.args[1] for n in inner if n.op == "**"}
        names = self.parameters[: len(self.names)]
        function = python_function([T, self.variables, names], [self.outputs.free_approach], series.FUNCTIONS)
        return function, [name in exponents for name in names]

    def approach_error(self, t: float, y: Sequence[float], parameters: Sequence[float]) -> float:
        """The error of the outputs' `free_approach`, in units of the rounding that time, state, parameters and every
        operation have (`reference.scales`). Raises ArithmeticError or ValueError if it has no finite value."""
        function, are_exponents = self._approach_of_series

        def with_rounding(value: float) -> series.Series:
            return series.Series([value], [series.EPS * abs(value)])

        names = parameters[: len(self.names)]
        sizes = [v if is_exponent else with_rounding(v) for v, is_exponent in zip(names, are_exponents, strict=True)]
        (value,) = function(with_rounding(t), [*map(with_rounding, y)], sizes)
        return value.e[0] / series.EPS if isinstance(value, series.Series) else abs(value)
