"""The table of a campaign."""

from __future__ import annotations

import collections.abc
import csv
import math
import pathlib
import warnings
from typing import Any, Iterator, Mapping

from tenon.data import PathLike, Share, column, quantiles, read_json, wilson
from tenon.errors import DataError, UnknownName


class Campaign(collections.abc.Mapping):
    """The runs of a campaign, or some of them, by column.

    `campaign["com_error_max_m"]` has one value for each run, in the order of the runs: an array of NumPy, or an
    `array.array` or a list without NumPy. A number is NaN if the run has no such figure, and a missing text is None.
    """

    def __init__(self, directory: PathLike, exit_code: int | None = None) -> None:
        """Reads the files, also of a campaign that has not ended. Raises DataError if one is missing or damaged."""
        self.directory = pathlib.Path(directory)
        self.exit_code = exit_code  #: 0, 130 or 143 (stopped); None if only read
        self._columns, self._not_computed = _read_table(self.directory / "runs.csv")
        summary = self.directory / "summary.json"
        self.figures: dict[str, Any] = read_json(summary) if summary.exists() else {}  #: empty before the end

    @property
    def axes(self) -> dict[str, list[Any]]:
        """The values of each grid, list or choice; empty before the campaign ends."""
        points = self.figures.get("points") or [{"at": {}}]
        return {name: list(self.group_by(name)) for name in points[0]["at"]}

    def __getitem__(self, name: str) -> Any:
        return column(self._values(name))

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    # A Mapping compares its values, but arrays have no single ==, and hashing needs identity.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __repr__(self) -> str:
        return f"<Campaign '{self.directory}': {len(self._columns['run'])} runs>"

    def where(self, values: Mapping[str, Any]) -> Campaign:
        """Returns the runs with these values, such as {"walk.friction": 0.5, "finished": True}. Raises UnknownName."""
        wanted = {name: (self._values(name), value) for name, value in values.items()}
        return self._part([i for i in range(len(self._columns["run"])) if all(v[i] == w for v, w in wanted.values())])

    def group_by(self, *names: str) -> dict[Any, Campaign]:
        """Returns the runs for each value of a column, or for each tuple of values of several columns.

        The groups have the order of the runs. Missing values form the group None. Raises UnknownName.
        """
        groups: dict[Any, list[int]] = {}
        for i, values in enumerate(zip(*(self._values(name) for name in names))):
            key = tuple(None if value != value else value for value in values)  # NaN is not equal to itself
            groups.setdefault(key if len(names) > 1 else key[0], []).append(i)
        return {key: self._part(places) for key, places in groups.items()}

    def quantiles(self, name: str, probabilities: tuple[float, ...] = (0.1, 0.5, 0.9)) -> list[float]:
        """Returns quantiles of a column of numbers. Runs without this number do not count; NaN if no run has it.

        Warns if the computation of a number gave NaN, which is an error. Raises UnknownName, and ValueError if the
        column is not numbers or a probability is not from 0 to 1.
        """
        numbers = self.numbers(name)
        errors = len(self._not_computed.get(name, set()).intersection(self._columns["run"]))
        if errors:
            warnings.warn(f"{errors} of {len(numbers)} runs do not count, because the computation of '{name}' gave NaN",
                          RuntimeWarning, stacklevel=2)
        return quantiles(numbers, probabilities)

    def share(self, name: str = "finished") -> Share:
        """Returns the share of runs for which a column is true, by default of those that survived.

        The confidence of the interval is that of the campaign, 0.95 unless its file changes it. Runs without this value
        do not count. Raises UnknownName, and ValueError if the column is not true or false.
        """
        values = [value for value in self._values(name) if value is not None]
        if not all(isinstance(value, bool) for value in values):
            raise ValueError(f"'{name}' in {self.directory / 'runs.csv'} is not true or false; choose another column")
        return wilson(sum(values), len(values), self.figures.get("confidence", 0.95))

    def numbers(self, name: str) -> list[float]:
        """Returns a column of numbers as a list. Raises UnknownName, and ValueError if the column is not numbers."""
        values = self._values(name)
        if any(value is None or isinstance(value, (str, bool)) for value in values):
            raise ValueError(f"'{name}' in {self.directory / 'runs.csv'} is not a number; choose another column")
        return values

    def to_pandas(self) -> Any:
        """Returns a DataFrame with the index `run`. Needs pandas."""
        import pandas
        return pandas.DataFrame({name: self[name] for name in self}).set_index("run")

    def plot(self, x: str, y: str, by: str | None = None, axes: Any = None, save: PathLike | None = None) -> Any:
        """Draws column y over column x, with one colour for each value of column `by`. Needs matplotlib.

        If x is an axis of the campaign, the plot shows the median and the band from the 10 % to the 90 % quantile of y,
        or, if y is true or false, the share of runs and its interval. Otherwise each run is a dot, or a cross if it did
        not survive. `axes` are Axes of matplotlib to draw into; `save` is a file such as error.pdf or error.svg.
        Returns the Figure. Raises UnknownName, ImportError, and ValueError if a column is not numbers.
        """
        from tenon.plots import plot_campaign
        return plot_campaign(self, x, y, by, axes, save)

    def _values(self, name: str) -> list[Any]:
        if name not in self._columns:
            raise UnknownName("column", name, self.directory / "runs.csv", self._columns)
        return self._columns[name]

    def _part(self, places: list[int]) -> Campaign:
        part = Campaign.__new__(Campaign)
        part.directory, part.exit_code, part.figures = self.directory, self.exit_code, self.figures
        part._not_computed = self._not_computed
        part._columns = {name: [values[i] for i in places] for name, values in self._columns.items()}
        return part


def _read_table(path: pathlib.Path) -> tuple[dict[str, list[Any]], dict[str, set[int]]]:
    """Returns the columns, and for each column the runs in which the computation of the number gave NaN."""
    rows: dict[int, list[str]] = {}
    number = 1
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            # The last line is incomplete if the program was killed while it wrote.
            lines = csv.reader(line for line in file if line.endswith("\n"))
            header = next(lines, [])
            if header[:2] != ["run", "seed"] or "finished" not in header:
                raise ValueError("the header does not begin with run, seed, or has no column 'finished'")
            for number, row in enumerate(lines, 2):
                if len(row) != len(header):
                    raise ValueError(f"there must be {len(header)} cells")
                rows[int(row[0])] = row
    except OSError as error:
        raise DataError(f"cannot read '{path}' ({error.strerror}); choose the directory of a campaign") from None
    except ValueError as error:
        raise DataError(f"{path}:{number}: {error}; use a table of tenon-campaign with at least one run") from None
    columns = zip(*(rows[run] for run in sorted(rows))) if rows else [()] * len(header)
    table = dict(zip(header, columns))
    not_computed = {name: {int(run) for run, text in zip(table["run"], texts) if text == "NaN"}
                    for name, texts in table.items()}
    return {name: _typed(name, texts) for name, texts in table.items()}, not_computed


def _typed(name: str, texts: tuple[str, ...]) -> list[Any]:
    """Converts run and seed to integers, and other columns to booleans, floats or texts."""
    texts = tuple("" if text == "null" else text for text in texts)  # a figure without a value
    present = [text for text in texts if text]
    if name in ("run", "seed"):
        return [int(text) for text in texts]
    if present and all(text in ("true", "false") for text in present):
        return [text == "true" if text else None for text in texts]
    try:
        if "_" not in "".join(present):  # Python reads 1_000 as a number
            return [float(text or "nan") for text in texts]
    except ValueError:
        pass
    return [text or None for text in texts]
