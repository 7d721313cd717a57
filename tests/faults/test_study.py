"""Studies when things go wrong, and when nothing is left to do: a bad point costs one point, an interrupted or killed
study goes on, results are reused as long as everything they were made of is the same, and `why` names what is not."""

import json
import os
import shutil
import signal
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "integration"))

from case import (BINARY, DONE, INTERRUPTED, MISMATCH, PARTICIPANT, REFUSED, SCRIPTED, USAGE, change, copy_of_home, read,  # noqa: E402
                  wait_until, write)
from pair import FaultCase, command  # noqa: E402
from test_resume import datasets  # noqa: E402

BAD = "exit=3"
SCENE = """\
sandglass: 1
name: deeds
parameters:
  deed: {value: late=0}
  seed: {value: 1, type: count}
  length: {value: 3, type: count, minimum: 1}
  spare: {value: 1}
  limit: {value: 1e9}
stages:
  couple: {run: coupling}
  analyse: {run: python, template: analysis/deeds.py, given: [seed, length], analysis: true}
participants:
  left: {solver: command, command: %s, deadline: 60 s}
  right: {solver: command, command: %s, deadline: 60 s}
coupling:
  window: 1 ms
  end: 3 ms
  order: [left, right]
  fields:
    force: {unit: N, shape: [$length], from: left, to: right}
    motion: {unit: m, shape: [$length], from: right}
compare:
  - {name: last, quantity: last, metric: value, tolerance: $limit, because: a bound of the test}
""" % (command("advance@2", "DEED").replace("'DEED'", "$deed"), command())
ANALYSIS = """\
import sandglass_analysis as sandglass
record = sandglass.open_record()
sandglass.quantity('last', record['force'][-1, 0] + {{seed}} / {{length}}, '1', 'of the force')
sandglass.finish()
"""


