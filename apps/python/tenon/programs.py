"""Starts the apps and turns their exit codes into results and exceptions."""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
from typing import Any, Mapping

from tenon.campaign import Campaign
from tenon.data import PathLike
from tenon.errors import NumericalFailure, ProgramNotFound, RunError, UsageError
from tenon.results import Comparison, Run, read

_HERE = pathlib.Path(__file__).resolve().parent
_ERRORS = {2: UsageError, 4: NumericalFailure}
_RAN = (0, 3, 130, 143)  # finished, did not survive, stopped by SIGINT, stopped by SIGTERM


def find(program: PathLike) -> pathlib.Path:
    """Returns the path of a program such as "tenon-cdpr". Raises ProgramNotFound.

    A name with a slash is a path. If the environment variable TENON_BIN is set, only this directory is searched.
    Otherwise the program is searched in the `bin` of the installation or the `build/release/apps` of the source tree to
    which this module belongs, and then in PATH.
    """
    folder, name = os.path.split(program)
    own = [str(_HERE.parents[2] / "build/release/apps"), str(_HERE.parents[3] / "bin")]
    places = folder or os.environ.get("TENON_BIN") or os.pathsep.join([*own, os.environ.get("PATH", os.defpath)])
    found = shutil.which(name, path=places)
    if not found:
        raise ProgramNotFound(f"there is no program '{name}' in {places}; install the apps, or set TENON_BIN to their "
                              "directory, such as build/release/apps")
    return pathlib.Path(found).resolve()


def run(app: PathLike, scenario: PathLike, *, set: Mapping[str, Any] | None = None, seed: int | None = None,
        duration: float | None = None, out: PathLike | None = None, **options: Any) -> Run | Comparison:
    """Runs an app and returns its result, a Comparison if it made several runs.

    `scenario` is the name of a shipped scenario or a YAML file; `set` gives values of its keys; `duration` is the
    simulated time [s]; `out` is the output directory (default: out/SCENARIO). Other options of the app are arguments,
    too: `gait="trot"`, `compare=True`. Progress and warnings of the app appear on stderr.

    A robot that falls or breaks a limit is a result: `exit_code` is 3 and `finished` is False. Raises ProgramNotFound,
    UsageError, NumericalFailure, and RunError for any other end of the app. After Ctrl-C, raises KeyboardInterrupt when
    the app has written its files.
    """
    settings = [f"--set={key}={_text(value)}" for key, value in (set or {}).items()]
    directory = pathlib.Path(out or pathlib.Path("out", pathlib.Path(scenario).stem))
    exit_code = _execute(app, scenario, [*settings, *_options(seed=seed, duration=duration, **options)], directory)
    return read(directory, exit_code)  # type: ignore[return-value]


def run_campaign(campaign: PathLike, *, jobs: int | None = None, out: PathLike | None = None,
                 **options: Any) -> Campaign:
    """Runs a campaign and returns its table.

    `campaign` is the name of a shipped campaign or a YAML file; `jobs` is the number of parallel runs (default: one for
    each core); `out` is the output directory (default: out/CAMPAIGN). Other options of tenon-campaign are arguments,
    too: `resume=True` keeps the runs that are there. Raises the exceptions of `run`.
    """
    directory = pathlib.Path(out or pathlib.Path("out", pathlib.Path(campaign).stem))
    return Campaign(directory, _execute("tenon-campaign", campaign, _options(jobs=jobs, **options), directory))


def _options(**options: Any) -> list[str]:
    """Returns the command-line options: compare=True is "--compare"; None and False give no option."""
    return [
        "--" + key.replace("_", "-") + ("" if value is True else f"={_text(value)}") for key, value in options.items()
        if value is not None and value is not False
    ]


def _text(value: Any) -> str:
    """Writes a value as YAML; a string is YAML already, as on the command line."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    return json.dumps(value, default=lambda item: item.tolist() if hasattr(item, "tolist") else os.fspath(item))


def _execute(app: PathLike, subject: PathLike, options: list[str], directory: pathlib.Path) -> int:
    """Runs an app and returns its exit code if that is one of _RAN. Raises the exception of any other exit code."""
    program = find(app)
    # In a session of its own, the app does not receive the Ctrl-C of the terminal, but only the signal below.
    with subprocess.Popen([program, os.fspath(subject), *options, f"--out={directory}"], stdin=subprocess.DEVNULL,
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace",
                          start_new_session=True) as process:
        try:
            message = _relay(process, program.name)
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
            _relay(process, program.name)
            raise
        finally:
            process.kill()  # does nothing if the app has ended
    code = process.returncode
    if code in _RAN:
        return code
    if code < 0:
        message = f"{program.name} was killed by {signal.Signals(-code).name}; '{directory}' has the files until then"
    raise _ERRORS.get(code, RunError)(message or f"{program} ended with the exit code {code}", code, directory)


def _relay(process: subprocess.Popen[str], name: str) -> str:
    """Copies the messages of an app to stderr until it ends. Returns its error message, which is not copied."""
    error, others = "", ""
    for line in process.stderr or ():
        if line.startswith(name + ": "):
            error += line
        else:
            others = (others + line)[-2000:]
            print(line, end="", file=sys.stderr, flush=True)
    process.wait()
    return (error or others).strip()
