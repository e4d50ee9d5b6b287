"""Output directories of apps: a run, a comparison of several runs, or a campaign."""

from __future__ import annotations

import array
import collections.abc
import pathlib
from typing import Any, Iterator

from tenon.campaign import Campaign
from tenon.data import PathLike, numpy_or_none, read_json
from tenon.errors import DataError, UnknownName


class Run(collections.abc.Mapping):
    """A run: its figures, and its signals by name.

    `run["time"]` is a column of signals.csv: an array of NumPy, or an `array.array` without NumPy. A name such as
    `loop.observer.wrench.force_W` selects all its elements: an array with one row for each, or a list of columns
    without NumPy, so `x, y, z = run[name]` works in both cases. The file is read when a signal is first used.
    """

    def __init__(self, directory: PathLike, exit_code: int | None = None) -> None:
        """Reads summary.json. Raises DataError if it is missing or damaged."""
        self.directory = pathlib.Path(directory)
        self.exit_code = exit_code  #: 0, 3 (fell, broke a limit), 130 or 143 (stopped); None if only read
        self.figures: dict[str, Any] = read_json(self.directory / "summary.json")  #: None is a figure without data
        self._units: dict[str, str] = {}
        self._samples = array.array("d")

    @property
    def finished(self) -> bool:
        """Whether the run reached its planned end and broke no limit that its scenario forbids."""
        return bool(self.figures.get("finished", self.exit_code == 0))

    @property
    def units(self) -> dict[str, str]:
        """The units of all columns, such as "m/s^2"; empty for numbers without unit. Raises DataError."""
        if not self._units:
            self._read(self.directory / "signals.csv")
        return self._units

    def elements(self, name: str) -> list[str]:
        """Returns the columns of a signal. Raises UnknownName if there are none."""
        found = [column for column in self.units if column == name or column.startswith(name + ".")]
        if not found:
            raise UnknownName("signal", name, self.directory / "signals.csv", self.units)
        return found

    def __getitem__(self, name: str) -> Any:
        columns = self.elements(name)
        names = list(self.units)
        places = [names.index(column) for column in columns]
        numpy = numpy_or_none()
        if numpy:
            values: Any = numpy.frombuffer(self._samples).reshape(-1, len(names))[:, places].T
        else:
            values = [self._samples[place::len(names)] for place in places]
        return values[0] if columns == [name] else values

    def __iter__(self) -> Iterator[str]:
        return iter(self.units)

    def __len__(self) -> int:
        return len(self.units)

    # A Mapping compares its values, but arrays have no single ==, and hashing needs identity.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __repr__(self) -> str:
        return f"<Run '{self.directory}': {self.figures.get('end_reason', 'finished' if self.finished else 'failed')}>"

    def to_pandas(self) -> Any:
        """Returns a DataFrame of all columns with the index `time`; `attrs["units"]` has the units. Needs pandas."""
        import pandas
        frame = pandas.DataFrame({name: self[name] for name in self}).set_index("time")
        frame.attrs["units"] = dict(self.units)
        return frame

    def plot(self, *names: str, axes: Any = None, label: str = "", save: PathLike | None = None) -> Any:
        """Draws signals over time, with one plot for each unit. Needs matplotlib. Returns its Figure.

        `axes` are Axes of matplotlib to draw into, for signals of one unit; `label` precedes the names in the legend;
        `save` is a file such as force.pdf or force.svg. Raises UnknownName, ImportError, and ValueError if there are no
        names, or several units for `axes`.
        """
        from tenon.plots import plot_signals
        return plot_signals(self, names, axes, label, save)

    def _read(self, path: pathlib.Path) -> None:
        number = 1
        try:
            with open(path, encoding="utf-8") as file:
                header = file.readline().rstrip("\n").split(",")
                if header[0] != "time [s]":
                    raise ValueError("the first column is not 'time [s]'")
                samples = array.array("d")
                for number, line in enumerate(file, 2):
                    if not line.endswith("\n"):  # the app was killed while it wrote
                        break
                    samples.extend(map(float, line.split(",")))
                    if len(samples) != (number - 1) * len(header):
                        raise ValueError(f"there must be {len(header)} cells")
        except OSError as error:
            raise DataError(f"cannot read '{path}' ({error.strerror}); choose the directory of a run") from None
        except ValueError as error:
            raise DataError(f"{path}:{number}: {error}; repeat the run") from None
        self._samples = samples
        self._units = {name: unit[:-1] for name, _, unit in (cell.partition(" [") for cell in header)}


class Comparison(dict):
    """Several runs that an app with the option --compare wrote below one directory: {name: Run}."""

    def __init__(self, directory: PathLike, exit_code: int | None = None) -> None:
        """Reads the summaries. Raises DataError if one is missing or damaged."""
        self.directory = pathlib.Path(directory)
        self.exit_code = exit_code  #: the largest of all runs; None if only read
        self.figures: dict[str, dict[str, Any]] = read_json(self.directory / "summary.json")  #: of each run
        super().__init__((name, Run(self.directory / name)) for name in self.figures)

    __eq__, __ne__ = object.__eq__, object.__ne__
    __hash__ = object.__hash__  # type: ignore[assignment]

    @property
    def finished(self) -> bool:
        """Whether all runs finished."""
        return all(run.finished for run in self.values())

    def __missing__(self, name: str) -> Run:
        raise UnknownName("run", name, self.directory, self)


def read(directory: PathLike, exit_code: int | None = None) -> Run | Comparison | Campaign:
    """Reads the output directory of a run, a comparison or a campaign. Raises DataError if it is another directory."""
    path = pathlib.Path(directory)
    if (path / "runs.csv").exists():
        return Campaign(path, exit_code)
    figures = read_json(path / "summary.json").values()
    compares = figures and all(isinstance(value, dict) and "finished" in value for value in figures)
    return Comparison(path, exit_code) if compares else Run(path, exit_code)
