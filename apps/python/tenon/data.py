"""Columns of numbers, with or without NumPy; quantiles and shares; the units in the names of figures; JSON files."""

from __future__ import annotations

import array
import importlib.util
import json
import math
import os
import pathlib
import statistics
from typing import Any, NamedTuple, Sequence, Union

from tenon.errors import DataError

PathLike = Union[str, "os.PathLike[str]"]


def numpy_or_none() -> Any:
    """Returns the module NumPy, or None if it is not installed."""
    return importlib.import_module("numpy") if importlib.util.find_spec("numpy") else None


def column(values: Sequence[Any]) -> Any:
    """Returns an array of NumPy, or without NumPy an `array.array` of floats or a list of anything else."""
    numpy = numpy_or_none()
    if numpy:
        return numpy.array(values, dtype=object if None in values else None)
    return array.array("d", values) if all(isinstance(value, float) for value in values) else list(values)


def quantiles(values: Sequence[float], probabilities: Sequence[float]) -> list[float]:
    """Returns the quantiles of the values that are not NaN, interpolated linearly; NaN if there are no values.

    Raises ValueError unless the probabilities are from 0 to 1.
    """
    ordered = sorted(value for value in values if not math.isnan(value))
    result = []
    for probability in probabilities:
        if not 0 <= probability <= 1:
            raise ValueError(f"the probability {probability} of a quantile must be from 0 to 1")
        share, below = math.modf(probability * (len(ordered) - 1)) if ordered else (0, 0)
        ends = ordered[int(below):int(below) + 2] or [math.nan]
        result.append(ends[0] + (share * (ends[1] - ends[0]) if share > 0 else 0))
    return result


class Share(NamedTuple):
    """The share of runs with a property, and Wilson's interval of the probability."""

    share: float  #: NaN without runs
    low: float  #: lower end of the interval
    high: float  #: upper end of the interval
    runs: int  #: number of runs


def wilson(count: int, runs: int, confidence: float) -> Share:
    """Returns the share `count / runs` with its interval, such as for the confidence 0.95."""
    if runs == 0:
        return Share(math.nan, 0, 1, 0)
    z2 = statistics.NormalDist().inv_cdf((1 + confidence) / 2)**2
    share = count / runs
    centre = (share + z2 / (2 * runs)) / (1 + z2 / runs)
    half = math.sqrt(z2 * (share * (1 - share) / runs + z2 / (4 * runs**2))) / (1 + z2 / runs)
    return Share(share, min(share, max(0, centre - half)), max(share, min(1, centre + half)), runs)


_UNITS = frozenset("m mm cm km um g kg t lb s ms us ns h Hz hz kHz rpm rad mrad deg N mN kN Nm J kJ W kW V mV A mA "
                   "Pa kPa MPa GPa percent per sqrt".split())


def split_unit(name: str) -> tuple[str, str]:
    """Splits the name of a figure or key, for example `speed_max_m_per_s.left` into "speed_max.left" and "m/s"."""
    parts = name.split(".")
    for i in reversed(range(len(parts))):
        words = parts[i].split("_")
        begin = len(words)
        while begin > 1 and (words[begin - 1].rstrip("234") or "?") in _UNITS:
            begin -= 1
        if begin < len(words):
            unit = " ".join(word[:-1] + "^" + word[-1] if word[-1] in "234" else word for word in words[begin:])
            above, _, below = unit.replace("hz", "Hz").replace("sqrt ", "√").partition("per")
            below = f"({below.strip()})" if " " in below.strip() else below.strip()
            stem = ".".join([*parts[:i], "_".join(words[:begin]), *parts[i + 1:]])
            return stem, f"{above.strip() or '1'}/{below}" if below else above
    return name, ""


def read_json(path: pathlib.Path) -> dict[str, Any]:
    """Reads a file that contains one JSON object. Raises DataError if it is missing or damaged."""
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DataError(f"cannot read '{path}' ({error.strerror}); choose the output of a finished run") from None
    except ValueError as error:
        raise DataError(f"'{path}' is damaged ({error}); repeat the run") from None
    if not isinstance(values, dict):
        raise DataError(f"'{path}' is not a summary; check whether another program overwrote it")
    return values
