"""Runs the apps of a build: TENON_BIN is their directory."""
import unittest

import fixtures
import tenon

CAMPAIGN = """
app: tenon-cdpr
scenario: D1
duration_s: 0.2
seeds: {first: 7, count: 3}
vary:
  robot.mass_kg: {grid: [12, 15]}
  controller: {list: [pd, mpc_zero]}
  payload.mass_kg: {uniform: [0, 1]}
"""


class Apps(fixtures.OutputTest):

    def test_run(self):
        run = tenon.run("tenon-quadruped", "A1", set={"walk.friction": 0.5, "log_rate_hz": 100}, seed=3, duration=0.2,
                        out=self.out)
        self.assertEqual((run.exit_code, run.finished, run.figures["seed"]), (0, True, 3))
        self.assertAlmostEqual(run["time"][-1], 0.2)
        self.assertEqual(len(run["loop.observer.wrench.force_W"]), 3)
        self.assertEqual({run.units[name] for name in run.elements("loop.observer.wrench.force_W")}, {"N"})
        self.assertIn("friction: 0.5", (self.out / "scenario.yaml").read_text())

    def test_comparison(self):
        comparison = tenon.run("tenon-cdpr", "D1", duration=0.1, compare=True, out=self.out)
        self.assertIn("pd", comparison)
        self.assertEqual(comparison["pd"].figures["controller"], "pd")

    def test_limit(self):
        stiff = {"pd.stiffness_N_per_m": 1e9}
        run = tenon.run("tenon-cdpr", "D1", controller="pd", set=stiff, duration=1, out=self.out)
        self.assertEqual((run.exit_code, run.finished), (3, False))

    def test_errors(self):
        with self.assertRaisesRegex(tenon.UsageError, "A9"):
            tenon.run("tenon-quadruped", "A9", out=self.out)
        with self.assertRaisesRegex(tenon.UsageError, "walk.fricton"):
            tenon.run("tenon-quadruped", "A1", set={"walk.fricton": 1}, out=self.out)
        faults = [{"at": "command", "kind": "nan", "start_s": 0.1}]
        with self.assertRaises(tenon.NumericalFailure) as raised:
            tenon.run("tenon-cdpr", "D1", set={"faults": faults}, duration=0.2, out=self.out)
        self.assertIn("fault_0", tenon.read(raised.exception.directory).figures["end_reason"])

    def test_campaign(self):
        (self.out / "many.yaml").write_text(CAMPAIGN)
        campaign = tenon.run_campaign(self.out / "many.yaml", jobs=1, out=self.out / "many")
        self.assertEqual(campaign.axes, {"robot.mass_kg": [12, 15], "controller": ["pd", "mpc_zero"]})
        self.assertEqual(len(campaign["run"]), 12)
        self.assertEqual(campaign.figures["survived"], sum(campaign["finished"]))
        groups = campaign.group_by("robot.mass_kg", "controller")
        for point in campaign.figures["points"]:
            share = groups[(float(point["at"]["robot.mass_kg"]), point["at"]["controller"])].share()
            self.assertEqual(share.runs, point["runs"])
            self.assertAlmostEqual(share.low, point["survival_low"])
            self.assertAlmostEqual(share.high, point["survival_high"])
        self.assertTrue(all(0 <= mass <= 1 for mass in campaign["payload.mass_kg"]))
        again = tenon.run_campaign(self.out / "many.yaml", jobs=1, resume=True, out=self.out / "many")
        self.assertEqual(list(again["wall_s"]), list(campaign["wall_s"]))


if __name__ == "__main__":
    unittest.main()
