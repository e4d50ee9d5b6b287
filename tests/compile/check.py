#!/usr/bin/env python3
"""What a user's compiler says and how long it takes, against the installed headers.

usage: check.py errors COMMAND...   every file of errors/ is refused for the reason in its first line, in 10 lines at most
       check.py headers COMMAND...  the headers of headers.txt take no longer than it says, as multiples of <Eigen/Dense>

COMMAND compiles, say: g++ -std=c++20 -I/opt/tenon/include -I/usr/include/eigen3
"""

import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
MOST_LINES = 10
RUNS = 3


def check_errors(command):
    failed = False
    for file in sorted((HERE / "errors").glob("*.cc")):
        expected = file.read_text().split("\n")[0].removeprefix("// says: ")
        done = subprocess.run([*command, "-fsyntax-only", file], capture_output=True, text=True, check=False)
        lines = done.stderr.strip().split("\n")
        errors = [line for line in lines if " error: " in line]
        good = done.returncode != 0 and len(lines) <= MOST_LINES and len(errors) == 1 and expected in errors[0]
        print(f"{'ok  ' if good else 'BAD '} {file.name}: {len(lines)} lines, {len(errors)} errors")
        if not good:
            failed = True
            print(done.stderr)
    return failed


def cost(command, text, directory, enough=0.0):
    """User time [s] and memory [MB]; the least time of some runs, of one if it is short enough."""
    file = pathlib.Path(directory) / "file.cc"
    file.write_text(text)
    seconds, megabytes = [], []
    while len(seconds) < RUNS and not (seconds and min(seconds) <= enough):
        process = subprocess.Popen([*command, "-O2", "-DNDEBUG", "-c", file, "-o", "/dev/null"])
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            raise SystemExit(f"does not compile:\n{text}")
        seconds.append(usage.ru_utime)
        megabytes.append(usage.ru_maxrss / 1024)
    return min(seconds), max(megabytes)


def check_headers(command):
    failed = False
    with tempfile.TemporaryDirectory() as directory:
        unit, _ = cost(command, "#include <Eigen/Dense>\n", directory)
        print(f"<Eigen/Dense> takes {unit:.2f} s")
        for line in (HERE / "headers.txt").read_text().split("\n"):
            if not line or line.startswith("#"):
                continue
            name, most, most_megabytes = line.split()
            text = (HERE / name).read_text() if name.endswith(".cc") else f"#include <{name}>\n"
            seconds, megabytes = cost(command, text, directory, float(most) * unit)
            good = seconds <= float(most) * unit and megabytes <= float(most_megabytes)
            failed |= not good
            print(f"{'ok  ' if good else 'BAD '} {name}: {seconds / unit:.2f} of at most {most}, "
                  f"{megabytes:.0f} MB of at most {most_megabytes}")
    return failed


def main():
    if len(sys.argv) < 3 or sys.argv[1] not in ("errors", "headers"):
        raise SystemExit(__doc__)
    check = check_errors if sys.argv[1] == "errors" else check_headers
    raise SystemExit(check(sys.argv[2:]))


if __name__ == "__main__":
    main()
