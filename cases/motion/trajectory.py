"""The form of the answers of all solvers. SI units; components along the track as in `cases.contact`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, replace
from enum import StrEnum
from functools import partial
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from ..errors import BadValue, choice, numbers, unknown_name, whole
from ..files.user_files import place
from ..scene.contact_names import CONTACT, FIRST

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from ..pictures.animation import Animation
    from ..pictures.plots import Picture
    from ..scene.case_class import Case

# Number of evenly spaced times at which a motion with dense output is drawn and written.
EVEN_TIMES = 1001
# Most times of a picture or a table: a table of ten million rows takes a gigabyte.
MOST_TIMES = 10_000_000
# A contact that never slips faster than this part of the fastest speed sticks: what roundings of velocities leave.
_NO_SLIP = 1e-9
# Times of a transition and of its impact differ by less than this part of the motion's duration, by roundings.
_SAME_TIME = 1e-12


class Mode(StrEnum):
    """The state of the contact."""

    SLIDE = "slide"  # without friction
    SLIP_FORWARD = "slip_forward"  # the plate's point moves along the track's increasing parameter
    SLIP_BACKWARD = "slip_backward"
    ROLL = "roll"
    REST = "rest"  # neither slips nor turns: held by friction and rolling resistance, or by an infinite inertia
    FLIGHT = "flight"

    @classmethod
    def _missing_(cls, value: object) -> None:
        raise unknown_name("mode", str(value), cls)


@dataclass(frozen=True)
class Transition:
    """One change of mode: time (s), modes before and after, contact parameters, and the cause (one phrase); in a motion
    with several contacts also the contact's name, "" otherwise.

    An impact after which the plate flies is a change from flight to flight. It is listed if it closes with at least
    7e-4 of the greatest closing speed since the plate last lay on its track, whatever its rebound is. Slower ones
    belong to bouncing that comes to rest, whose end is the change from flight to contact. Where such bouncing is
    repeated ever faster (off a wall, at rest on the floor, off the wall again), the same holds for its first impacts.
    At one instant each of several contacts has one change, from its mode before to its mode after, in the order of
    their names.
    """

    time: float
    before: Mode
    after: Mode
    xi1: float = np.nan
    xi2: float = np.nan
    cause: str = ""
    contact: str = ""

    def __repr__(self) -> str:
        which = self.contact and f" {self.contact}"
        return f"Transition({self.time:.9g} s:{which} {self.before} -> {self.after}{self.cause and f', {self.cause}'})"


@dataclass(frozen=True)
class Passage:
    """The contact passes from one element of a chain to the next: time (s), "track" or "outline", the elements
    ("piece 0", "corner 1", numbered as in `Chain.elements` and on from round to round), and the contact parameters.

    The mode, if it changes at the same time, has a transition of its own.
    """

    time: float
    curve: str
    before: str
    after: str
    xi1: float
    xi2: float

    def __repr__(self) -> str:
        return f"Passage({self.time:.9g} s: {self.curve}, {self.before} -> {self.after})"


class ContactImpulse(NamedTuple):
    """What one contact does in an impact at a `time` (s): the impulses along its normal and tangent, N s, and their
    work, J (negative: lost energy). An impulse that the velocities do not determine, as of a box that lands on both
    corners with friction, is NaN."""

    time: float
    contact: str
    normal: float
    friction: float
    work: float

    def in_words(self) -> str:
        """For example "normal 4.698 N s, friction -0.3333 N s, work -3.845 J"."""
        units = (("normal", self.normal, "N s"), ("friction", self.friction, "N s"), ("work", self.work, "J"))
        return ", ".join(f"{name} {'not unique' if isnan(x) else f'{x:.4g} {unit}'}" for name, x, unit in units)


_NO_IMPULSE = ContactImpulse(np.nan, "", np.nan, np.nan, np.nan)


@dataclass(frozen=True)
class Cost:
    """The cost of an answer: CPU and wall seconds of the run, of the set-up separately; steps and evaluations."""

    cpu_s: float = np.nan
    wall_s: float = np.nan
    setup_s: float = np.nan
    steps: int = 0
    evaluations: int = 0


class State(NamedTuple):
    """The state at one instant (numbers), or at many (arrays of one length)."""

    x: np.ndarray | float
    y: np.ndarray | float
    theta: np.ndarray | float
    vx: np.ndarray | float
    vy: np.ndarray | float
    omega: np.ndarray | float
    slip: np.ndarray | float
    normal_force: np.ndarray | float
    friction_force: np.ndarray | float
    xi1: np.ndarray | float
    xi2: np.ndarray | float

    def __repr__(self) -> str:
        if np.ndim(self.x):
            return f"State({len(np.atleast_1d(self.x))} instants of {', '.join(self._fields)})"
        return f"State({', '.join(f'{name}={value:.6g}' for name, value in self._asdict().items())})"


class ContactColumns(NamedTuple):
    """One contact at n instants, arrays (n,): gap (m), slip velocity (m/s), normal and friction force (N), contact
    parameters, and the ranges of both forces, (2, n).

    A force that Coulomb's law leaves open is NaN, and its range has its least and greatest value (infinite where
    contacts may press against each other without bound). While a contact is open its forces are 0 and its slip is NaN;
    gap and parameters are NaN where it is far from its track.
    """

    gap: np.ndarray
    slip: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    normal_range: np.ndarray
    friction_range: np.ndarray


# The columns of a trajectory.
_SAMPLES = ("t", *State._fields)


class _OneContact:
    """The dense output of a motion with the slip, forces and parameters of one contact."""

    def __init__(self, dense: Callable, columns: Callable, contact: str):
        self.dense, self.columns, self.contact = dense, columns, contact

    def __call__(self, times: np.ndarray) -> State:
        now = self.columns(self.contact, times)
        return self.dense(times)._replace(
            slip=now.slip, normal_force=now.normal_force, friction_force=now.friction_force, xi1=now.xi1, xi2=now.xi2
        )


def _of_contact(motion: Trajectory, one: Trajectory) -> tuple[ContactImpulse, ...]:
    """Of the impacts of a motion with several contacts those of `one` of them."""
    return tuple(impulse for impulse in motion.impacts if impulse.contact in one.contact_names)


def _read_only(values: np.ndarray) -> np.ndarray:
    """The values as an array that cannot be written; itself if it is one."""
    if isinstance(values, np.ndarray) and not values.flags.writeable:
        return values
    view = np.asarray(values).view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """A motion, sampled at times `t` (increasing; two equal times mark both sides of a jump), read-only arrays of one
    length.

    `x`, `y`, `theta`: pose of the centre of mass; `vx`, `vy`, `omega`: its velocities; `slip`: slip velocity along the
    track's tangent; `normal_force`, `friction_force`: along its left normal and tangent, NaN where a solver does not
    report them; `xi1`, `xi2`: contact parameters. In flight there is no contact: both forces are 0, and slip and
    contact parameters NaN. `status` is "completed" or names the reason why the motion ended early; `reason` is a
    sentence about it. `slip_resolution` (m/s) is the creep below which this solver cannot distinguish stick from slip
    (0: exact). `passages` of the contact between pieces and corners of a chain are empty on smooth curves. `dense` maps
    a time or an array of times inside the range to a State; without it the samples are interpolated. `case`, if known,
    is the case of the motion: `plot` and `animate` draw it. `impulses` maps the motion to its `impacts`.

    In a motion with several contacts `contact_names` lists them, `contacts` has the columns of each, and `of` gives the
    motion of one; slip, forces and parameters of the trajectory itself are those of the first closed contact. In a
    motion of several plates `plate_names` lists them, and `plate` gives the motion of one; the trajectory itself is
    that of the case's first plate.
    """

    t: np.ndarray
    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    omega: np.ndarray
    slip: np.ndarray
    normal_force: np.ndarray
    friction_force: np.ndarray
    xi1: np.ndarray
    xi2: np.ndarray
    transitions: tuple[Transition, ...] = ()
    status: str = "completed"
    reason: str = "The motion ran to its end."
    cost: Cost = Cost()
    slip_resolution: float = 0.0
    first_mode: Mode | None = None
    dense: Callable[[np.ndarray], State] | None = None
    case: Case | None = None
    passages: tuple[Passage, ...] = ()
    contact_names: tuple[str, ...] = (CONTACT,)
    contact_columns: Callable[[str, np.ndarray | None], ContactColumns] | None = None
    plate_names: tuple[str, ...] = (FIRST,)
    plate_columns: Callable[[str, np.ndarray | None], State] | None = None
    impulses: Callable[[Trajectory], tuple[ContactImpulse, ...]] | None = None

    def plate(self, name: str) -> Trajectory:
        """The motion of one plate of several: its pose and velocities. Slip, forces and parameters are NaN: `contacts`
        has them. Raises UnknownName for a plate that the motion does not have.
        """
        choice("plate of the motion", name, self.plate_names)
        if self.plate_columns is None:
            return self
        dense = self.dense and partial(self.plate_columns, name)
        return replace(
            self, **self.plate_columns(name, None)._asdict(), transitions=(), first_mode=None, dense=dense,
            contact_names=(), contact_columns=None, plate_names=(name,), plate_columns=None, impulses=None,
        )  # fmt: skip

    @property
    def contacts(self) -> dict[str, ContactColumns]:
        """The columns of each contact at the times of the samples, by name."""
        return {name: self._columns(name, None) for name in self.contact_names}

    def of(self, contact: str) -> Trajectory:
        """The motion of one contact: the same plate, with this contact's slip, forces, parameters and transitions.

        Raises UnknownName for a contact that the motion does not have.
        """
        choice("contact of the motion", contact, self.contact_names)
        if self.contact_columns is None:
            return self
        columns = self.contact_columns
        now = columns(contact, None)
        transitions = tuple(t for t in self.transitions if t.contact == contact)
        return replace(
            self, slip=now.slip, normal_force=now.normal_force, friction_force=now.friction_force, xi1=now.xi1,
            xi2=now.xi2, transitions=transitions, first_mode=self._first_mode_of(contact, transitions, now.slip),
            dense=self.dense and _OneContact(self.dense, columns, contact),
            contact_names=(contact,), contact_columns=None, impulses=self.impulses and partial(_of_contact, self),
        )  # fmt: skip

    @property
    def impacts(self) -> tuple[ContactImpulse, ...]:
        """The impulses and the work of each contact in every impact, in the order of their times.

        Raises BadValue for a motion whose solver does not give them: the reference does."""
        if self.impulses is None:
            raise BadValue("this motion has no impulses; one of reference.simulate has, but for those of its plates")
        if "_impacts" not in vars(self):
            vars(self)["_impacts"] = self.impulses(self)
        return vars(self)["_impacts"]

    def impulse_at(self, change: Transition) -> ContactImpulse | None:
        """The impulses of the impact at a transition; None for one without, and if the solver does not give them."""
        near = _SAME_TIME * float(self.t[-1])
        return next(
            (
                one
                for one in (self.impacts if self.impulses else ())
                if abs(one.time - change.time) <= near and change.contact in ("", one.contact)
            ),
            None,
        )

    def _first_mode_of(self, contact: str, transitions: tuple[Transition, ...], slip: np.ndarray) -> Mode | None:
        """The first mode of one contact: what its first transition leaves, or the mode that it has all the time."""
        if self.first_mode is None:
            return None
        if transitions:
            return transitions[0].before
        if np.isnan(slip[0]):
            return Mode.FLIGHT
        if self._slides(contact):
            return Mode.SLIDE
        largest = slip[np.nanargmax(np.abs(slip))]
        if abs(largest) > _NO_SLIP * np.hypot(self.vx, self.vy).max():
            return Mode.SLIP_FORWARD if largest > 0.0 else Mode.SLIP_BACKWARD
        return self.first_mode if self.first_mode in (Mode.ROLL, Mode.REST) else Mode.ROLL

    def _slides(self, contact: str) -> bool:
        """Whether a contact has no friction; of a motion whose case is not known, as its first contact."""
        from ..effects import CoulombFriction, PerfectlyRough, one
        from ..scene.supports import effects_at

        if self.case is None:
            return self.first_mode is Mode.SLIDE
        effects = effects_at(self.case, contact)
        return one(effects, CoulombFriction) is None and one(effects, PerfectlyRough) is None

    def _columns(self, contact: str, times: np.ndarray | None) -> ContactColumns:
        if self.contact_columns is not None:
            return self.contact_columns(contact, times)
        ranges = (np.array([values, values]) for values in (self.normal_force, self.friction_force))
        gap = np.where(np.isnan(self.slip), np.nan, 0.0)
        return ContactColumns(gap, self.slip, self.normal_force, self.friction_force, self.xi1, self.xi2, *ranges)

    @classmethod
    def on_demand(cls, sample: Callable[[], tuple[np.ndarray, State]], **rest) -> Trajectory:
        """A trajectory whose samples, times and State, are computed on first access; `rest`: all other fields.

        Access to its transitions alone computes no samples.
        """
        motion = object.__new__(cls)
        vars(motion).update(_DEFAULTS | rest, _sample=sample)
        return motion

    if not TYPE_CHECKING:  # type checkers use the declared fields

        def __getattr__(self, name):
            # Called only for missing attributes: samples on demand, or an error.
            attributes = vars(self)
            sample = attributes.get("_sample") if name in _SAMPLES else None
            if sample is not None:
                times, state = sample()
                for column, values in {"t": times, **state._asdict()}.items():
                    attributes.setdefault(column, _read_only(values))  # another thread may have made the same
                self.__post_init__()
                attributes.pop("_sample", None)
            if name not in attributes:
                raise AttributeError(f"a {type(self).__name__} has no {name!r}", name=name, obj=self)
            return attributes[name]

    def __getstate__(self) -> dict[str, Any]:
        """A trajectory is pickled with its samples, and with its dense output if that can be pickled."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._protect()

    def _protect(self) -> None:
        """Make the samples read-only: a motion that is changed is another motion, with `dataclasses.replace`."""
        for name in _SAMPLES:
            vars(self)[name] = _read_only(getattr(self, name))

    def __post_init__(self):
        for name in _SAMPLES:
            vars(self)[name] = numbers(name, getattr(self, name))
            if np.ndim(self.t) != 1 or getattr(self, name).shape != self.t.shape:
                shape = getattr(self, name).shape
                raise BadValue(f"{name} has shape {shape} and t {self.t.shape}; give arrays (n,) of one length")
        self._protect()

    def __call__(self, t) -> State:
        """The state at a time, or at each of an array (n,) of times; raises BadValue outside the motion's span and for
        values that are no times."""
        times = numbers("time", t)
        if times.ndim > 1:
            raise BadValue(f"the times have shape {times.shape}; give a number, or an array of shape (n,)")
        if times.size and not (self.t[0] <= times.min() and times.max() <= self.t[-1]):
            raise BadValue(f"time {t} is outside the motion, which lasts from {self.t[0]:g} s to {self.t[-1]:g} s")
        state = (self.dense or self._interpolate)(np.atleast_1d(times))
        return State(*(float(np.asarray(v)[0]) for v in state)) if times.ndim == 0 else state

    def _interpolate(self, times: np.ndarray) -> State:
        """Pose by cubic Hermite interpolation with the velocities, everything else linearly."""
        from scipy.interpolate import CubicHermiteSpline

        keep = np.concatenate([np.diff(self.t) > 0, [True]])
        values = {name: np.interp(times, self.t[keep], getattr(self, name)[keep]) for name in State._fields}
        for name, rate in (("x", "vx"), ("y", "vy"), ("theta", "omega")):
            if keep.sum() > 1:
                spline = CubicHermiteSpline(self.t[keep], getattr(self, name)[keep], getattr(self, rate)[keep])
                values[name] = spline(times)
        return State(**values)

    # --- for reading ------------------------------------------------------------------------------------------------

    def __repr__(self) -> str:
        count = len(self.transitions)
        changes = "" if self.first_mode is None else f"; {count} transition{'' if count == 1 else 's'}"
        return f"<Trajectory{self.case and f' of {self.case.label}' or ''}: {self.in_words()}{changes}>"

    def _repr_html_(self) -> str:
        from ..pictures import notebook_html

        return notebook_html.of_motion(self)

    def in_words(self) -> str:
        """What each contact does, one mode after the other with its duration, and how the motion ends: "slides forward
        for 0.34 s, then rolls to the end of 1 s". For a motion with unknown modes, the number of samples."""
        from .motion_words import in_words

        return in_words(self)

    def times(self, count: int | None = None) -> np.ndarray:
        """Increasing times, s, for pictures and tables: `count` evenly spaced ones.

        Without a count: for a motion with dense output as many as a picture needs, including its transitions, else the
        times of the samples.
        """
        if count is not None:
            return np.linspace(self.t[0], self.t[-1], whole("count of times", count, 1, MOST_TIMES))
        if self.dense is None:
            return np.unique(self.t)
        inside = [t.time for t in self.transitions if self.t[0] <= t.time <= self.t[-1]]
        return np.union1d(np.linspace(self.t[0], self.t[-1], EVEN_TIMES), inside)

    def to_frame(self, count: int | None = None) -> pd.DataFrame:
        """The motion at `times(count)` as a table: t and the columns of State, in SI units."""
        import pandas as pd

        times = self.times(count)
        return pd.DataFrame({"t": times, **self(times)._asdict()})

    def transition_frame(self) -> pd.DataFrame:
        """The transitions as a table: the fields of each Transition, and normal and friction impulse (N s) and work (J)
        of its contact where it is an impact, else NaN."""
        import pandas as pd

        head = [f.name for f in fields(Transition)]
        rows = [
            [*(getattr(change, name) for name in head), *((self.impulse_at(change) or _NO_IMPULSE)[2:])]
            for change in self.transitions
        ]
        return pd.DataFrame(rows, columns=[*head, "normal_impulse", "friction_impulse", "work"])

    def to_csv(self, path: str | Path, count: int | None = None) -> Path:
        """Write that table with all digits, and an empty cell for a missing value (slip in flight); returns the path.

        `slip-to-roll compare` and `--trajectory` read such files."""
        from ..files.owned_folder import atomic_path  # of files alone

        file = place("file", path)
        with atomic_path(file) as partial:
            self.to_frame(count).to_csv(partial, index=False)
        return file

    @overload
    def plot(self, *quantities: str, colour: str | None = None, ax: None = None) -> Picture: ...
    @overload
    def plot(self, *quantities: str, colour: str | None = None, ax: Axes) -> Axes: ...

    def plot(self, *quantities: str, colour: str | None = None, ax: Axes | None = None) -> Picture | Axes:
        """A Picture of the scene, if the case is known, and of quantities against time; with `ax`, an Axes of
        Matplotlib, one quantity (by default the slip velocity) is drawn there, and `ax` is returned.

        They are columns of State, by default slip velocity, normal force, x and y. The picture shows itself in a
        notebook; its `savefig` writes SVG, PDF or PNG.

        Raises UnknownName for an unknown quantity, BadValue for several with `ax`.
        """
        from ..pictures.plots import PLATE, plot

        # A picture of the scene has one place of the track.
        scene = self.case.scene if self.case and not self._is_driven else None
        usual = ("slip", "normal_force", "x", "y") if ax is None else ("slip",)
        return plot(self, scene, quantities or usual, PLATE if colour is None else colour, ax)

    def animate(self, factor: float | None = None, quantity: str = "slip") -> Animation:
        """The motion as a film, which shows itself in a notebook and whose `save` writes GIF or MP4.

        `factor`: seconds of the motion in a second of film (None: a round number for a film of a few seconds);
        `quantity`: the column of State drawn next to it. Forces and mode are those of the first contact. Raises
        BadValue if the case is not known, or its track moves.
        """
        from ..pictures.animation import Animation

        if self.case is None:
            raise BadValue("the motion has no case; give it one: dataclasses.replace(…, case=case)")
        if self._is_driven:
            raise BadValue(
                "a film has one place of the track; give cases.moving_frame.in_track_frame(motion).animate()"
            )
        return Animation(self, self.case.scene, self.case.weight, factor, quantity)

    @property
    def _is_driven(self) -> bool:
        """Whether the motion's track moves."""
        from ..moving_surface import Drive

        return self.case is not None and self.case.effect(Drive) is not None


# Of the fields that have any.
_DEFAULTS = {f.name: f.default for f in fields(Trajectory) if f.default is not MISSING}
