"""Leaving out what a scene does not need: results are the same without it, products are kept between runs, and plan knows."""

import functools
import json
import os
import unittest

import h5py

from case import DONE, SPHERE, USAGE, Case, change, copy_of_home, read, sets, together, write

# A box of few elements: what is looked at here is not its drag.
BOX = dict(fluid="box", box_width="2 mm", element_size_ratio=0.3, element_growth=2)
LEFT_OUT = ("unit_answer", "repeated_solve", "contact_detection", "position")


def datasets(path):
    """Every dataset of a record but the timings, as bytes."""
    found = {}

    def look(name, item):
        if isinstance(item, h5py.Dataset) and not name.startswith("timings/"):
            found[name] = (str(item.dtype), item.shape, item[...].tobytes())

    with h5py.File(path, "r") as file:
        file.visititems(look)
    return found


def load(path):
    return json.loads(read(path))


class NothingChanges(Case):
    """The same bytes in every dataset, whatever is left out: what is done less often gives the same numbers, not close ones."""

    SCENES = {
        # 60 windows: from the 40th or so on the sphere falls at the same speed to the last bit, and repeated_solve acts.
        "axisymmetric": dict(end_time="60 ms"),
        "axisymmetric implicit": dict(end_time="10 ms", scheme="serial-implicit", acceleration="aitken"),
        "box": dict(end_time="6 ms", **BOX),
        "box implicit": dict(end_time="3 ms", scheme="serial-implicit", acceleration="aitken", **BOX),
    }

    def test_all_and_by_name(self):
        calls = {}
        for scene, parameters in self.SCENES.items():
            words = ["run", SPHERE, *sets(**parameters)]
            calls[scene, "nothing"] = words
            calls[scene, "all"] = [*words, "--no-prune"]
            if scene in ("axisymmetric", "box implicit"):
                for name in LEFT_OUT:
                    calls[scene, name] = [*words, "--no-prune", name]
        ended = dict(zip(calls, together(*[functools.partial(self.sandglass, *words, out="-".join(key).replace(" ", "_"), seconds=600)
                                           for key, words in calls.items()])))
        for (scene, name), one in ended.items():
            with self.subTest(scene, put_back=name):
                pruned = ended[scene, "nothing"]
                self.assert_code(one, DONE)
                self.assertEqual(datasets(one.path("record.h5")), datasets(pruned.path("record.h5")))
                self.assertEqual(one.result["quantities"], pruned.result["quantities"])
                left_out = {item["name"] for item in one.result["left_out"]}
                self.assertEqual(left_out, set(LEFT_OUT) - (set(LEFT_OUT) if name == "all" else {name}))


SCENE = """\
sandglass: 1
name: kept
parameters:
  length: {value: 3, type: count}
stages:
  make: {run: python, template: python/make.py, given: [length], makes: [product.txt], reuse: true}
  show: {run: python, template: python/show.py, given: [{product: {file: make/product.txt}}], analysis: true}
"""
MAKE = """\
import time, uuid
time.sleep(0.3)  # what taking it over saves
open('product.txt', 'w').write('%d %s' % ({{length}}, uuid.uuid4()))
"""
SHOW = """\
import sandglass_analysis as sandglass
sandglass.quantity('length', float(open({{product}}).read().split()[0]), '1', 'as it was made')
sandglass.finish()
"""
STUDY = """\
sandglass: 1
name: kept_study
study:
  of: kept.yaml
  points: [{grid: {length: [5, 6]}}]
  work_precision: [{error: length, seconds: [make]}]
"""


