"""The analysis interface and the settling sphere's analysis, on records made here (no solver)."""

import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy

from stand_in import PYTHON, render, write

SPHERE = {
    "diameter": 1e-4,
    "density": 2650.0,
    "viscosity": 1e-3,
    "fluid_density": 1000.0,
    "gravity": 9.80665,
    "numerical_damping": 0.0,
    "window": 1e-3,
    "grain_steps": 1,
    "scheme": "serial-explicit",
    "acceleration": "none",
    "relaxation": 0.5,
    "fluid": "axisymmetric",
}


def make_record(path, window, fields, spare_rows=3):
    """A record of as many windows as the fields have rows, with allocated rows beyond that hold nonsense."""
    count = len(next(iter(fields.values())))

    def pad(rows):
        rows = numpy.asarray(rows, dtype=float)
        return numpy.concatenate([rows, numpy.full((spare_rows,) + rows.shape[1:], 1e30)])

    with h5py.File(path, "w") as file:
        file.attrs["filetype"] = numpy.bytes_("sandglass record")  # fixed length, as C++ may write it
        file.attrs["version"] = numpy.array([1, 0])
        file["windows"] = numpy.array([count], dtype=numpy.int64)
        file["time"] = pad([[n * window, (n + 1) * window] for n in range(count)])
        for name, rows in fields.items():
            file["fields/" + name] = pad(numpy.reshape(rows, (count, 1)))
            file["fields/" + name].attrs["unit"] = "1"
        file["iterations"] = numpy.ones(count + spare_rows, dtype=numpy.int64)
        file["counts/grains"] = numpy.arange(count + spare_rows)
        file["timings/grains"] = pad(numpy.full(count, 0.5))


def settle(values, windows, ratio=1.0):
    """The coupled run with a fluid whose drag is `ratio` times Stokes', step by step."""
    volume = math.pi / 6 * values["diameter"] ** 3
    mass = values["density"] * volume
    weight = (values["density"] - values["fluid_density"]) * volume * values["gravity"]
    step = values["window"] / values["grain_steps"]
    rows, v, sent, received = [], 0.0, 0.0, 0.0
    implicit = values["scheme"] == "serial-implicit"
    follow = values["relaxation"] if values["acceleration"] == "constant" else 1.0
    for _ in range(windows):
        coefficient = ratio * 3 * math.pi * values["viscosity"] * values["diameter"]
        if implicit:  # the converged window: the drag is that of the velocity at its end
            v = (v + weight / mass * values["window"]) / (1 + coefficient / mass * values["window"])
            rows.append((v, coefficient * v, (weight - coefficient * v) / mass))
            continue
        drag = coefficient * received
        acting = drag if values["scheme"] == "serial-explicit" else sent
        sent = drag
        for _ in range(values["grain_steps"]):
            a = (weight - acting) / mass
            power = a * (v + a * step / 2)
            a *= 1 - values["numerical_damping"] * (power > 0) + values["numerical_damping"] * (power < 0)
            v += a * step
        received += follow * (v - received)
        rows.append((v, drag, a))
    velocity, drag, acceleration = zip(*rows)
    return {"velocity": velocity, "drag": drag, "acceleration": acceleration}


class AnalysisTest(unittest.TestCase):
    def setUp(self):
        self.place = tempfile.TemporaryDirectory()
        self.addCleanup(self.place.cleanup)
        self.work = os.path.join(self.place.name, "work")
        os.mkdir(self.work)
        self.record = os.path.join(self.place.name, "record.h5")

    def run_script(self, text):
        script = write(os.path.join(self.place.name, "analysis.py"), text)
        environment = dict(os.environ, PYTHONPATH=PYTHON, SANDGLASS_RECORD=self.record)
        return subprocess.run(
            [sys.executable, "-W", "error", script],
            cwd=self.work,
            env=environment,
            capture_output=True,
            text=True,
            timeout=60,
        )

    def result(self):
        def no_constants(name):
            raise AssertionError("%s is not JSON" % name)

        with open(os.path.join(self.work, "analysis.json"), encoding="utf-8") as file:
            return json.load(file, parse_constant=no_constants)


