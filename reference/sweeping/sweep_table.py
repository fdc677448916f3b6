"""The table of a sweep: a DataFrame of pandas that draws its map and becomes a grid of xarray."""

from __future__ import annotations

from typing import Any

import pandas as pd

from cases import BadValue
from cases.errors import choice

# The kinds of motion with a colour of their own; the rarer ones are drawn as one.
MOST_KINDS = 8


class SweepTable(pd.DataFrame):
    """A row per scenario; `parameters` are the names of the columns that were varied."""

    _metadata = ["parameters"]  # noqa: RUF012  (pandas' way to keep an attribute)
    parameters: tuple[str, ...] = ()

    @property
    def _constructor(self) -> type[SweepTable]:
        return SweepTable

    def to_xarray(self) -> Any:  # type: ignore[misc]  # final in the stubs of pandas
        """The numbers and words of each scenario on the grid of its parameters, an xarray.Dataset (needs xarray).
        Raises BadValue for a sweep that is no grid."""
        lists = [name for name in self if self[name].map(lambda one: isinstance(one, list)).any()]
        plain = pd.DataFrame(self.drop(columns=[*lists, "scenario"], errors="ignore"))
        if plain.duplicated(list(self.parameters)).any():
            raise BadValue('the rows have no grid of parameters; give sample="grid"')
        return plain.set_index(list(self.parameters)).to_xarray()

    def plot_map(self, column: str = "sequence", ax: Any = None) -> Any:
        """A map of a column over two parameters that were varied: colours of a number, or of the kinds of a word such
        as "sequence" or "outcome". Returns a Picture, or `ax`, an Axes of Matplotlib, if it is given.

        Raises BadValue unless two parameters form a grid, UnknownName for a column that there is not."""
        from cases.pictures.style import Picture, apply_style

        if len(self.parameters) != 2 or self.duplicated(list(self.parameters)).any():
            raise BadValue(f"a map has a grid of two parameters, and this sweep varies {', '.join(self.parameters)}")
        choice("column of a sweep", column, list(self.columns))
        if ax is not None:
            return self._draw(ax, column)
        with apply_style():
            picture = Picture(figsize=(6.4, 4.2), layout="constrained")
            self._draw(picture.subplots(), column)
        return picture

    def _draw(self, ax: Any, column: str) -> Any:
        from matplotlib.patches import Patch

        x, y = self.parameters
        numbers, kinds = self[column], list[str]()
        if not pd.api.types.is_numeric_dtype(numbers):
            words = numbers.astype(str)
            kinds = words.value_counts().index[:MOST_KINDS].tolist()
            numbers = words.map({kind: i for i, kind in enumerate(kinds)})
        grid = pd.DataFrame(self[[x, y]]).assign(number=numbers).pivot(index=y, columns=x, values="number")
        how = dict(cmap="tab10", vmin=-0.5, vmax=9.5, alpha=0.6) if kinds else dict(cmap="viridis")
        image = ax.pcolormesh(grid.columns, grid.index, grid.to_numpy(dtype=float), shading="nearest", **how)
        if kinds:
            handles = [Patch(color=image.cmap(image.norm(i)), alpha=0.6, label=kind) for i, kind in enumerate(kinds)]
            ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0))
        else:
            ax.figure.colorbar(image, ax=ax, label=column)
        ax.set(xlabel=x, ylabel=y)
        return ax
