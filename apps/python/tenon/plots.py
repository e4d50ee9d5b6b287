"""Plots by matplotlib, which is imported only when a plot is drawn."""

from __future__ import annotations

import math
import os
import re
from typing import Any, Sequence

from tenon.campaign import Campaign
from tenon.data import split_unit
from tenon.results import Run

_SIZE = (6.4, 2.7)  # width of a figure and height of a plot [in]
_BAR_SHIFT = 0.3  # width of a group of error bars, in units of the distance between groups


def plot_signals(run: Run, names: Sequence[str], axes: Any, label: str, save: Any) -> Any:
    """See Run.plot."""
    by_unit: dict[str, list[str]] = {}
    for name in names:
        for column in run.elements(name):
            by_unit.setdefault(run.units[column], []).append(column)
    if not by_unit:
        raise ValueError(f"plot needs the name of a signal of {run.directory}; list(run) shows them")
    if axes is not None and len(by_unit) > 1:
        raise ValueError(f"signals in {', '.join(by_unit)} need one plot each; plot them one by one, or omit `axes`")
    figure, all_axes = _figure(axes, len(by_unit))
    for own, (unit, columns) in zip(all_axes, by_unit.items()):
        signal, rests = _distinguish(columns)
        for column, rest in zip(columns, rests):
            own.plot(run["time"], run[column], linewidth=1.2, label=": ".join(filter(None, (label, rest))))
        own.set_ylabel(_label(signal, unit))
        own.margins(x=0)
        if label or len(columns) > 1:
            own.legend(frameon=False, fontsize="small")
    all_axes[-1].set_xlabel(_label("time", run.units["time"]))
    return _finish(figure, axes is None, save)


def plot_campaign(campaign: Campaign, x: str, y: str, by: str | None, axes: Any, save: Any) -> Any:
    """See Campaign.plot."""
    groups = campaign.group_by(by) if by else {"": campaign}
    values = campaign.axes.get(x)
    is_share = any(isinstance(value, bool) for value in campaign[y].tolist())
    figure, (own,) = _figure(axes, 1)
    for i, (value, runs) in enumerate(groups.items()):
        label = None if not by else f"{by} = {value:g}" if isinstance(value, float) else f"{by} = {value}"
        if values:
            _draw_band(own, runs, x, y, is_share, values, _BAR_SHIFT * ((i + 0.5) / len(groups) - 0.5), label)
        else:
            _draw_dots(own, runs, x, y, label)
    own.set_xlabel(_label(*split_unit(x)))
    own.set_ylabel(f"share of runs: {y}" if is_share else _label(*split_unit(y)))
    if by:
        own.legend(frameon=False, fontsize="small")
    return _finish(figure, axes is None, save)


def _draw_band(axes: Any, campaign: Campaign, x: str, y: str, is_share: bool, values: list[Any], shift: float,
               label: str | None) -> None:
    """Draws the middle, the lower and the upper end of y: as a line and a band, or as bars if x has texts."""
    points = []
    for value, runs in campaign.group_by(x).items():
        middle, low, high = runs.share(y)[:3] if is_share else runs.quantiles(y, (0.5, 0.1, 0.9))
        if value is not None and not math.isnan(middle):
            points.append((value, middle, low, high))
    if any(isinstance(value, (str, bool)) for value in values):
        places = [values.index(value) + shift for value, *_ in points]
        bars = [[middle - low for _, middle, low, _ in points], [high - middle for _, middle, _, high in points]]
        axes.errorbar(places, [point[1] for point in points], bars, fmt="o", markersize=4, capsize=3, label=label)
        axes.set_xticks(range(len(values)), map(str, values))
        axes.set_xlim(-0.5, len(values) - 0.5)
        return
    at, middles, lows, highs = zip(*sorted(points)) if points else ((), (), (), ())
    line, = axes.plot(at, middles, marker="o", markersize=4, linewidth=1.2, label=label)
    axes.fill_between(at, lows, highs, color=line.get_color(), alpha=0.2, linewidth=0)


def _draw_dots(axes: Any, campaign: Campaign, x: str, y: str, label: str | None) -> None:
    color = None
    for finished, marker in ((True, "o"), (False, "x")):
        runs = campaign.where({"finished": finished})
        dots, = axes.plot(runs.numbers(x), runs.numbers(y), marker, markersize=4, color=color, alpha=0.7,
                          label=label if finished else None)
        color = dots.get_color()


def _figure(axes: Any, count: int) -> tuple[Any, list[Any]]:
    """Returns the figure of `axes`, or a new one with `count` plots above each other, and its Axes."""
    if axes is not None:
        return axes.figure, [axes]
    try:
        from matplotlib import pyplot
    except ImportError:
        raise ImportError("plots need matplotlib: install python3-matplotlib") from None
    figure, grid = pyplot.subplots(count, 1, sharex=True, squeeze=False, layout="constrained",
                                   figsize=(_SIZE[0], _SIZE[1] * count + 0.5))
    for own in grid[:, 0]:
        own.grid(alpha=0.3)
        own.spines[["top", "right"]].set_visible(False)
    return figure, list(grid[:, 0])


def _finish(figure: Any, own: bool, save: Any) -> Any:
    """Writes the figure if a file is given, and closes it, so that a loop can save many figures.

    Also closes an `own` figure in a notebook, which shows the value of a cell: the same figure, if open, would follow.
    """
    import matplotlib
    from matplotlib import pyplot
    if save is not None:
        figure.savefig(save)
    if save is not None or (own and "inline" in matplotlib.get_backend()):
        pyplot.close(figure)
    return figure


def _distinguish(columns: list[str]) -> tuple[str, list[str]]:
    """Returns the name of the signal if all columns are its elements, and texts that distinguish the columns."""
    parts = [column.split(".") for column in columns]
    if len(columns) == 1:
        return ".".join(parts[0][-2:]), parts[0][-1:]
    shared = len(os.path.commonprefix(parts))
    is_signal = shared > 0 and all(len(part) <= shared + 2 for part in parts)
    return parts[0][shared - 1] if is_signal else "", [".".join(part[shared:]) for part in parts]


def _label(name: str, unit: str) -> str:
    """Returns "name [unit]" with raised powers."""
    power = re.sub(r"\^(\d+)", r"$^{\1}$", unit)
    return " ".join(filter(None, (name, power and f"[{power}]")))
