"""Tests of tenon.Campaign and of the module's statistics."""
import math
import random
import statistics
import unittest
import warnings

import fixtures
import tenon
from tenon.data import quantiles, split_unit, wilson


class Table:
    """The tests, which hold with and without NumPy."""

    def setUp(self):
        super().setUp()
        self.campaign = tenon.read(self.write_campaign())

    def test_types(self):
        self.assertEqual(list(self.campaign["run"]), [0, 1, 2, 3, 5])
        self.assertEqual(self.campaign["seed"][0], 2**64 - 1)
        self.assertEqual(list(self.campaign["walk.friction"]), [0.5, 0.5, 0.8, 0.8, 0.5])
        self.assertEqual(list(self.campaign["scheme"]), ["ours", "ours", "ours", "thesis", "thesis"])
        self.assertEqual(list(self.campaign["finished"]), [True, True, False, True, False])
        self.assertEqual(self.campaign["end_reason"][2], "fell, at 2 s")
        self.assertEqual(len(self.campaign), 11)

    def test_equality_is_identity(self):
        self.assertTrue(self.campaign == self.campaign and self.campaign != tenon.read(self.out))
        self.assertIn(self.campaign, {self.campaign})

    def test_missing_is_never_zero(self):
        for name, place in (("error_max_m", 2), ("error_max_m", 4), ("foot_m.left", 1), ("payload.mass_kg", 4)):
            self.assertTrue(math.isnan(self.campaign[name][place]), (name, place))
        self.assertIsNone(self.campaign["qp"][4])
        self.assertIsNone(self.campaign["case"][4])

    def test_axes(self):
        self.assertEqual(self.campaign.axes, {"walk.friction": [0.5, 0.8], "scheme": ["ours", "thesis"]})
        (self.out / "summary.json").unlink()
        self.assertEqual(tenon.read(self.out).axes, {})

    def test_groups(self):
        groups = self.campaign.group_by("walk.friction")
        self.assertEqual({value: list(runs["run"]) for value, runs in groups.items()}, {0.5: [0, 1, 5], 0.8: [2, 3]})
        self.assertEqual(list(self.campaign.group_by("walk.friction", "scheme")),
                         [(0.5, "ours"), (0.8, "ours"), (0.8, "thesis"), (0.5, "thesis")])
        self.assertEqual(list(self.campaign.group_by("payload.mass_kg")), [1.5, 2.5, None])
        self.assertEqual(list(self.campaign.where({"walk.friction": 0.5, "finished": True})["run"]), [0, 1])

    def test_quantiles(self):
        for value, expected in zip(self.campaign.quantiles("error_max_m", (0, 0.25, 0.5, 1)), (0.1, 0.15, 0.2, 0.3)):
            self.assertAlmostEqual(value, expected)
        self.assertTrue(math.isnan(self.campaign.where({"run": 5}).quantiles("error_max_m")[1]))
        with self.assertRaisesRegex(ValueError, "'scheme'.*runs.csv"):
            self.campaign.quantiles("scheme")

    def test_numbers_that_were_not_computed(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # a figure without data is no error
            self.campaign.quantiles("error_max_m")
        campaign = tenon.read(self.write_campaign(fixtures.RUNS.replace("true,0.3,", "false,NaN,")))
        self.assertTrue(math.isnan(campaign["error_max_m"][1]))
        with self.assertWarnsRegex(RuntimeWarning, "1 of 5 runs.*'error_max_m' gave NaN"):
            self.assertAlmostEqual(campaign.quantiles("error_max_m")[1], 0.15)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            campaign.where({"scheme": "thesis"}).quantiles("error_max_m")

    def test_table_of_a_spreadsheet(self):
        (self.out / "runs.csv").write_bytes(b"\xef\xbb\xbf" + fixtures.RUNS.replace("\n", "\r\n").encode())
        self.assertEqual(dict(tenon.read(self.out).items())["end_reason"][2], "fell, at 2 s")

    def test_share(self):
        self.assertEqual(self.campaign.share(), wilson(3, 5, 0.9))
        self.assertEqual(self.campaign.share("qp").runs, 4)
        self.assertEqual(self.campaign.group_by("walk.friction")[0.8].share().share, 0.5)
        with self.assertRaisesRegex(ValueError, "'error_max_m'.*runs.csv"):
            self.campaign.share("error_max_m")

    def test_unknown_names(self):
        for use in (self.campaign.__getitem__, self.campaign.group_by, self.campaign.quantiles, self.campaign.share,
                    lambda name: self.campaign.where({name: 1})):
            with self.assertRaisesRegex(tenon.UnknownName, "'walk.fricton'.*runs.csv.*walk.friction"):
                use("walk.fricton")

    def test_incomplete_last_row(self):
        self.assertEqual(list(tenon.read(self.write_campaign(fixtures.RUNS + "6,5,0.8"))["run"]), [0, 1, 2, 3, 5])

    def test_damaged_tables(self):
        wrong_run = fixtures.RUNS.replace("2,1,0.8", "x,1,0.8")
        short_row = fixtures.RUNS.replace("A1,true,0.2", "true,0.2")
        for runs, place in ((wrong_run, ":3: .*'x'"), (short_row, ":5: .*11 cells"), ("time,x\n", ":1"), ("", ":1")):
            with self.subTest(runs), self.assertRaisesRegex(tenon.DataError, "runs.csv" + place):
                tenon.read(self.write_campaign(runs))


class TableWithNumpy(fixtures.WithNumpy, Table, fixtures.OutputTest):

    def test_masks(self):
        self.assertEqual(list(self.campaign["run"][self.campaign["finished"]]), [0, 1, 3])

    @unittest.skipUnless(fixtures.has("pandas"), "pandas is not installed")
    def test_pandas(self):
        self.assertEqual(self.campaign.to_pandas().groupby("scheme")["walk.friction"].mean()["thesis"], 0.65)


class TableWithoutNumpy(fixtures.WithoutNumpy, Table, fixtures.OutputTest):
    pass


class Statistics(unittest.TestCase):

    def test_quantiles_are_those_of_the_standard_library(self):
        source = random.Random(1)
        for count in (2, 3, 10, 37):
            values = [source.gauss(0, 1) for _ in range(count)]
            for ours, theirs in zip(quantiles(values, [k / 8 for k in range(1, 8)]),
                                    statistics.quantiles(values, n=8, method="inclusive")):
                self.assertAlmostEqual(ours, theirs)
        for count in (1, 4):  # exactly, because plots subtract quantiles
            self.assertEqual(quantiles(count * [0.0072], (0, 0.1, 0.7, 1)), 4 * [0.0072])
        for probability in (-0.1, 1.1):
            with self.assertRaises(ValueError):
                quantiles([1.0], (probability,))

    def test_ends_of_the_interval_solve_its_equation(self):
        """Wilson: (share - p)^2 = z^2 p (1 - p) / n at both ends p."""
        z = statistics.NormalDist().inv_cdf(0.975)
        for count, runs in ((0, 4), (4, 4), (29, 29), (3, 10), (900, 1000)):
            share, low, high, _ = wilson(count, runs, 0.95)
            for p in (low, high):
                self.assertAlmostEqual((share - p)**2, z**2 * p * (1 - p) / runs)
            self.assertTrue(0 <= low <= share <= high <= 1)
            self.assertLess(low, high)
        self.assertTrue(math.isnan(wilson(0, 0, 0.95).share))

    def test_units_of_names(self):
        for name, stem, unit in (("com_error_max_m", "com_error_max", "m"), ("torque_max_N_m", "torque_max", "N m"),
                                 ("speed_max_rad_per_s2.left", "speed_max.left", "rad/s^2"),
                                 ("noise_N_per_sqrt_Hz", "noise", "N/√Hz"), ("k_N_per_rad_m", "k", "N/(rad m)"),
                                 ("pd.rate_hz", "pd.rate", "Hz"), ("decay_per_s", "decay", "1/s"),
                                 ("walk.friction", "walk.friction", ""), ("m", "m", ""), ("turn_2", "turn_2", "")):
            self.assertEqual(split_unit(name), (stem, unit))


if __name__ == "__main__":
    unittest.main()
