"""Killed at any moment, gone on with, and repeated: a run ends with the same bytes as an unbroken one."""

import os
import random
import signal
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "integration"))

import h5py
import numpy

from case import (DONE, ENVIRONMENT, MISMATCH, PARTICIPANT, REFUSED, SCRIPTED, SPHERE, USAGE, change, copy_of_home, read, sets,
                  wait_until, write)
from pair import FaultCase, pair, windows_of

WINDOWS = 40
KILLS = 50
SEED = 20261122  # of the moments; any will do


def datasets(path):
    """Every dataset of a record but the timings, as bytes with type and shape."""
    found = {}

    def look(name, item):
        if isinstance(item, h5py.Dataset) and not name.startswith("timings/"):
            found[name] = (str(item.dtype), item.shape, item[...].tobytes())

    with h5py.File(path, "r") as file:
        file.visititems(look)
    return found


def slow_pair(every=3, slow=0.004, **options):
    """Two participants that take a few milliseconds for a window, and `slow` s for writing their state."""
    behaviour = ("advance", "late=0.003", "checkpoint", "late=%g" % slow, "ready", "late=0.02")
    text = pair(left=behaviour, right=behaviour, windows=WINDOWS, answered=False, **options)
    return text + "record: {checkpoint_every: %d}\n" % every


class ResumeCase(FaultCase):
    def assert_same_bytes(self, ended, unbroken):
        ours, theirs = datasets(ended.path("record.h5")), datasets(unbroken.path("record.h5"))
        self.assertEqual(sorted(ours), sorted(theirs))
        for name in theirs:
            self.assertEqual(ours[name][:2], theirs[name][:2], name)
            self.assertTrue(ours[name][2] == theirs[name][2], "%s: other bytes" % name)

    def resume_until_done(self, directory, code=DONE):
        ended = self.sandglass("resume", directory)
        ended.directory = directory
        self.assert_code(ended, code)
        return ended


