"""Tests of tenon.Run, tenon.Comparison and tenon.read."""
import array
import math
import unittest

import fixtures
import tenon


class Results:
    """The tests, which hold with and without NumPy."""

    def test_figures(self):
        run = tenon.read(self.write_run())
        self.assertTrue(run.finished)
        self.assertIsNone(run.exit_code)
        self.assertEqual(run.figures["foot_error_max_m"]["right"], 0.002)
        self.assertIsNone(run.figures["loaded_m"])
        self.assertFalse(tenon.read(self.write_run(summary={"finished": False})).finished)

    def test_columns_and_units(self):
        run = tenon.Run(self.write_run())
        self.assertEqual(list(run["time"]), [0, 0.1, 0.2])
        self.assertEqual(list(run["loop.pd.force.y"]), [2, -0.004, 6])
        self.assertTrue(math.isnan(run["loop.cart.state.a"][1]))
        self.assertEqual(list(run.units.values()), ["s", "N", "N", "", "m/s^2"])
        self.assertEqual(len(run), 5)
        self.assertIn("loop.pd.forced", run)

    def test_a_vector_is_its_elements_only(self):
        run = tenon.Run(self.write_run())
        self.assertEqual(run.elements("loop.pd.force"), ["loop.pd.force.x", "loop.pd.force.y"])
        x, y = run["loop.pd.force"]
        self.assertEqual((list(x), list(y)), ([1, 3, 5], [2, -0.004, 6]))
        (only,) = run["loop.cart.state"]
        self.assertEqual(only[2], -1.5)

    def test_equality_is_identity(self):
        run, again = tenon.Run(self.write_run()), tenon.Run(self.out)
        self.assertTrue(run == run and run != again)
        self.assertEqual({run: 1, again: 2}[run], 1)

    def test_unknown_names(self):
        run = tenon.Run(self.write_run())
        self.assertNotIn("loop.pd.forc", run)
        with self.assertRaisesRegex(tenon.UnknownName, "'loop.pd.forc'.*signals.csv.*loop.pd.forced"):
            run["loop.pd.forc"]
        with self.assertRaises(KeyError):
            run["nothing"]

    def test_incomplete_last_row(self):
        self.assertEqual(list(tenon.Run(self.write_run(signals=SIGNALS + "0.3,1,2"))["time"]), [0, 0.1, 0.2])

    def test_no_rows(self):
        run = tenon.Run(self.write_run(signals=SIGNALS.split("\n")[0] + "\n"))
        self.assertEqual([len(column) for column in run["loop.pd.force"]], [0, 0])

    def test_damaged_files(self):
        for signals, place in ((SIGNALS.replace("3,", "x,"), r"signals.csv:3"), (SIGNALS.replace(",7,0.5", ",7"), ":2"),
                               ("", ":1"), ("run,seed\n", ":1")):
            with self.subTest(signals), self.assertRaisesRegex(tenon.DataError, place):
                tenon.Run(self.write_run(signals=signals))["time"]
        run = tenon.Run(self.out)
        (self.out / "signals.csv").unlink()
        with self.assertRaisesRegex(tenon.DataError, "signals.csv"):
            run["time"]
        for text in ("{", "[1]"):
            (self.out / "summary.json").write_text(text)
            with self.assertRaisesRegex(tenon.DataError, "summary.json"):
                tenon.read(self.out)
        with self.assertRaisesRegex(tenon.DataError, "nowhere"):
            tenon.read(self.out / "nowhere")

    def test_comparison(self):
        figures = {"pd": fixtures.SUMMARY, "mpc": {"finished": False}}
        for name, summary in figures.items():
            self.write_run(name, summary)
        self.write_run(summary=figures)
        comparison = tenon.read(self.out)
        self.assertTrue(comparison != tenon.read(self.out) and comparison in {comparison})
        self.assertEqual(list(comparison), ["pd", "mpc"])
        self.assertFalse(comparison.finished)
        self.assertEqual(comparison["pd"]["loop.pd.force.x"][2], 5)
        self.assertEqual(comparison.figures["pd"]["com_error_max_m"], 0.002)
        with self.assertRaisesRegex(tenon.UnknownName, "'mcp'.*mpc"):
            comparison["mcp"]


SIGNALS = fixtures.SIGNALS


class ResultsWithNumpy(fixtures.WithNumpy, Results, fixtures.OutputTest):

    def test_shapes(self):
        run = tenon.Run(self.write_run())
        self.assertEqual(run["loop.pd.force"].shape, (2, 3))
        self.assertEqual(run["time"].dtype, float)

    @unittest.skipUnless(fixtures.has("pandas"), "pandas is not installed")
    def test_pandas(self):
        frame = tenon.Run(self.write_run()).to_pandas()
        self.assertEqual(frame["loop.pd.force.x"][0.2], 5)
        self.assertEqual(frame.attrs["units"]["loop.pd.force.x"], "N")


class ResultsWithoutNumpy(fixtures.WithoutNumpy, Results, fixtures.OutputTest):

    def test_types(self):
        run = tenon.Run(self.write_run())
        self.assertIsInstance(run["time"], array.array)
        self.assertIsInstance(run["loop.pd.force"], list)


if __name__ == "__main__":
    unittest.main()
