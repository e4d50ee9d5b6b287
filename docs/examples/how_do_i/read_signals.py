#!/usr/bin/env python3
"""The columns of a signals.csv, with the standard library alone: read_signals.py RUN/signals.csv"""
import csv
import sys


def read(path):
    """{column: list of numbers}; names end in their unit: 'time [s]'."""
    with open(path, newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        columns = zip(*([float(x) for x in row] for row in rows))
        return dict(zip(names, map(list, columns)))


if __name__ == "__main__":
    signals = read(sys.argv[1])
    time = signals["time [s]"]
    print(f"{len(signals)} columns, {len(time)} rows, {time[0]} to {time[-1]} s")
    for name in [name for name in signals if name.endswith(".x [m]")]:
        print(f"{name}: {min(signals[name]):.3f} to {max(signals[name]):.3f}")