class KilledAtAnyMoment(ResumeCase):
    """Scripted participants: what is tried here is the engine, fifty times."""

    def kill_one(self, started, whom):
        """`whom` is the orchestrator, one of its participants, or all."""
        if whom in ("orchestrator", "all"):
            started.signal(signal.SIGKILL)
        if whom != "orchestrator":
            for number, line in self.place.processes().items():
                if number != started.process.pid and "scripted_participant" in line:
                    try:
                        os.kill(number, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
                    if whom == "solver":
                        break

    def test_fifty_random_moments(self):
        workflow = self.place.write("slow.yaml", slow_pair())
        begin = time.monotonic()
        unbroken = self.sandglass("run", workflow, out="unbroken")
        whole = time.monotonic() - begin
        self.assert_code(unbroken, DONE)
        self.assert_record(unbroken.record, WINDOWS, answered=False)
        moments = random.Random(SEED)
        went_on_behind = set()
        for kill in range(KILLS):
            whom = moments.choice(["orchestrator", "solver", "all"])
            moment = moments.uniform(0.02, whole)
            with self.subTest(kill=kill, whom=whom, moment="%.0f ms of %.0f" % (1e3 * moment, 1e3 * whole)):
                started = self.place.start("run", workflow, out="killed%d" % kill)
                self.assertTrue(wait_until(lambda: os.path.exists(started.path("run.json")), 30))
                time.sleep(moment)
                self.kill_one(started, whom)
                started.wait(30)
                self.assert_nothing_left()
                if moments.random() < 0.3:  # and once more, while it goes on
                    again = self.place.start("resume", started.directory)
                    time.sleep(moments.uniform(0.02, whole))
                    again.signal(signal.SIGKILL)
                    again.wait(30)
                    self.assert_nothing_left()
                ended = self.resume_until_done(started.directory)
                self.assert_same_bytes(ended, unbroken)
                self.assertEqual(ended.result["windows"], WINDOWS)
                went_on_behind.update(line for line in ended.out.splitlines() if line.startswith("went on behind window"))
        # The moments were spread over the run: many checkpoints were gone on from.
        self.assertGreater(len(went_on_behind), 5, went_on_behind)

    def test_inside_the_writing_of_a_checkpoint(self):
        """One participant's state is written, the other one's is not: the checkpoint does not count."""
        unbroken = self.sandglass("run", self.place.write("whole.yaml", slow_pair()), out="whole")
        started = self.place.start("run", self.place.write("inside.yaml", slow_pair(slow=0.5)), out="inside")
        log = started.path("logs", "right.log")
        self.assertTrue(wait_until(lambda: os.path.exists(log) and read(log).count("asked checkpoint") == 2, 30))
        started.signal(signal.SIGKILL)
        started.wait(30)
        self.assertEqual(sorted(os.listdir(started.path("checkpoints"))), ["000000003", "000000006.part"])
        ended = self.resume_until_done(started.directory)
        self.assert_same_bytes(ended, unbroken)

    def test_a_damaged_checkpoint_is_named(self):
        workflow = self.place.write("damaged.yaml", slow_pair(every=10))
        started = self.place.start("run", workflow, out="damaged")
        self.assertTrue(wait_until(lambda: os.path.isdir(started.path("checkpoints", "000000010")), 30))
        started.signal(signal.SIGKILL)
        started.wait(30)
        for name in os.listdir(started.path("checkpoints")):
            if not name.endswith(".part"):
                with open(started.path("checkpoints", name, "coupling.h5"), "r+b") as file:
                    file.truncate(100)
        ended = self.sandglass("resume", started.directory)
        self.assert_code(ended, ENVIRONMENT)
        self.assert_said(ended, "coupling.h5")

    def test_only_the_newest_are_kept(self):
        text = slow_pair().replace("checkpoint_every: 3", "checkpoint_every: 3, checkpoints_kept: 2")
        ended = self.sandglass("run", self.place.write("few.yaml", text), out="few")
        self.assert_code(ended, DONE)
        self.assertEqual(sorted(os.listdir(ended.path("checkpoints"))), ["000000036", "000000039"])


class GoingOn(ResumeCase):
    def interrupted(self, name, text, windows=3, **options):
        started = self.place.start("run", self.place.write(name + ".yaml", text), out=name, **options)
        self.assertTrue(wait_until(lambda: windows_of(started) >= windows, 60))
        started.signal(signal.SIGINT)
        started.wait(30)
        return started

    def test_interrupted_its_record_was_cut_and_grows_again(self):
        unbroken = self.sandglass("run", self.place.write("straight.yaml", slow_pair()), out="straight")
        started = self.interrupted("cut", slow_pair(), windows=10)
        self.assertLess(len(datasets(started.path("record.h5"))["time"][2]),
                        len(datasets(unbroken.path("record.h5"))["time"][2]))
        ended = self.resume_until_done(started.directory)
        self.assert_same_bytes(ended, unbroken)
        again = self.sandglass("resume", started.directory)
        self.assert_code(again, DONE)
        self.assertIn("nothing to resume", again.out)

    def test_without_checkpoints_from_the_start(self):
        text = slow_pair().replace("record: {checkpoint_every: 3}\n", "")
        unbroken = self.sandglass("run", self.place.write("none.yaml", text), out="none")
        started = self.interrupted("again", text)
        ended = self.resume_until_done(started.directory)
        self.assert_same_bytes(ended, unbroken)

    def test_it_ends_early_at_the_same_window(self):
        text = slow_pair().replace("  window: 1 ms\n", "  window: 1 ms\n  rest: {field: force, at_most: 1e9, for: 31 ms}\n")
        unbroken = self.sandglass("run", self.place.write("rest.yaml", text), out="rest")
        self.assert_code(unbroken, DONE)
        self.assertEqual(unbroken.result["windows"], 31)
        self.assert_record(unbroken.record, 31, answered=False)
        self.assertIn("field 'force' was at most 1000000000 in 31 windows one after the other: nothing is left to compute, the run "
                      "ended at 0.031 s of 0.04 s", " ".join(note["text"] for note in unbroken.result["notes"]))
        started = self.interrupted("rest-cut", text, windows=10)
        ended = self.resume_until_done(started.directory)
        self.assertEqual(ended.result["windows"], 31)
        self.assert_same_bytes(ended, unbroken)
        again = self.sandglass("resume", started.directory)
        self.assert_code(again, DONE)
        self.assertIn("nothing to resume: this run came to its end", again.out)
        self.assert_same_bytes(ended, unbroken)

    def test_at_rest_and_killed_before_it_was_said(self):
        text = slow_pair(every=1, slow=0).replace("  window: 1 ms\n", "  window: 1 ms\n  rest: {field: force, at_most: 1e9, for: 31 ms}\n")
        ended = self.sandglass("run", self.place.write("rested.yaml", text), out="rested")
        self.assert_code(ended, DONE)
        before = datasets(ended.path("record.h5"))
        os.remove(ended.path("result.json"))
        again = self.resume_until_done(ended.directory)
        self.assertEqual(again.result["windows"], 31)
        self.assertIn("nothing is left to compute", " ".join(note["text"] for note in again.result["notes"]))
        self.assertEqual(datasets(ended.path("record.h5")), before)

    def test_killed_while_it_was_described(self):
        ended = self.sandglass("run", self.place.write("described.yaml", slow_pair()), out="described")
        for name in ("report.html", "ro-crate-metadata.json"):
            os.remove(ended.path(name))
        again = self.sandglass("resume", ended.directory)
        self.assert_code(again, DONE)
        self.assertIn("nothing to resume", again.out)
        self.assertTrue(os.path.exists(ended.path("report.html")))
        self.assert_code(self.sandglass("verify", ended.directory), DONE)

    def test_one_that_cannot_start_costs_nothing(self):
        program = "import runpy, sys\nsys.path.insert(0, %r)\nrunpy.run_path(%r, run_name='__main__')\n" % (os.path.dirname(SCRIPTED), SCRIPTED)
        path = self.place.write("program.py", program)
        for name, line in (("costs", ""), ("costs_not", "record: {checkpoint_every: 3}\n")):
            text = slow_pair().replace(SCRIPTED, path).replace("record: {checkpoint_every: 3}\n", line)
            started = self.interrupted(name, text, windows=7)
            before = datasets(started.path("record.h5"))
            write(path, "raise SystemExit('not today')\n")
            ended = self.sandglass("resume", started.directory)
            self.assert_code(ended, PARTICIPANT)
            self.assert_said(ended, "not today")
            self.assertEqual(datasets(started.path("record.h5")), before)
            write(path, program)
            self.assertEqual(self.resume_until_done(started.directory).result["windows"], WINDOWS)

    def test_analyses_of_a_run_are_none(self):
        ended = self.sandglass("run", self.place.write("analysed.yaml", slow_pair()), out="analysed")
        self.assert_code(self.sandglass("analyse", ended.directory, out="analyses"), DONE)
        again = self.sandglass("resume", self.place.join("analyses"))
        self.assert_code(again, ENVIRONMENT)
        self.assert_said(again, "holds analyses", "sandglass analyse")

    def test_fresh_participants(self):
        text = slow_pair(process="fresh")
        unbroken = self.sandglass("run", self.place.write("fresh.yaml", text), out="fresh")
        started = self.interrupted("fresh-cut", text, windows=7)
        self.assert_same_bytes(self.resume_until_done(started.directory), unbroken)

    def test_a_participant_that_cannot_write_its_state_is_refused(self):
        ended = self.sandglass("run", self.place.write("unable.yaml", slow_pair(abilities="memory")), out="unable")
        self.assert_code(ended, REFUSED)
        self.assert_said(ended, "left", "cannot write its state", "checkpoint_every")

    def test_an_altered_workflow_is_named(self):
        started = self.interrupted("altered", slow_pair())
        with open(started.path("workflow.yaml"), "a") as file:
            file.write("# a word more\n")
        ended = self.sandglass("resume", started.directory)
        self.assert_code(ended, REFUSED)
        self.assert_said(ended, "workflow.yaml", "altered")

    def test_what_is_no_run_directory_is_said(self):
        ended = self.sandglass("resume", self.place.path)
        self.assert_code(ended, ENVIRONMENT)
        self.assert_said(ended, "not a run directory")
        self.assertFalse(os.path.exists(self.place.join("lock")))

    def test_a_state_that_was_not_written_is_noticed(self):
        behaviour = ("advance", "late=0.003")
        text = pair(left=behaviour + ("checkpoint", "idle"), right=behaviour, windows=WINDOWS, answered=False) + "record: {checkpoint_every: 3}\n"
        ended = self.sandglass("run", self.place.write("unwritten.yaml", text), out="unwritten")
        self.assert_code(ended, PARTICIPANT)
        self.assert_said(ended, "left", "window 3", "left nothing at", "disk")
        self.assertEqual(ended.record.windows, 3)


class RealSolvers(ResumeCase):
    """YADE and FreeFEM: 4000 windows, killed where many are done and many are left."""

    LONG = dict(end_time="4 s", checkpoint_every=400)
    CASES = (dict(), dict(acceleration="constant", relaxation=0.8), dict(scheme="serial-implicit", acceleration="aitken"))

    def test_killed_and_gone_on_with(self):
        moments = random.Random(SEED)
        for number, case in enumerate(self.CASES):
            with self.subTest(**case):
                words = ["run", SPHERE, *sets(**self.LONG, **case)]
                unbroken = self.sandglass(*words, out="unbroken%d" % number)
                self.assertEqual(unbroken.record.windows, 4000, str(unbroken))
                started = self.place.start(*words, out="killed%d" % number)
                until = moments.randrange(500, 3000)
                self.assertTrue(wait_until(lambda: windows_of(started) >= until, 60, every=0.002))
                started.signal(signal.SIGKILL)
                started.wait(30)
                self.assert_nothing_left()
                self.assertLess(windows_of(started), 4000)
                ended = self.resume_until_done(started.directory, unbroken.code)
                self.assert_same_bytes(ended, unbroken)
                self.assertIn("went on behind window", ended.out)
                # How it came to its result is no part of the result.
                self.assertEqual(ended.result.get("notes"), unbroken.result.get("notes"))
                self.assertEqual(ended.result["quantities"], unbroken.result["quantities"])

    def test_a_changed_template_is_named(self):
        home = copy_of_home(self.place)
        started = self.place.start("run", SPHERE, *sets(**self.LONG), out="changed", home=home)
        self.assertTrue(wait_until(lambda: windows_of(started) >= 500, 60, every=0.002))
        started.signal(signal.SIGKILL)
        started.wait(30)
        change(os.path.join(home, "templates", "yade", "settling_sphere_window.py"), ("buoyancy + drag", "drag + buoyancy"))
        ended = self.sandglass("resume", started.directory, home=home)
        self.assert_code(ended, REFUSED)
        self.assert_said(ended, "templates/yade/settling_sphere_window.py", "has changed since the run began")


class Replayed(ResumeCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.run_once = cls.place.sandglass("run", SPHERE, *sets(process="fresh", end_time="6 ms", checkpoint_every=2),
                                           out="sphere")

    def test_a_window_and_all_agree_to_the_byte(self):
        for words, said in ((["--window", "1"], "from the start"), (["--window", "5"], "behind window 4"),
                            (["--window", "4"], "behind window 2"), (["--all"], "windows 1 to 6")):
            with self.subTest(words=words):
                ended = self.sandglass("replay", self.run_once.directory, *words)
                self.assert_code(ended, DONE)
                self.assertIn(said, ended.out)
                self.assertIn("every byte", ended.out)
        self.assertFalse(os.path.exists(self.run_once.path("replay")))

    def test_an_altered_record_is_found(self):
        path = self.run_once.path("record.h5")
        kept = read(path, "rb")
        try:
            with h5py.File(path, "r+") as file:
                file["fields/drag"][2] = numpy.nextafter(file["fields/drag"][2], numpy.inf)
            ended = self.sandglass("replay", self.run_once.directory, "--window", "3")
            self.assert_code(ended, MISMATCH)
            self.assert_said(ended, "/fields/drag", "window 3", "recorded", "repeated")
        finally:
            with open(path, "wb") as file:
                file.write(kept)

    def test_windows_that_are_not_there(self):
        ended = self.sandglass("replay", self.run_once.directory, "--window", "7")
        self.assert_code(ended, USAGE)
        self.assert_said(ended, "windows 1 to 6")
        self.assert_code(self.sandglass("replay", self.run_once.directory), USAGE)


if __name__ == "__main__":
    unittest.main()
