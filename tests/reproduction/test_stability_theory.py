"""The settling sphere against the theory of once-per-window coupling: growth per window G of every scheme.

lambda = window / tau, tau = rho d^2 / (18 mu). Serial explicit: G = 1 - lambda. Serial implicit, converged: 1/(1 + lambda).
Parallel explicit: z^2 - z + lambda = 0, unstable above 1. Explicit under-relaxation by w, carried from window to window:
unstable above 2(2 - w)/w. Constant relaxation within a window converges for w < 2/(1 + lambda).
Limits are bracketed by two percent where the watch must decide, by five percent in |G| as it promises.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "integration"))

from case import DONE, REFUSED, SPHERE, UNSTABLE, Case, sets, together  # noqa: E402

TAU = 2650 * 1e-4**2 / (18 * 1e-3)  # s


class GrowthTest(Case):
    def settle(self, name, ratio, windows=40, **values):
        """A run of so many windows, each `ratio` relaxation times long."""
        window = ratio * TAU
        return lambda: self.place.sandglass(
            "run", SPHERE, *sets(window=repr(window), end_time=repr(window * windows), **values), out=name)

    def growth(self, run, expected):
        self.assertEqual(run.code, DONE, run.err)
        # FreeFEM's own drag differs from Stokes' by 3.4e-7, and lambda with it.
        self.assertAlmostEqual(run.quantity("growth_per_window"), expected, delta=1e-6)

    def test_serial_explicit(self):
        ratios = (0.1, 0.5, 1.5, 1.95)
        for ratio, run in zip(ratios, together(*(self.settle(f"e{r}", r) for r in ratios))):
            with self.subTest(ratio=ratio):
                self.growth(run, 1 - ratio)

    def test_serial_implicit_is_stable_at_any_window(self):
        ratios = (0.5, 2.0, 4.0, 50.0)
        runs = together(*(self.settle(f"i{r}", r, 8, scheme="serial-implicit", acceleration="aitken") for r in ratios))
        for ratio, run in zip(ratios, runs):
            with self.subTest(ratio=ratio):
                self.growth(run, 1 / (1 + ratio))

    def test_limits(self):
        relaxed = dict(acceleration="constant", relaxation="0.5")  # limit 2(2 - w)/w = 6
        parallel = dict(scheme="parallel-explicit")                # |z|^2 = lambda
        cases = (("serial 2.05", 2.05, {}, UNSTABLE), ("serial 3", 3.0, {}, UNSTABLE),
                 ("parallel 0.9", 0.9, parallel, DONE), ("parallel 1.11", 1.11, parallel, UNSTABLE),
                 ("relaxed 5.6", 5.6, relaxed, DONE), ("relaxed 6.2", 6.2, relaxed, UNSTABLE))
        runs = together(*(self.settle(f"limit{n}", case[1], **case[2]) for n, case in enumerate(cases)))
        for (name, _, _, code), run in zip(cases, runs):
            with self.subTest(name):
                self.assertEqual(run.code, code, run.err)
                if code == UNSTABLE:
                    self.assertRegex(run.err, r"window \d+: field 'velocity' from grains diverges: its change grows [\d.]+ ")

    def test_constant_relaxation_within_a_window(self):
        inside = dict(scheme="serial-implicit", acceleration="constant")  # lambda 4: w < 0.4; 0.35 gains 0.75 times per iteration
        good, bad = together(self.settle("w35", 4.0, 4, relaxation="0.35", **inside),
                             self.settle("w42", 4.0, 4, relaxation="0.42", **inside))
        self.growth(good, 1 / 5)
        self.assertEqual(bad.code, UNSTABLE)
        self.assertIn("did not converge in 100 iterations", bad.err)

    def test_what_cannot_be_iterated_is_refused(self):
        fresh, aitken = together(
            self.settle("fresh", 0.5, 2, scheme="serial-implicit", process="fresh"),
            self.settle("aitken", 0.5, 2, acceleration="aitken"))
        self.assertEqual(fresh.code, REFUSED)
        self.assertIn("is fresh in every window", fresh.err)
        self.assertEqual(aitken.code, REFUSED)
        self.assertIn("Aitken's factor needs iterations within a window", aitken.err)
