#!/usr/bin/env python3
"""Checks the errors and the compile times of users' programs against the installed headers.

usage: check.py errors COMMAND...   every file of errors/ is refused for the reason in its first line, in few lines;
                                    after "says first", another error may follow
       check.py headers COMMAND...  the headers of headers.txt take no longer than it says, as multiples of <Eigen/Dense>
       check.py layouts COMMAND...  the types of all headers have the same size and alignment for all vector instructions;
                                    by GCC, with the headers in the first -I

COMMAND compiles, say: g++ -std=c++20 -I/opt/tenon/include -I/usr/include/eigen3
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
MOST_LINES = {"gcc": 10, "clang": 16}
RUNS = 4  # at most, until one is good


def check_errors(command):
    files = sorted((HERE / "errors").glob("*.cc"))
    failed = not files
    most = MOST_LINES["clang" if "clang" in pathlib.Path(command[0]).name else "gcc"]
    for file in files:
        first, expected = re.match("// says( first)?: (.*)", file.read_text()).groups()
        done = subprocess.run([*command, "-fsyntax-only", file], capture_output=True, text=True, check=False)
        lines = done.stderr.strip().split("\n")
        errors = [line for line in lines if " error: " in line]
        good = done.returncode != 0 and len(lines) <= most and 1 <= len(errors) <= (2 if first else 1) and expected in errors[0]
        print(f"{'ok  ' if good else 'BAD '} {file.name}: {len(lines)} lines, {len(errors)} errors")
        if not good:
            failed = True
            print(done.stderr)
    return failed


def cost(command, text, directory):
    """User time [s] and memory [MB]."""
    file = pathlib.Path(directory) / "file.cc"
    file.write_text(text)
    process = subprocess.Popen([*command, "-O2", "-DNDEBUG", "-c", file, "-o", "/dev/null"])
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"does not compile:\n{text}")
    return usage.ru_utime, usage.ru_maxrss / 1024


def check_headers(command):
    """A machine gets slower and faster by a fifth within a minute: so the unit is measured beside each header."""
    failed = False
    with tempfile.TemporaryDirectory() as directory:
        for line in (HERE / "headers.txt").read_text().split("\n"):
            if not line or line.startswith("#"):
                continue
            name, most, most_megabytes = line.split()
            text = (HERE / name).read_text() if name.endswith(".cc") else f"#include <{name}>\n"
            for _ in range(RUNS):
                unit, _ = cost(command, "#include <Eigen/Dense>\n", directory)
                seconds, megabytes = cost(command, text, directory)
                good = seconds <= float(most) * unit and megabytes <= float(most_megabytes)
                if good:
                    break
            failed |= not good
            print(f"{'ok  ' if good else 'BAD '} {name}: {seconds:.2f} s are {seconds / unit:.2f} <Eigen/Dense>, "
                  f"at most {most}; {megabytes:.0f} MB, at most {most_megabytes}")
    return failed


def sizes(command, directory):
    """Size and alignment of each class of Tenon that GCC lays out."""
    dump = pathlib.Path(directory) / "classes.txt"
    subprocess.run([*command, "-w", "-fsyntax-only", f"-fdump-lang-class={dump}"], check=True)
    found = re.findall(r"^Class (tenon::.*)\n +size=(\d+) align=(\d+)", dump.read_text(), re.MULTILINE)
    return {name: (size, alignment) for name, size, alignment in found}


def check_layouts(command):
    root = next(pathlib.Path(argument[2:]) for argument in command if argument.startswith("-I"))
    headers = sorted(str(header.relative_to(root)) for header in (root / "tenon").rglob("*.h"))
    with tempfile.TemporaryDirectory() as directory:
        file = pathlib.Path(directory) / "file.cc"
        file.write_text("".join(f"#include <{header}>\n" for header in headers))
        first = sizes([*command, file], directory)
        failed = len(first) < 1000
        print(f"{len(first)} types of {len(headers)} headers")
        for flags in (["-mavx2", "-mfma"], ["-mavx512f", "-mfma"]):
            other = sizes([*command, *flags, file], directory)
            for name in sorted(set(first) | set(other)):
                if first.get(name) != other.get(name):
                    failed = True
                    print(f"BAD  {name}: {first.get(name)}, with {' '.join(flags)} {other.get(name)}")
    return failed


def main():
    checks = {"errors": check_errors, "headers": check_headers, "layouts": check_layouts}
    if len(sys.argv) < 3 or sys.argv[1] not in checks:
        raise SystemExit(__doc__)
    raise SystemExit(checks[sys.argv[1]](sys.argv[2:]))


if __name__ == "__main__":
    main()