class InterfaceTest(AnalysisTest):
    START = "import sandglass_analysis as sandglass\nrecord = sandglass.open_record()\n"
    CURVE = "sandglass.curve('a', %s, %s, x_unit='s', y_unit='m', label='A', kind='%s')\n"

    def setUp(self):
        super().setUp()
        make_record(self.record, 0.5, {"height": [1.0, 2.0, 4.0]})

    def test_only_complete_windows_are_seen(self):
        done = self.run_script(
            self.START + "sandglass.quantity('all', [record.time, record['height'][:, 0], record.timing('grains'),"
            " record.begin, record.count('grains'), record.iterations], '1')\n"
            "sandglass.quantity('windows', record.windows, '1')\n"
            "sandglass.quantity('unit', None, record.unit('height'), meaning=' '.join(record.names))\n"
            "sandglass.finish()\n"
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        quantities = self.result()["quantities"]
        self.assertEqual(
            quantities["all"]["value"], [[0.5, 1, 1.5], [1, 2, 4], [0.5] * 3, [0, 0.5, 1], [0, 1, 2], [1, 1, 1]]
        )
        self.assertEqual(quantities["windows"]["value"], 3)
        self.assertEqual(quantities["unit"], {"value": None, "unit": "1", "meaning": "height"})

    def test_what_is_written(self):
        done = self.run_script(
            self.START
            + self.CURVE % ("record.time", "record['height'][:, 0] / 3", "computed")
            + "sandglass.quantity('bad', [1, float('nan'), [float('inf')]], 'm')\n"
            "sandglass.figure('f', title='F', panels=[dict(curves=['a'], y_unit='mm', y_scale='log',"
            " marks=[dict(axis='x', value=1, label='one')])])\nsandglass.finish()\n"
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        result = self.result()
        self.assertEqual(result["format"], 1)
        self.assertEqual(result["quantities"]["bad"]["value"], [1, "nan", ["inf"]])
        self.assertEqual(result["curves"]["a"]["y"]["values"], [1 / 3, 2 / 3, 4 / 3])
        panel = result["figures"][0]["panels"][0]
        self.assertEqual((panel["x_label"], panel["x_unit"], panel["y_label"], panel["y_unit"]), ("time", "s", "a", "mm"))
        self.assertEqual((panel["x_scale"], panel["y_scale"]), ("linear", "log"))
        self.assertEqual(panel["marks"], [{"axis": "x", "value": 1.0, "label": "one"}])
        with open(os.path.join(self.work, "a.csv")) as file:
            self.assertEqual(file.read(), "time [s],a [m]\n0.5,%r\n1.0,%r\n1.5,%r\n" % (1 / 3, 2 / 3, 4 / 3))
        self.assertEqual(sorted(os.listdir(self.work)), ["a.csv", "analysis.json"])

    def test_points_that_are_not_finite_are_gaps(self):
        done = self.run_script(
            self.START + self.CURVE % ("[1, 2, 3]", "[1, float('nan'), 3]", "computed") + "sandglass.finish()\n"
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        curve = self.result()["curves"]["a"]
        self.assertEqual((curve["x"]["values"], curve["y"]["values"]), ([1, 2, 3], [1, None, 3]))

    def test_a_script_that_does_not_finish_leaves_nothing(self):
        begin = self.START + self.CURVE % ("[1]", "[2]", "computed")
        for ending in ("raise ValueError('wrong')\n", "1 / 0\nsandglass.finish()\n"):
            done = self.run_script(begin + ending)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn("line", done.stderr)
            self.assertEqual(os.listdir(self.work), [])

    def test_mistakes_are_refused(self):
        for text, message in (
            (self.CURVE % ("[1]", "[1, 2]", "computed"), "two equal lists"),
            (self.CURVE % ("[1]", "[1]", "guessed"), "kind 'guessed'"),
            (2 * (self.CURVE % ("[1]", "[1]", "computed")), "defined twice"),
            ("sandglass.quantity('../a', 1, 'm')\n", "letters, digits and underscores"),
            ("sandglass.figure('f', 'F', [dict(curves=['a'])])\n", "no curve 'a'"),
            ("record['hight']\n", "it has: height"),
        ):
            with self.subTest(message):
                done = self.run_script(self.START + text + "sandglass.finish()\n")
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(message, done.stderr)
                self.assertEqual(os.listdir(self.work), [])


class SettlingSphereTest(AnalysisTest):
    def analyse(self, windows, ratio=1.0, fields=None, **changes):
        values = dict(SPHERE, **changes)
        make_record(self.record, values["window"], fields or settle(values, windows, ratio))
        done = self.run_script(render("analysis/settling_sphere.py", values))
        self.assertEqual(done.returncode, 0, done.stderr)
        result = self.result()
        return {name: entry["value"] for name, entry in result["quantities"].items()}, result

    def test_the_scheme_is_solved_exactly(self):
        # Against our own step-by-step recursion; every case has another path through the damping rule.
        for changes in (
            {},
            {"density": 500.0},
            {"numerical_damping": 0.509},
            {"numerical_damping": 0.3, "window": 2.3e-3, "grain_steps": 7},
            {"scheme": "parallel-explicit", "window": 5e-4},
            {"scheme": "parallel-explicit", "window": 1.2e-3, "grain_steps": 7, "numerical_damping": 0.3},
            {"diameter": 1e-6, "window": 1e-9},
            {"scheme": "serial-implicit", "window": 6e-3},
            {"acceleration": "constant", "window": 3e-3},
            {"acceleration": "constant", "relaxation": 0.8, "scheme": "parallel-explicit", "window": 7e-4},
        ):
            with self.subTest(**changes):
                values, _ = self.analyse(40, **changes)
                terminal = abs(values["stokes_terminal_velocity"])
                self.assertLess(values["velocity_difference_scheme_max"], 1e-13 * terminal)
                self.assertLess(values["velocity_difference_scheme_own_drag_max"], 1e-13 * terminal)
                self.assertLess(values["drag_relative_error"], 1e-14)
                self.assertAlmostEqual(
                    values["velocity_difference_exponential_max"], values["scheme_time_error_max"], delta=1e-13 * terminal
                )

    def test_the_time_error_is_that_of_the_theory(self):
        values, _ = self.analyse(30)
        lam = SPHERE["window"] / values["relaxation_time"]
        theory = max(abs((1 - lam) ** n - math.exp(-n * lam)) for n in range(1, 31)) * values["stokes_terminal_velocity"]
        self.assertAlmostEqual(values["scheme_time_error_max"], theory, delta=1e-15)
        self.assertAlmostEqual(values["growth_per_window"], 1 - lam, delta=1e-9)

    def test_a_fluid_that_is_wrong_by_a_little_is_seen(self):
        values, _ = self.analyse(30, ratio=1.0037)
        self.assertAlmostEqual(values["drag_relative_error"], 0.0037, delta=1e-12)
        self.assertGreater(values["velocity_difference_scheme_max"], 1e-5)
        self.assertLess(values["velocity_difference_scheme_own_drag_max"], 1e-15)

    def test_a_grain_solver_that_is_wrong_by_a_little_is_seen(self):
        fields = settle(SPHERE, 30)
        fields["velocity"] = [v * (1 + 1e-6) for v in fields["velocity"]]
        values, _ = self.analyse(30, fields=fields)
        self.assertGreater(values["velocity_difference_scheme_own_drag_max"], 1e-10)

    def test_published_values_are_shown_for_the_papers_sphere_only(self):
        for changes, shown in (({}, True), ({"density": 2500.0}, True), ({"density": 2600.0}, False),
                               ({"viscosity": 2e-3}, False), ({"diameter": 2e-4}, False)):
            with self.subTest(**changes):
                _, result = self.analyse(30, **changes)
                published = [name for name, curve in result["curves"].items() if curve["kind"] == "published"]
                self.assertEqual(bool(published), shown)
                other = {"stokes_velocity_2650", "stokes_velocity_2500"} & set(result["curves"])
                self.assertEqual(len(other), int(shown))
                self.assertEqual("contradicts itself" in result["figures"][0]["caption"], shown)

    def test_what_is_not_defined_is_null(self):
        values, result = self.analyse(1)
        self.assertIsNone(values["drag_relative_error"])
        self.assertIsNone(values["growth_per_window"])
        values, result = self.analyse(10, density=1000.0)  # floats: nothing moves
        self.assertIsNone(values["drag_relative_error"])
        self.assertEqual(values["velocity_difference_scheme_max"], 0)
        self.assertEqual([figure["name"] for figure in result["figures"]], ["figure_2"])

    def test_an_unstable_run_is_reported_not_hidden(self):
        values, _ = self.analyse(30, window=3.5e-3)
        self.assertAlmostEqual(values["growth_per_window"], values["growth_per_window_theory"], delta=1e-9)
        self.assertLess(values["growth_per_window"], -1)
        values, _ = self.analyse(4000, window=3.5e-3)  # beyond the largest number
        for name in ("terminal_velocity", "velocity_difference_exponential_max"):
            self.assertIn(values[name], ("nan", "inf", "-inf"))  # so that its comparison fails

    def test_long_runs_are_drawn_with_fewer_points(self):
        _, result = self.analyse(5000, window=1e-6)
        self.assertLessEqual(len(result["curves"]["velocity"]["x"]["values"]), 2001)
        self.assertEqual(result["curves"]["velocity"]["x"]["values"][-1], 5e-3)


if __name__ == "__main__":
    unittest.main()
