"""Runs the installed example with the installed module and apps: python_example.py PREFIX OUT"""
import importlib.util
import pathlib
import runpy
import sys

import tenon

prefix, out = map(pathlib.Path, sys.argv[1:])
if not importlib.util.find_spec("matplotlib"):
    sys.exit(77)
for path in (pathlib.Path(tenon.__file__), tenon.find("tenon-campaign")):
    assert path.is_relative_to(prefix.resolve()), f"{path} is not in {prefix}"
sys.argv[1:] = [str(out)]
runpy.run_path(str(prefix / "share/tenon/examples/python/payload.py"), run_name="__main__")
assert (out / "payload.pdf").read_bytes().startswith(b"%PDF")
errors = tenon.read(out).group_by("controller")
assert errors["pd"].quantiles("tracking_error_rms_m")[1] > errors["mpc_equilibrium"].quantiles("tracking_error_rms_m")[1]
