"""Output directories as the apps write them, in temporary directories, with and without NumPy."""
import importlib.util
import json
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

SUMMARY = {
    "case": "A1", "finished": True, "end_reason": "end of the run", "com_error_max_m": 0.002, "loaded_m": None,
    "foot_error_max_m": {"left": 0.001, "right": 0.002}, "limits": {"torque_max_N_m": {"high": 60.0}}
}
SIGNALS = """time [s],loop.pd.force.x [N],loop.pd.force.y [N],loop.pd.forced,loop.cart.state.a [m/s^2]
0,1,2,7,0.5
0.1,3,-4e-3,7,nan
0.2,5,6,8,-1.5
"""
# The runs are not in order; run 5 was refused, and run 2 fell before it had an error.
RUNS = """run,seed,walk.friction,scheme,payload.mass_kg,case,finished,error_max_m,foot_m.left,qp,end_reason
0,18446744073709551615,0.5,ours,1.5,A1,true,0.1,1,true,end of the run
2,1,0.8,ours,1.5,A1,false,null,2,false,"fell, at 2 s"
1,2,0.5,ours,2.5,A1,true,0.3,,true,end of the run
3,2,0.8,thesis,2.5,A1,true,0.2,4,true,end of the run
5,4,0.5,thesis,,,false,,,,no 1_000
"""
CAMPAIGN = {"confidence": 0.9, "points": [{"at": {"walk.friction": "0.5", "scheme": "ours"}, "runs": 1}]}


class OutputTest(unittest.TestCase):
    """Has an empty directory `out`."""

    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.out = pathlib.Path(directory.name)

    def write_run(self, name="", summary=None, signals=SIGNALS):
        directory = self.out / name
        directory.mkdir(exist_ok=True)
        (directory / "summary.json").write_text(json.dumps(summary or SUMMARY))
        (directory / "signals.csv").write_text(signals)
        return directory

    def write_campaign(self, runs=RUNS):
        (self.out / "runs.csv").write_text(runs)
        (self.out / "summary.json").write_text(json.dumps(CAMPAIGN))
        return self.out


class WithNumpy:
    """Runs the tests of a class with NumPy."""

    def setUp(self):
        super().setUp()
        if not has("numpy"):
            self.skipTest("NumPy is not installed")


class WithoutNumpy:
    """Runs the tests of a class as if NumPy were not installed."""

    def setUp(self):
        super().setUp()
        patch = mock.patch.dict(sys.modules, {"numpy": None})
        patch.start()
        self.addCleanup(patch.stop)


def has(module):
    return importlib.util.find_spec(module) is not None
