"""Tests of the plots, which need matplotlib."""
import os
import sys
import unittest
from unittest import mock

import fixtures
import tenon

os.environ["MPLBACKEND"] = "Agg"


@unittest.skipUnless(fixtures.has("matplotlib"), "matplotlib is not installed")
class Plots(fixtures.OutputTest):

    def setUp(self):
        super().setUp()
        from matplotlib import pyplot
        self.addCleanup(pyplot.close, "all")

    def test_signals_have_one_plot_for_each_unit(self):
        run = tenon.Run(self.write_run())
        force, acceleration = run.plot("loop.pd.force", "loop.cart.state.a").axes
        self.assertEqual((force.get_ylabel(), acceleration.get_ylabel()), ("force [N]", "state.a [m/s$^{2}$]"))
        self.assertEqual((force.get_xlabel(), acceleration.get_xlabel()), ("", "time [s]"))
        self.assertEqual([line.get_label() for line in force.lines], ["x", "y"])
        self.assertEqual(list(force.lines[0].get_xdata()), [0, 0.1, 0.2])
        self.assertEqual(list(force.lines[1].get_ydata()), [2, -0.004, 6])

    def test_runs_share_axes(self):
        run = tenon.Run(self.write_run())
        figure = run.plot("loop.pd.force.x", label="pd")
        self.assertIs(run.plot("loop.pd.force.x", axes=figure.axes[0], label="mpc"), figure)
        self.assertEqual([text.get_text() for text in figure.axes[0].get_legend().get_texts()], ["pd: x", "mpc: x"])
        with self.assertRaisesRegex(ValueError, r"N, m/s\^2"):
            run.plot("loop.pd.force", "loop.cart.state.a", axes=figure.axes[0])

    def test_wrong_names(self):
        run = tenon.Run(self.write_run())
        with self.assertRaises(tenon.UnknownName):
            run.plot("loop.pd.forc")
        with self.assertRaisesRegex(ValueError, str(self.out)):
            run.plot()

    def test_files(self):
        from matplotlib import pyplot
        run = tenon.Run(self.write_run())
        for name, begin in (("a.svg", b"<?xml"), ("a.pdf", b"%PDF")):
            run.plot("loop.pd.force", save=self.out / name)
            self.assertTrue((self.out / name).read_bytes().startswith(begin))
        self.assertEqual(pyplot.get_fignums(), [])

    def test_a_notebook_shows_one_picture(self):
        from matplotlib import pyplot
        run = tenon.Run(self.write_run())
        with mock.patch("matplotlib.get_backend", return_value="module://matplotlib_inline.backend_inline"):
            figure = run.plot("loop.pd.force.x")
            self.assertEqual(pyplot.get_fignums(), [], "the open figure would be shown beside the value of the cell")
            self.assertIs(run.plot("loop.pd.force.y", axes=figure.axes[0]), figure)
            own = pyplot.subplots()[1]
            run.plot("loop.pd.force.x", axes=own)
            self.assertEqual(len(pyplot.get_fignums()), 1, "figures of others stay open")

    def test_quantiles_over_an_axis(self):
        (axes,) = tenon.read(self.write_campaign()).plot("walk.friction", "error_max_m", by="scheme").axes
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), ("walk.friction", "error_max [m]"))
        ours, thesis = axes.lines
        self.assertEqual(ours.get_label(), "scheme = ours")
        self.assertEqual((list(ours.get_xdata()), list(ours.get_ydata())), ([0.5], [0.2]))
        self.assertEqual((list(thesis.get_xdata()), list(thesis.get_ydata())), ([0.8], [0.2]))
        band = axes.collections[0].get_paths()[0].get_extents()
        self.assertAlmostEqual(band.ymin, 0.12)
        self.assertAlmostEqual(band.ymax, 0.28)

    def test_share_over_an_axis(self):
        campaign = tenon.read(self.write_campaign())
        (axes,) = campaign.plot("walk.friction", "finished").axes
        self.assertEqual(list(axes.lines[0].get_ydata()), [2 / 3, 1 / 2])
        band = axes.collections[0].get_paths()[0].get_extents()
        self.assertAlmostEqual(band.ymin, campaign.group_by("walk.friction")[0.8].share().low)

    def test_bars_over_texts(self):
        (axes,) = tenon.read(self.write_campaign()).plot("scheme", "finished").axes
        self.assertEqual([text.get_text() for text in axes.get_xticklabels()], ["ours", "thesis"])
        self.assertEqual(list(axes.lines[0].get_ydata()), [2 / 3, 1 / 2])

    def test_dots_and_crosses(self):
        (axes,) = tenon.read(self.write_campaign()).plot("payload.mass_kg", "foot_m.left").axes
        dots, crosses = axes.lines
        self.assertEqual((list(dots.get_xdata())[0], list(crosses.get_ydata())[0]), (1.5, 2))
        self.assertEqual((dots.get_marker(), crosses.get_marker()), ("o", "x"))
        self.assertEqual(dots.get_color(), crosses.get_color())


class WithoutMatplotlib(fixtures.OutputTest):

    def test_names_the_package(self):
        run = tenon.Run(self.write_run())
        with mock.patch.dict(sys.modules, {"matplotlib": None}):
            with self.assertRaisesRegex(ImportError, "python3-matplotlib"):
                run.plot("time")


if __name__ == "__main__":
    unittest.main()
