"""Exceptions of the module. All derive from `TenonError`; their texts name the thing, the place and the remedy."""

from __future__ import annotations

import difflib
import pathlib
from typing import Iterable


class TenonError(Exception):
    """Base class of all exceptions of this module."""


class ProgramNotFound(TenonError):
    """An app is not in the directories that the module searches."""


class RunError(TenonError):
    """An app failed. `exit_code` is 5 if it could not write into `directory`, and negative if a signal killed it."""

    def __init__(self, message: str, exit_code: int, directory: pathlib.Path) -> None:
        super().__init__(message)
        self.exit_code, self.directory = exit_code, directory


class UsageError(RunError):
    """Exit code 2: an option, the scenario, the robot or the campaign is invalid. There is no output."""


class NumericalFailure(RunError):
    """Exit code 4: the integration failed. `tenon.read(error.directory)` returns the run until then."""


class DataError(TenonError):
    """A file of an output directory is missing or damaged."""


class UnknownName(TenonError, KeyError):
    """A signal, column or run does not exist."""

    def __init__(self, kind: str, name: str, place: pathlib.Path, valid: Iterable[str]) -> None:
        near = difflib.get_close_matches(name, valid, n=3, cutoff=0.5)
        hint = f"did you mean {' or '.join(near)}?" if near else "list(…) of the object shows all names"
        super().__init__(f"there is no {kind} '{name}' in {place}; {hint}")

    def __str__(self) -> str:  # KeyError would add quotes
        return str(self.args[0])
