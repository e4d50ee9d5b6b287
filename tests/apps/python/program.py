"""Stands for an app: writes its arguments into summary.json and ends as the environment variable HOW demands."""
import json
import os
import pathlib
import signal
import sys
import time

out = pathlib.Path(sys.argv[-1].removeprefix("--out="))
how = os.environ["HOW"]
name = pathlib.Path(sys.argv[0]).name


def write(end_reason):
    figures = {"finished": how == "0", "arguments": sys.argv[1:], "end_reason": end_reason, "group": os.getpgrp()}
    (out / "summary.json").write_text(json.dumps(figures))
    if name == "tenon-campaign":
        (out / "runs.csv").write_text("run,seed,finished\n0,1,true\n")


def stop(*_):
    print("stopped", file=sys.stderr)
    write("stopped")
    sys.exit(130)


out.mkdir(exist_ok=True, parents=True)
print("progress", file=sys.stderr, flush=True)
if how == "kill":
    os.kill(os.getpid(), signal.SIGKILL)
if how == "wait":
    signal.signal(signal.SIGINT, stop)
    (out / "waiting").touch()
    time.sleep(60)
write("end")
if how not in "03":
    print(f"{name}: wrong 'key'; correct it", file=sys.stderr)
sys.exit(int(how))
