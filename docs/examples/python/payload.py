"""From a campaign to a figure of a paper: payload.py OUT"""
import pathlib
import sys

import tenon

out = pathlib.Path(sys.argv[1])
campaign = tenon.run_campaign(pathlib.Path(__file__).with_name("payload.yaml"), out=out)
for (mass, controller), runs in campaign.group_by("payload.mass_kg", "controller").items():
    low, median, high = runs.quantiles("tracking_error_rms_m")
    print(f"{controller}, {mass:g} kg: {median:.4f} m, 80 % from {low:.4f} to {high:.4f} m; {runs.share().share:.0%} survive")
survived = campaign.where({"finished": True})
survived.plot("payload.mass_kg", "tracking_error_rms_m", by="controller", save=out / "payload.pdf")
