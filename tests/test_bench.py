"""Parts of cpinn-bench: names and definitions, medians over seeds of curves known by hand, curves of
others from files. Values are powers of two or copied, so that comparisons are exact where no tolerance
is given.
    test_bench.py BIN     in a folder that is empty
"""
import contextlib
import importlib.machinery
import importlib.util
import io
import math
import subprocess
import sys
import types
import unittest

PATH = sys.argv.pop(1) + "/cpinn-bench"
spec = importlib.util.spec_from_loader("bench", importlib.machinery.SourceFileLoader("bench", PATH))
bench = importlib.util.module_from_spec(spec)
sys.dont_write_bytecode = True
spec.loader.exec_module(bench)
USUAL = bench.usual_stages()


def example():
    """Three seeds of one cell, of which one rises again and one never comes far; a cell in which two
    of three seeds failed, one of them before its first row."""
    a, b, c = ([0.5, 2**-7, 2**-10, 1e-4], [0.25, 0.0625, 0.125, 0.03125], [1, 0.125, 5e-4, 1e-3])

    def run(errors, outcome="solved"):
        rows = [{"seconds": t, "step": i + 1, "loss": 1, "held_out": 2, "position": e, "tip": 2 * e,
                 "rotation": math.nan} for i, (t, e) in enumerate(zip((1, 2, 4, 8), errors))]
        return {"seed": 0, "rows": rows, "seconds": rows[-1]["seconds"] if rows else 0,
                "steps": 10 * len(rows), "outcome": outcome, "reason": "none", "findings": []}

    def cell(method, runs):
        return types.SimpleNamespace(scene="rod", method=method, network="2x8", form="", runs=runs,
                                     parameters=0, estimate=None)
    return [cell("good", [run(a), run(b), run(c)]),
            cell("bad", [run(c), run(a[:2], "stopped"), run([], "stopped")])]