class KeptProducts(Case):
    """A stage with `reuse: true`: every product has a random number in it, so whether it was made anew shows."""

    def setUp(self):
        name = self.id().rsplit(".", 1)[1]
        self.kept = self.place.join(name, "kept")
        os.makedirs(self.kept)
        self.home = copy_of_home(self.place, os.path.join(name, "home"))
        write(os.path.join(self.home, "templates", "python", "make.py"), MAKE)
        write(os.path.join(self.home, "templates", "python", "show.py"), SHOW)
        self.name, self.count = name, 0
        self.file = self.place.write(os.path.join(name, "kept.yaml"), SCENE)

    def product(self, *words):
        """Runs the scene; what the stage's product holds, whether it was taken over, and the run."""
        self.count += 1
        ended = self.call("run", self.file, *words, out=os.path.join(self.name, "run%d" % self.count))
        taken = [item for item in ended.result["left_out"] if item["name"] == "make"]
        self.assertEqual(bool(taken), "make" in load(ended.path("provenance.json"))["timings"]["made_before"])
        return read(ended.path("stages", "make", "product.txt")), bool(taken), ended

    def call(self, *words, code=DONE, **options):
        ended = self.sandglass(*words, home=self.home, environment={"SANDGLASS_KEPT": self.kept}, **options)
        self.assert_code(ended, code)
        return ended

    def test_the_second_run_takes_it(self):
        first, taken, _ = self.product()
        self.assertFalse(taken)
        second, taken, ended = self.product()
        self.assertTrue(taken)
        self.assertEqual(second, first)
        saving = [item for item in ended.result["left_out"] if item["name"] == "make"][0]
        self.assertGreater(saving["saving_s"], 0.3, "the seconds are those of making it")
        self.assert_code(self.sandglass("verify", ended.directory, home=self.home), DONE)

    def test_another_parameter_or_template_makes_it_anew(self):
        first, _, _ = self.product()
        other, taken, _ = self.product("--set", "length=4")
        self.assertFalse(taken)
        self.assertTrue(other.startswith("4 "))
        change(os.path.join(self.home, "templates", "python", "make.py"), ("import time, uuid", "import uuid, time"))
        changed, taken, _ = self.product()
        self.assertFalse(taken)
        self.assertNotEqual(changed, first)
        # Both are kept beside each other.
        write(os.path.join(self.home, "templates", "python", "make.py"), MAKE)
        self.assertEqual(self.product()[:2], (first, True))

    def test_a_damaged_one_is_made_anew_and_kept_again(self):
        first, _, _ = self.product()
        folder = os.path.join(self.kept, os.listdir(self.kept)[0])
        write(os.path.join(folder, "product.txt"), "3 of somebody else")
        second, taken, _ = self.product()
        self.assertFalse(taken)
        self.assertNotIn(second, (first, "3 of somebody else"))
        self.assertEqual(self.product()[:2], (second, True))
        for damage in (lambda: os.remove(os.path.join(folder, "product.txt")),
                       lambda: write(os.path.join(folder, "made.json"), "{")):
            damage()
            self.assertFalse(self.product()[1])

    def test_put_back_it_is_made_anew(self):
        first, _, _ = self.product()
        for words in (("--no-prune",), ("--no-prune", "make")):
            again, taken, _ = self.product(*words)
            self.assertFalse(taken)
            self.assertNotEqual(again, first)
        self.assert_said(self.call("run", self.file, "--no-prune", "show", code=USAGE), "nothing called 'show' can be left out")

    def test_where_nothing_can_be_kept_the_run_goes_on(self):
        self.kept = write(self.place.join(self.name, "a file"), "")
        self.assertFalse(self.product()[1])
        self.assertFalse(self.product()[1])

    def test_diagrams_of_run_time_count_what_making_it_took(self):
        """Points 5 and 6 were made before; otherwise they would seem to have cost nothing."""
        for length in (5, 6):
            self.product("--set", "length=%d" % length)
        study = self.place.write(os.path.join(self.name, "study.yaml"), STUDY)
        self.call("study", study, out=os.path.join(self.name, "study"))
        points = load(self.place.join(self.name, "study", "summary", "points.json"))["points"]
        self.assertEqual(len(points), 2)
        for point in points:
            self.assertGreater(point["seconds"]["make"], 0.3)
            self.assertGreater(point["seconds"]["run"], point["seconds"]["make"])
            timings = load(self.place.join(self.name, "study", "points", point["name"], "provenance.json"))["timings"]
            self.assertLess(timings["stages"]["make"], timings["made_before"]["make"])


class Plan(Case):
    """Savings are those of earlier runs, and said to be unknown where there are none."""

    def line(self, name, *words):
        ended = self.sandglass("plan", *words)
        self.assert_code(ended, DONE)
        return [line for line in ended.out.splitlines() if line.startswith("  %s: " % name)][0]

    def test_before_and_after_runs(self):
        scene = [SPHERE, *sets(end_time="5 ms")]
        for name in ("unit_answer", "repeated_solve", "contact_detection"):
            self.assertIn("saving unknown", self.line(name, *scene))
        self.assertIn("nobody receives or records it", self.line("field position", *scene))
        self.assert_code(self.sandglass("run", *scene), DONE)  # below runs/ of this place
        self.assertRegex(self.line("unit_answer", *scene), r"saved [\d.e-]+ s in the newest run")
        self.assertIn("saving unknown", self.line("contact_detection", *scene), "nobody measures it by itself")
        self.assert_code(self.sandglass("run", *scene, "--no-prune", "contact_detection"), DONE)
        self.assertRegex(self.line("contact_detection", *scene),
                         r"saves -?[\d.e+-]+ us of [\d.e+-]+ us of the solvers' work per window \(1 runs without, 1 with\)")
        self.assertIn("put back by --no-prune", self.line("unit_answer", *scene, "--no-prune"))
        self.assertIn("saving unknown", self.line("unit_answer", *scene, "--set", "density=2500 kg/m3"), "of another scene")

    def test_a_study(self):
        study = self.place.write("study.yaml", """\
sandglass: 1
name: planned
study:
  of: %s
  set: {end_time: 3 ms}
  points: [{grid: {density: [2500 kg/m3, 2650 kg/m3], fluid: [axisymmetric, navier_stokes]}}]
""" % SPHERE)
        ended = self.sandglass("plan", study)
        self.assert_code(ended, DONE)
        self.assertIn("Study of 4 points: 4 would be run, 0 there already and good", ended.out)
        self.assertEqual(ended.out.count(": was never run"), 4)
        self.assertRegex(ended.out, r"unit_answer: .* in 2 points, saving unknown")
        self.assertFalse(os.path.exists(self.place.join("runs", "planned", "points")), "nothing is run or made")
        write(study, read(study).replace("fluid: [axisymmetric, navier_stokes]", "fluid: [axisymmetric]"))
        self.assert_code(self.sandglass("study", study), DONE)
        write(study, read(study).replace("2650 kg/m3", "2650 kg/m3, 2700 kg/m3"))
        ended = self.sandglass("plan", study)
        self.assertIn("Study of 3 points: 1 would be run, 2 there already and good", ended.out)
        self.assertRegex(ended.out, r"unit_answer: .* in 3 points, saved [\d.e-]+ s in the 2 that measured it")


if __name__ == "__main__":
    unittest.main()
