"""Tests of tenon.run and tenon.run_campaign with a small program instead of the apps."""
import contextlib
import io
import json
import os
import pathlib
import signal
import sys
import threading
import unittest
from unittest import mock

import fixtures
import tenon

PROGRAM = f"#!{sys.executable}\n" + pathlib.Path(__file__).with_name("program.py").read_text()


class Programs(fixtures.OutputTest):

    def setUp(self):
        super().setUp()
        for name in ("tenon-fake", "tenon-campaign"):
            (self.out / name).write_text(PROGRAM)
            (self.out / name).chmod(0o755)
        environment = mock.patch.dict(os.environ, {"TENON_BIN": str(self.out), "HOW": "0"})
        environment.start()
        self.addCleanup(environment.stop)
        self.messages = io.StringIO()
        redirect = contextlib.redirect_stderr(self.messages)
        redirect.__enter__()
        self.addCleanup(redirect.__exit__, None, None, None)

    def test_options(self):
        settings = {"x": [1, {"on": "left"}], "y": True, "robot": "a1", "file": pathlib.Path("a b")}
        run = tenon.run("tenon-fake", "A1", out=self.out / "o", seed=3, duration=0.5, set=settings, graph=None,
                        live_address="::", compare=True)
        self.assertEqual(run.figures["arguments"],
                         ["A1", '--set=x=[1, {"on": "left"}]', "--set=y=true", "--set=robot=a1", "--set=file=a b",
                          "--seed=3", "--duration=0.5", "--live-address=::", "--compare", f"--out={self.out}/o"])
        self.assertEqual((run.exit_code, run.finished, run.directory), (0, True, self.out / "o"))
        self.assertEqual(self.messages.getvalue(), "progress\n")
        self.assertNotEqual(run.figures["group"], os.getpgrp())  # the terminal sends Ctrl-C to the group of Python

    @unittest.skipUnless(fixtures.has("numpy"), "NumPy is not installed")
    def test_arrays_are_values(self):
        import numpy
        settings = {"x": numpy.array([1.5, 2]), "y": numpy.float32(0.5)}
        run = tenon.run("tenon-fake", "A1", out=self.out / "o", set=settings)
        self.assertEqual(run.figures["arguments"][1:3], ["--set=x=[1.5, 2.0]", "--set=y=0.5"])

    def test_default_directory(self):
        here = os.getcwd()
        os.chdir(self.out)
        self.addCleanup(os.chdir, here)
        self.assertEqual(tenon.run("tenon-fake", "files/my.yaml").directory, pathlib.Path("out/my"))
        self.assertEqual(tenon.run_campaign("files/many.yaml").directory, pathlib.Path("out/many"))

    def test_a_fall_is_a_result(self):
        os.environ["HOW"] = "3"
        run = tenon.run("tenon-fake", "A1", out=self.out / "o")
        self.assertEqual((run.exit_code, run.finished), (3, False))

    def test_exit_codes_that_raise(self):
        for code, error in ((2, tenon.UsageError), (4, tenon.NumericalFailure), (5, tenon.RunError)):
            os.environ["HOW"] = str(code)
            with self.assertRaisesRegex(tenon.RunError, r"^tenon-fake: wrong 'key'; correct it$") as raised:
                tenon.run("tenon-fake", "A1", out=self.out / "o")
            self.assertIs(type(raised.exception), error)
            self.assertEqual((raised.exception.exit_code, raised.exception.directory), (code, self.out / "o"))
            with self.assertRaises(error):
                tenon.run_campaign("many.yaml", out=self.out / "c")
        self.assertEqual(tenon.read(self.out / "o").figures["end_reason"], "end")
        self.assertNotIn("wrong", self.messages.getvalue())

    def test_killed(self):
        os.environ["HOW"] = "kill"
        with self.assertRaisesRegex(tenon.RunError, "tenon-fake was killed by SIGKILL.*/o") as raised:
            tenon.run("tenon-fake", "A1", out=self.out / "o")
        self.assertEqual(raised.exception.exit_code, -signal.SIGKILL)

    def test_interrupt_waits_for_the_files(self):
        os.environ["HOW"] = "wait"

        def interrupt():
            while not (self.out / "o/waiting").exists() or "progress" not in self.messages.getvalue():
                pass
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

        thread = threading.Thread(target=interrupt)
        thread.start()
        with self.assertRaises(KeyboardInterrupt):
            tenon.run("tenon-fake", "A1", out=self.out / "o")
        thread.join()
        self.assertEqual(json.loads((self.out / "o/summary.json").read_text())["end_reason"], "stopped")

    def test_campaign(self):
        campaign = tenon.run_campaign("many.yaml", jobs=2, resume=True, out=self.out / "c")
        self.assertEqual((campaign.exit_code, list(campaign["seed"])), (0, [1]))
        self.assertEqual(campaign.figures["arguments"], ["many.yaml", "--jobs=2", "--resume", f"--out={self.out}/c"])

    def test_places_of_programs(self):
        self.assertEqual(tenon.find("tenon-fake"), (self.out / "tenon-fake").resolve())
        with self.assertRaisesRegex(tenon.ProgramNotFound, f"'tenon-none' in {self.out};.*TENON_BIN"):
            tenon.find("tenon-none")
        os.environ["TENON_BIN"] = "/nowhere"
        with self.assertRaisesRegex(tenon.ProgramNotFound, "'tenon-fake' in /nowhere;"):
            tenon.run("tenon-fake", "A1")
        self.assertEqual(tenon.find(self.out / "tenon-fake"), (self.out / "tenon-fake").resolve())
        del os.environ["TENON_BIN"]
        os.environ["PATH"] = f"/nowhere:{self.out}"
        self.assertEqual(tenon.find("tenon-fake"), (self.out / "tenon-fake").resolve())
        with self.assertRaisesRegex(tenon.ProgramNotFound, "build/release/apps:.*/bin:/nowhere"):
            tenon.find("tenon-none")


if __name__ == "__main__":
    unittest.main()