class StudyCase(FaultCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.home = copy_of_home(cls.place)
        write(cls.place.join("home", "templates", "analysis", "deeds.py"), ANALYSIS)
        cls.place.write("scene.yaml", SCENE)

    def file(self, name, points, more=""):
        return self.place.write(name + ".yaml", "sandglass: 1\nname: %s\nstudy:\n  of: scene.yaml\n  points:\n%s%s"
                                % (name, "".join("    - %s\n" % one for one in points), more))

    def study(self, name, *arguments, verb="study", **options):
        return self.sandglass(verb, self.place.join(name + ".yaml"), *arguments, home=self.home, out=name, **options)

    def why(self, name, *arguments):
        ended = self.study(name, *arguments, verb="why")
        self.assert_code(ended, DONE)
        return ended.out

    def points(self, name):
        return {one["name"]: one for one in json.loads(read(self.place.join(name, "summary", "points.json")))["points"]}

    def begun(self, name):
        """When each point's run began: changes when it is run again."""
        folder = self.place.join(name, "points")
        return {point: os.stat(os.path.join(folder, point, "run.json")).st_mtime_ns for point in os.listdir(folder)}


class Outcomes(StudyCase):
    def test_a_bad_point_costs_one_point(self):
        self.file("bad", ["grid: {deed: [late=0, %s], seed: [1, 2]}" % BAD])
        ended = self.study("bad")
        self.assert_code(ended, PARTICIPANT)
        points = self.points("bad")
        self.assertEqual(sorted((one["good"], one["status"]) for one in points.values()),
                         [(False, "failed")] * 2 + [(True, "done")] * 2)
        self.assertIn("FAILED   deed=exit=3,seed=1: ", ended.err)
        self.assertIn("4 points: 4 run", ended.out)
        # What failed is tried again, what did not is not.
        before = self.begun("bad")
        ended = self.study("bad")
        self.assert_code(ended, PARTICIPANT)
        self.assertIn("4 points: 2 run, 2 there already", ended.out)
        after = self.begun("bad")
        self.assertEqual({name for name in before if before[name] == after[name]}, {"deed=late=0,seed=1", "deed=late=0,seed=2"})
        status = self.sandglass("status", self.place.join("bad"))
        self.assertIn("2 done, 2 failed", status.out)

    def test_what_is_expected_to_be_unstable(self):
        unstable = ["set: {deed: value=nan}\n      expect: unstable", "set: {deed: late=0}"]
        self.file("unstable", unstable)
        self.assert_code(self.study("unstable"), DONE)
        self.file("stable", ["set: {deed: late=0}\n      expect: unstable", "set: {deed: value=nan}"])
        ended = self.study("stable")
        self.assert_code(ended, PARTICIPANT)
        self.assertIn("it ended well, but was expected to be unstable", ended.err)
        self.assertEqual([one["good"] for one in self.points("stable").values()], [False, False])

    def test_tolerances_judge_unless_told_otherwise(self):
        self.file("judged", ["grid: {limit: [1e9, 1e-9]}"])
        self.assert_code(self.study("judged"), MISMATCH)
        self.file("unjudged", ["grid: {limit: [1e9, 1e-9]}"], "  judge: false\n")
        ended = self.study("unjudged")
        self.assert_code(ended, DONE)
        self.assertIn("outside  limit=1e-9: ", ended.err)

    def test_points_that_are_the_same_workflow_are_run_once(self):
        self.file("twins", ["grid: {spare: [1, 2, 3], seed: [1, 2]}"])
        ended = self.study("twins")
        self.assert_code(ended, DONE)
        self.assertIn("6 points: 2 run, 0 there already, 4 the same as another", ended.out)
        points = self.points("twins")
        self.assertEqual(len(points), 6)
        self.assertEqual(points["spare=3,seed=2"]["parameters"]["spare"], 3)
        self.assertEqual(points["spare=3,seed=2"]["quantities"], points["spare=1,seed=2"]["quantities"])

    def test_wrong_points_are_refused_with_their_places(self):
        self.file("wrong", ["grid: {lenght: [1]}", "grid: {length: [0, 2]}", "grid: {seed: [1], seed_: [2]}"])
        ended = self.study("wrong")
        self.assert_refused(ended, "did you mean 'length'?", "wrong.yaml:7:23: 'length' is 0; minimum: 1",
                            file="wrong.yaml")
        self.assertFalse(os.path.exists(self.place.join("wrong", "points")))
        self.file("sets", ["grid: {seed: [1, 2]}"])
        ended = self.study("sets", "--set", "seed=3")
        self.assert_code(ended, USAGE)
        self.assert_code(self.sandglass("study", self.place.join("scene.yaml"), home=self.home), USAGE)


class Reuse(StudyCase):
    def setUp(self):
        self.name = "reuse_" + self.id().rsplit(".", 1)[1]
        self.file(self.name, ["grid: {seed: [1, 2]}"])
        self.assert_code(self.study(self.name), DONE)

    def test_nothing_to_do(self):
        ended = self.study(self.name)
        self.assert_code(ended, DONE)
        self.assertIn("nothing to do: 2 points unchanged", ended.out)
        self.assertIn("nothing would be run", self.why(self.name))
        # A file that only looks different is read, found the same, and nothing is run.
        os.utime(self.place.join("scene.yaml"))
        before = self.begun(self.name)
        ended = self.study(self.name)
        self.assertIn("2 points: 0 run, 2 there already", ended.out)
        self.assertEqual(self.begun(self.name), before)

    def test_a_template(self):
        path = self.place.join("home", "templates", "analysis", "deeds.py")
        self.addCleanup(write, path, ANALYSIS)
        change(path, ("of the force", "of the last force"))
        self.assertEqual(self.why(self.name).count("template analysis/deeds.py changed"), 2)
        self.assertIn("2 points: 2 run", self.study(self.name).out)

    def test_a_runtime_piece_and_a_solver(self):
        path = self.place.join("home", "templates", "python", "sandglass_analysis.py")
        text = read(path)
        self.addCleanup(write, path, text)
        write(path, text + "\n# changed\n")
        self.assertIn("solver python: templates/python/sandglass_analysis.py changed", self.why(self.name))
        write(path, text)
        self.assertIn("nothing would be run", self.why(self.name))

    def test_a_module_that_a_command_runs(self):
        module = self.place.join("home", "templates", "python", "deeds_by_module.py")
        write(module, "import runpy, sys\nsys.path.insert(0, %r)\nrunpy.run_path(%r, run_name='__main__')\n"
              % (os.path.dirname(SCRIPTED), SCRIPTED))
        by_path = "'-S', '-E', '%s'" % SCRIPTED
        self.assertEqual(SCENE.count(by_path), 2)
        self.addCleanup(self.place.write, "scene.yaml", SCENE)
        self.place.write("scene.yaml", SCENE.replace(by_path, "'-m', 'deeds_by_module'"))
        self.assert_code(self.study(self.name), DONE)
        self.assertIn("nothing would be run", self.why(self.name))
        with open(module, "a") as file:
            file.write("# changed\n")
        self.assertEqual(self.why(self.name).count("template python/deeds_by_module.py changed"), 2)

    def test_parameters(self):
        said = self.why(self.name, "--set", "length=4")
        self.assertEqual(said.count("parameter length: 3 -> 4"), 2)
        self.assertNotIn("participant", said)  # what the parameter acts through need not be named too
        self.assertIn("nothing would be run", self.why(self.name, "--set", "spare=7"))
        self.addCleanup(self.place.write, "scene.yaml", SCENE)
        self.place.write("scene.yaml", SCENE.replace("end: 3 ms", "end: 4 ms"))
        self.assertEqual(self.why(self.name).count("coupling changed"), 2)
        self.assertIn("2 points: 2 run", self.study(self.name).out)

    def test_a_new_point_leaves_the_others(self):
        before = self.begun(self.name)
        self.file(self.name, ["grid: {seed: [1, 2, 3]}"])
        self.assertEqual(self.why(self.name), "seed=3\n    was never run\n1 of 3 points would be run\n")
        self.assertIn("3 points: 1 run, 2 there already", self.study(self.name).out)
        after = self.begun(self.name)
        self.assertEqual({name: after[name] for name in before}, before)

    def test_by_another_program(self):
        other = self.place.join("other", "sandglass")
        os.makedirs(os.path.dirname(other), exist_ok=True)
        shutil.copy(BINARY, other)
        self.assertIn("2 points: 0 run, 2 there already", subprocess.run(
            [other, "study", self.place.join(self.name + ".yaml"), "--out", self.place.join(self.name)],
            env=dict(os.environ, SANDGLASS_HOME=self.home, SANDGLASS_TEST=self.place.mark), capture_output=True, text=True, timeout=100).stdout)

    def test_again(self):
        before = self.begun(self.name)
        self.assertIn("2 points: 2 run", self.study(self.name, "--again").out)
        self.assertTrue(all(before[name] != number for name, number in self.begun(self.name).items()))

    def test_compare(self):
        self.assert_code(self.study(self.name, "--set", "length=4"), DONE)
        other = self.name + "_other"
        self.file(other, ["grid: {seed: [1, 2]}"])
        self.assert_code(self.study(other), DONE)
        ended = self.sandglass("compare", self.place.join(self.name), self.place.join(other))
        self.assert_code(ended, DONE)
        self.assertIn("parameter length: 4 | 3", ended.out)
        self.assertRegex(ended.out, r"seed=2: last: [\d.]+ \| [\d.]+ \(relative ")
        runs = [self.place.join(other, "points", "seed=%d" % seed) for seed in (1, 2)]
        ended = self.sandglass("compare", *runs)
        self.assertIn("parameter seed: 1 | 2", ended.out)
        self.assertIn("Quantities: all 1 the same", self.sandglass("compare", runs[0], runs[0]).out)


class Interrupted(StudyCase):
    """One point stalls: the study is stopped, the file mended, and only what is missing is run."""

    def stop(self, name, number):
        self.file(name, ["grid: {seed: [1, 2]}", "set: {deed: stall}"])
        started = self.place.start("study", self.place.join(name + ".yaml"), "--jobs", "2", home=self.home, out=name)
        done = [self.place.join(name, "points", "seed=%d" % seed, "report.html") for seed in (1, 2)]
        stalled = self.place.join(name, "points", "deed=stall", "status.json")
        self.assertTrue(wait_until(lambda: all(map(os.path.exists, done + [stalled])), 100))
        wait_until(lambda: "deed=stall  " in self.sandglass("status", self.place.join(name)).out, 20)
        started.signal(number)
        ended = started.wait(30)
        self.assertEqual(self.place.left_over(5), {})
        return ended

    def go_on(self, name):
        before = self.begun(name)
        self.file(name, ["grid: {seed: [1, 2]}", "set: {deed: late=0.01}"])
        ended = self.study(name)
        self.assert_code(ended, DONE)
        self.assertIn("3 points: 1 run, 2 there already", ended.out)
        after = self.begun(name)
        self.assertEqual([after["seed=%d" % seed] for seed in (1, 2)], [before["seed=%d" % seed] for seed in (1, 2)])

    def test_by_control_c(self):
        self.assert_code(self.stop("interrupted", signal.SIGINT), INTERRUPTED)
        self.go_on("interrupted")

    def test_by_kill(self):
        self.stop("killed", signal.SIGKILL)
        self.go_on("killed")

    def test_a_point_goes_on_behind_its_checkpoint(self):
        """Killed with its study in the middle of a point: the next call does not begin that point anew."""
        scene = (SCENE.replace(command(), command("advance", "late=0.005")).replace("end: 3 ms", "end: 300 ms")
                 + "record: {checkpoint_every: 10}\n")
        self.place.write("long.yaml", scene)
        text = "sandglass: 1\nname: %s\nstudy:\n  of: long.yaml\n  points: [{grid: {seed: [1, 2]}}]\n"
        for name in ("whole", "gone_on"):
            self.place.write(name + ".yaml", text % name)
        self.assert_code(self.study("whole"), DONE)
        started = self.place.start("study", self.place.join("gone_on.yaml"), "--jobs", "1", home=self.home, out="gone_on")
        checkpoint = self.place.join("gone_on", "points", "seed=1", "checkpoints", "000000050")
        self.assertTrue(wait_until(lambda: os.path.isdir(checkpoint), 100))
        started.signal(signal.SIGKILL)
        started.wait(30)
        self.assertEqual(self.place.left_over(5), {})
        self.assertEqual(self.why("gone_on"), "seed=1\n    its run was ended on its way: it goes on behind a checkpoint\n"
                         "seed=2\n    was never run\n2 of 2 points would be run\n")
        ended = self.study("gone_on")
        self.assert_code(ended, DONE)
        self.assertIn("2 points: 2 run", ended.out)
        self.assertRegex(read(self.place.join("gone_on", "logs", "seed=1.log")), r"went on behind window [5-9]0\n")
        for point in ("seed=1", "seed=2"):
            ours, theirs = (self.place.join(name, "points", point) for name in ("gone_on", "whole"))
            self.assertEqual(datasets(os.path.join(ours, "record.h5")), datasets(os.path.join(theirs, "record.h5")))
        # Nothing tells them apart but the times, which count all parts, and what else the machine had to do.
        points, others = self.points("gone_on"), self.points("whole")
        for one in list(points.values()) + list(others.values()):
            seconds = one.pop("seconds")
            one.pop("load")
            self.assertGreater(seconds["right"], 300 * 0.005)
            self.assertGreater(seconds["run"], 300 * 0.005)
        self.assertEqual(points, others)
        # What the point is made of changed: it is begun anew, and what it had recorded is kept.
        recorded = datasets(os.path.join(ours, "record.h5"))
        self.assertIn("2 points: 2 run", self.study("gone_on", "--set", "length=4").out)
        self.assertEqual(datasets(self.place.join("gone_on", "replaced", "seed=2", "record.h5")), recorded)
        self.assertNotEqual(datasets(os.path.join(ours, "record.h5")), recorded)

    def test_a_point_that_somebody_else_runs_is_left_alone(self):
        scene = SCENE.replace(command(), command("advance", "late=0.02")).replace("end: 3 ms", "end: 1 s") + "record: {checkpoint_every: 10}\n"
        self.place.write("lent.yaml", scene)
        self.place.write("lender.yaml", "sandglass: 1\nname: lender\nstudy:\n  of: lent.yaml\n  points: [{grid: {seed: [1]}}]\n")
        started = self.place.start("study", self.place.join("lender.yaml"), home=self.home, out="lender")
        point = self.place.join("lender", "points", "seed=1")
        self.assertTrue(wait_until(lambda: os.path.isdir(os.path.join(point, "checkpoints", "000000010")), 100))
        started.signal(signal.SIGINT)
        started.wait(30)
        resumed = self.place.start("resume", point, home=self.home)
        self.assertTrue(wait_until(lambda: "is running" in self.why("lender"), 30))
        ended = self.study("lender", "--set", "length=4")
        self.assertEqual(ended.code, 7, str(ended))
        self.assertIn("point 'seed=1' is in use by another process", ended.err)
        self.assertFalse(os.path.exists(self.place.join("lender", "replaced")))
        resumed.signal(signal.SIGTERM)
        resumed.wait(30)

    def test_the_folder_of_something_else_is_left_alone(self):
        self.file("guest", ["grid: {seed: [1]}"])
        kept = self.place.write("guest/summary/mine.txt", "mine\n")
        ended = self.study("guest")
        self.assertEqual(ended.code, 7, str(ended))
        self.assertIn("is not empty, and no study's", ended.err)
        self.assertEqual(read(kept), "mine\n")
        self.assertEqual(os.listdir(self.place.join("guest")), ["summary"])

    def test_two_at_a_time_are_refused(self):
        self.file("twice", ["set: {deed: stall}"])
        started = self.place.start("study", self.place.join("twice.yaml"), home=self.home, out="twice")
        self.assertTrue(wait_until(lambda: os.path.exists(self.place.join("twice", "points")), 60))
        ended = self.study("twice")
        self.assertEqual(ended.code, 7, str(ended))
        self.assertIn("in use by another process", ended.err)
        started.signal(signal.SIGTERM)
        started.wait(30)


if __name__ == "__main__":
    unittest.main()
