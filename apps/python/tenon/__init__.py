"""Runs the apps of Tenon, reads what they wrote, and plots it.

    import tenon
    run = tenon.run("tenon-quadruped", "A1", set={"walk.friction": 0.5}, seed=3, duration=4, out="out/A1")
    print(run.finished, run.figures["com_error_max_m"])
    run.plot("loop.observer.wrench.force_W", save="force.pdf")

    campaign = tenon.run_campaign("forces_friction", jobs=2, out="out/forces")
    campaign.plot(x="force_N", y="finished", by="walk.friction", save="survival.pdf")

`tenon.read(directory)` reads an existing output directory. The module needs only Python. Columns are arrays of NumPy if
it is installed; plots need matplotlib, and `to_pandas()` needs pandas.
"""

from tenon.campaign import Campaign
from tenon.errors import DataError, NumericalFailure, ProgramNotFound, RunError, TenonError, UnknownName, UsageError
from tenon.data import Share
from tenon.programs import find, run, run_campaign
from tenon.results import Comparison, Run, read

__all__ = [
    "Campaign", "Comparison", "DataError", "NumericalFailure", "ProgramNotFound", "Run", "RunError", "Share",
    "TenonError", "UnknownName", "UsageError", "find", "read", "run", "run_campaign"
]