class Test(unittest.TestCase):
    def refused(self, what, *arguments, pattern):
        text = io.StringIO()
        with contextlib.redirect_stderr(text), self.assertRaises(SystemExit) as end:
            what(*arguments)
        self.assertEqual(end.exception.code, 2)
        self.assertIn(pattern, text.getvalue())

    def test_methods(self):
        methods = bench.methods_of("lbfgs,config,fast=adam:20+gauss_newton:6,adam:7", USUAL)
        self.assertEqual(list(methods), ["lbfgs", "config", "fast", "adam:7"])
        self.assertEqual(methods["lbfgs"][1], "training.stages=[{optimizer: adam, steps: 300}, "
                                              "{optimizer: lbfgs, steps: 1000000000}]")
        self.assertEqual(methods["config"], ("", ""))
        self.assertEqual(methods["fast"][1], "training.stages=[{optimizer: adam, steps: 20}, "
                                             "{optimizer: gauss_newton, steps: 6}]")
        for text, pattern in {
                "newton": "there is no such method; allowed: config,solver,adam,lbfgs,",
                "a=adm:3": "'adm' is not an optimiser; allowed: adam, lbfgs,",
                "a=adam:0": "'adam:0' is not a stage", "a=adam:3x": "'adam:3x' is not a stage",
                "a=adam:": "'adam:' is not a stage", "a=adam:" + 20 * "9": "is not a stage",
                "a=adam:3+": "'' is not an optimiser", "adam,": "allowed: names and stages",
                "=adam:3": "allowed: names and stages",
                "adam,adam=lbfgs:3": "adam is there twice"}.items():
            self.refused(bench.methods_of, text, USUAL, pattern=pattern)

    def test_methods_are_configs(self):
        """cpinn-train reads every method of the table, whose stages replace those of the file with all
        of their settings."""
        with open("rod.yaml", "w") as file:
            file.write("rod: {length: 2, stiffness: {bending: [1, 1], torsion: 1, shear: [100, 100], "
                       "axial: 100}}\ntraining: {stages: [{optimizer: adam, learning_rate: 0.5}]}\n")
        methods = bench.methods_of(None, USUAL)
        self.assertEqual(len(methods), 5)
        for stages, override in methods.values():
            text = subprocess.run([bench.place_of("cpinn-train"), "rod.yaml", "--print-config", "--set",
                                   override], stdout=subprocess.PIPE, text=True, check=True).stdout
            self.assertIn(f"optimizer: {stages.split(':')[0]}\n", text)
            self.assertNotIn("learning_rate: 0.5", text)

    def test_networks(self):
        self.assertEqual(bench.networks_of("2x16,f64,1x32+f8"), {
            "2x16": ["network.hidden=[16, 16]"],
            "f64": ["network.hidden=[]", "network.fourier.features=64"],
            "1x32+f8": ["network.hidden=[32]", "network.fourier.features=8"]})
        self.assertEqual(bench.networks_of(None), {"": []})
        for wrong in ["f", "f0", "2x8f3", "2x8+", "f2000", "f3+2x8", "2x8+f", "2", "x16", "2x", "0x16",
                      "2x0", "2x16x3", "-1x4", "2,3", "2x5000", "2x16,2x16", "999x2", "", "2x16,"]:
            self.refused(bench.networks_of, wrong, pattern="--networks")
        for layers, features, degree, name in [
                ([20] * 3, 0, 0, "3x20"), ([20, 8, 20], 0, 0, "20-8-20"), ([20, 8, 20], 7, 0, "20-8-20+f7"),
                ([], 7, 0, "f7"), ([], 0, 20, "p20")]:
            self.assertEqual(bench.network_name(layers, features, degree), name)
        for given, name in {"a,b'c": "a_b_c", "": "_", ".x": "_x", "x ": "x_"}.items():
            self.assertEqual(bench.safe(given), name)

    def test_spread(self):
        inf = math.inf
        self.assertEqual(bench.spread([8, 1, 4]), (4, 1, 8))
        self.assertEqual(bench.spread([8, 1, 4, 2])[0], 3)
        self.assertEqual(bench.spread([inf, 2, 4]), (4, 2, inf))
        self.assertEqual(bench.spread([inf, 2, inf, inf])[0], inf)
        self.assertEqual(bench.spread([inf, 2])[0], inf)
        self.assertTrue(math.isnan(bench.spread([])[0]))

    def test_rows(self):
        b = example()[0].runs[1]
        self.assertEqual(bench.best(b, "position", 0.999), math.inf)
        self.assertEqual([bench.best(b, "position", t) for t in (1, 3.9, 4)], [0.25, 0.0625, 0.0625])
        self.assertEqual(bench.best(b, "tip", 1e9), 0.0625)
        self.assertEqual(bench.best(b, "rotation", 1e9), math.inf)  # never known
        self.assertEqual(bench.reached(b, "position", 0.0625), 2)
        self.assertEqual(bench.reached(b, "position", 0.01), math.inf)

    def test_summary(self):
        good, bad = (bench.summarize(cell, "position") for cell in example())
        self.assertEqual([good[k] for k in ("seeds", "failed", "error_median", "error_low", "error_high")],
                         [3, 0, 0.001, 0.0001, 0.03125])
        self.assertEqual(good["seconds_to_1e-2"], 4)  # after 2, 4 and never
        self.assertEqual(good["seconds_to_1e-3"], 4)  # after 4, 4 and never
        self.assertEqual(good["seconds_to_1e-4"], math.inf)  # one of three
        self.assertEqual((good["seconds"], good["steps_per_second"]), (8, 3 / 7))
        self.assertEqual((bad["seeds"], bad["failed"]), (3, 2))
        self.assertEqual((bad["error_median"], bad["error_low"]), (math.inf, 0.001))
        self.assertEqual(bad["seconds_to_1e-2"], 4)  # after 4, after 2 before it failed, never

    def test_estimates(self):
        """Errors below that of the reference itself are told to be so."""
        cells = example()
        for estimate, is_told in (None, False), (0.9e-4, False), (1.1e-4, True):
            cells[0].estimate = estimate  # the smallest error at its end is 1e-4
            text = io.StringIO()
            with contextlib.redirect_stdout(text):
                bench.print_tables(cells, types.SimpleNamespace(error="position"))
            self.assertEqual("the reference itself is off by an estimated 1.1e-04" in text.getvalue(),
                             is_told)

    def test_band(self):
        cells = example()
        band = bench.band(cells[0], cells, "position")
        self.assertEqual((len(band), band[0][0], band[-1][0]), (bench.GRID, 1, 8))
        for before, (t, median, _, high) in zip([None, *band], band):
            self.assertEqual(median, 0.5 if t < 2 else 0.0625 if t < 4 else 2**-10 if t < 8 else 5e-4)
            self.assertEqual(high, 1 if t < 2 else 0.125 if t < 4 else 0.0625 if t < 8 else 0.03125)
            if before:  # equal on a logarithmic axis, to rounding
                self.assertAlmostEqual(t / before[0], 8 ** (1 / (bench.GRID - 1)), delta=1e-12)
        # Two of three seeds have a first row: a median, but no largest.
        first = bench.band(cells[1], cells, "position")[0]
        self.assertEqual((first[1], first[3]), (1, math.inf))
        cells[0].runs = cells[1].runs = []
        self.assertEqual(bench.band(cells[0], cells, "position"), [])

    def curves(self, text, given="c.csv", into=None):
        with open("c.csv", "w") as file:
            file.write(text)
        into = {} if into is None else into
        bench.read_curves(into, given)
        return into

    def test_curves(self):
        named = "# made by hand\nname,seconds,error\nb,1,0.5\n\na x,4,2\n# more\nb,2,0.25\n"
        curves = self.curves(named)
        self.assertEqual(curves, {"b": [(1, 0.5), (2, 0.25)], "a x": [(4, 2)]})
        self.refused(self.curves, named, "c.csv", curves, pattern="two curves are called b")
        self.refused(self.curves, named, "n=c.csv", pattern="names its curves in a column")
        self.assertEqual(self.curves("error,seconds\n1,2\n", "n=c.csv"), {"n": [(2, 1)]})
        self.assertEqual(self.curves("error,seconds\n1,2\n"), {"c": [(2, 1)]})
        for given in "n=", "=c.csv", "none.csv":
            self.refused(bench.read_curves, {}, given, pattern=given)
        for text, pattern in {
                "seconds,error\n1,1\n\n2,x\n": "c.csv:4: error: 'x': the field is not a number",
                "seconds,error\n1,1\n# no\n0,1\n": "c.csv:4: seconds is 0; allowed: > 0",
                "seconds,error\n1,-1\n": "c.csv:2: error is -1; allowed: > 0",
                "seconds,error\n1,inf\n": "c.csv:2: error is inf; allowed: > 0 and finite",
                "seconds,error\n1\n": "c.csv:2: error: '': the field is not a number",
                "seconds,eror\n1,1\n": "column 'error' is missing",
                "seconds,error\n": "there are no rows"}.items():
            self.refused(self.curves, text, pattern=pattern)


unittest.main()
