"""Ctrl-C, its like, and SIGKILL: the run ends at once, no process stays, and the record keeps every complete window."""

import os
import signal
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "integration"))

import numpy

from case import DONE, ENVIRONMENT, INTERRUPTED, PYTHON, SPHERE, Record, read, sets, wait_until
from pair import FaultCase, pair, windows_of

LIMIT = 2.0  # s, within which an interrupted run must have ended


class Interrupted(FaultCase):
    """Ctrl-C and its like, to the orchestrator alone: its children are in groups of their own."""

    def interrupt(self, name, text, ready, number=signal.SIGINT, windows=None):
        started = self.place.start("run", self.place.write(name + ".yaml", text), out=name)
        self.assertTrue(wait_until(lambda: ready(started) or not started.running(), 30))
        self.assertTrue(started.running(), "it ended before it could be interrupted")
        start = time.monotonic()
        started.signal(number)
        ended = started.wait(30)
        took = time.monotonic() - start
        self.assertEqual(self.place.left_over(0.5), {})
        self.assert_failed(ended, INTERRUPTED, "interrupted")
        self.assertLess(took, LIMIT)
        self.assertIn("interrupted", ended.result["error"])
        return ended

    def test_between_short_windows(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(signal=number.name):
                ended = self.interrupt("short" + number.name, pair(windows=1000000, answered=False),
                                       lambda started: os.path.getsize(started.path("logs", "right.log")) > 1000
                                       if os.path.exists(started.path("logs", "right.log")) else False, number)
                record = ended.record
                self.assertGreater(record.windows, 3)
                self.assert_record(record, record.windows, answered=False)
                self.assertEqual(ended.result["windows"], record.windows)
                # All that was done is there: the last participant was asked for at most one window more.
                asked = read(ended.path("logs", "right.log")).count("asked advance")
                self.assertIn(asked - record.windows, (0, 1))

    def test_during_a_window(self):
        ended = self.interrupt("long", pair(right=("advance@3", "stall")),
                               lambda started: "asked advance" in read(started.path("logs", "right.log"))
                               and read(started.path("logs", "right.log")).count("asked advance") == 3
                               if os.path.exists(started.path("logs", "right.log")) else False)
        self.assertEqual(ended.result["windows"], 2)
        self.assert_record(ended.record, 2)

    def test_while_a_solver_starts(self):
        ended = self.interrupt("starting", pair(right=("ready", "stall")),
                               lambda started: os.path.exists(started.path("logs", "right.log"))
                               and "asked ready" in read(started.path("logs", "right.log")))
        self.assertEqual(ended.result["windows"], 0)

    def test_deaf_solvers_and_what_they_started(self):
        self.interrupt("deaf", pair(right=("ready", "grandchild", "advance@1", "deaf")),
                       lambda started: os.path.exists(started.path("logs", "right.log"))
                       and "asked advance" in read(started.path("logs", "right.log")))

    def test_during_a_stage(self):
        script = self.place.write("sleep.py", "import time; print('asleep', flush=True); time.sleep(1000)")
        text = pair(stages="  first: {run: command, command: ['%s', '%s']}" % (PYTHON, script))
        text = text.replace("couple: {run: coupling}", "couple: {run: coupling, after: [first]}")
        self.interrupt("stage", text, lambda started: os.path.exists(started.path("logs", "first.log"))
                       and "asleep" in read(started.path("logs", "first.log")))

    def test_the_whole_foreground_group_and_twice(self):
        """A terminal sends Ctrl-C to its foreground group, and impatient people press it again."""
        started = self.place.start("run", self.place.write("group.yaml", pair(right=("advance@3", "stall"))),
                                   out="group")
        self.assertTrue(wait_until(lambda: windows_of(started) == 2, 30))
        for _ in range(2):
            os.killpg(started.process.pid, signal.SIGINT)
        self.assert_failed(started.wait(LIMIT), INTERRUPTED, "interrupted", windows=2)

    def test_a_terminal_that_goes_away_under_nohup(self):
        before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # what a program is started with stays so
        try:
            started = self.place.start("run", self.place.write("nohup.yaml", pair(right=("advance", "late=0.05"), windows=20, answered=False)),
                                       out="nohup")
        finally:
            signal.signal(signal.SIGHUP, before)
        self.assertTrue(wait_until(lambda: windows_of(started) >= 2, 30))
        started.signal(signal.SIGHUP)
        ended = started.wait(30)
        self.assert_code(ended, DONE)
        self.assert_record(ended.record, 20, answered=False)

    def test_killed_outright(self):
        """Nobody can clean up behind SIGKILL but the kernel; the record is whole all the same."""
        for name, text in (("killed", pair(windows=1000000, answered=False)),
                           ("killed_long", pair(right=("advance@4", "stall"), answered=False)),
                           ("killed_deaf", pair(right=("advance@3", "deaf"), answered=False))):
            with self.subTest(name):
                started = self.place.start("run", self.place.write(name + ".yaml", text), out=name)
                self.assertTrue(wait_until(lambda: windows_of(started) >= 3, 30))
                before = windows_of(started)
                started.signal(signal.SIGKILL)
                self.assertEqual(started.wait(LIMIT).code, -signal.SIGKILL)
                self.assertEqual(self.place.left_over(LIMIT), {})
                record = Record(started.path("record.h5"))
                self.assertGreaterEqual(record.windows, before)
                self.assert_record(record, record.windows, answered=False)
                status = self.sandglass("status", started.directory)
                self.assertNotIn("Traceback", status.err)
                self.assertIn(status.code, (DONE, ENVIRONMENT))

    def test_yade_and_freefem(self):
        """While YADE starts, and while windows are done."""
        for name, ready in (("early", lambda started: os.path.exists(started.path("logs", "grains.log"))),
                            ("late", lambda started: windows_of(started) > 5)):
            with self.subTest(name):
                started = self.place.start("run", SPHERE, *sets(end_time="1000 s"), out=name)
                self.assertTrue(wait_until(lambda: ready(started), 60))
                start = time.monotonic()
                started.signal(signal.SIGINT)
                ended = started.wait(30)
                self.assertLess(time.monotonic() - start, LIMIT)
                self.assertEqual(self.place.left_over(0.5), {})
                self.assert_failed(ended, INTERRUPTED, "interrupted")
                self.assertEqual(ended.record.windows, ended.result["windows"])
                self.assertTrue(numpy.all(numpy.isfinite(ended.record["velocity"])))
                self.assertEqual(ended.record.windows > 5, name == "late")

    def test_after_the_last_window(self):
        """While results are analysed and figures drawn: what there is stays."""
        for name, sign in (("analysed", ("logs", "analyse.log")), ("drawn", ("figures", "draw.log"))):
            with self.subTest(name):
                started = self.place.start("run", SPHERE, *sets(end_time="2 ms"), out=name)
                self.assertTrue(wait_until(lambda: os.path.exists(started.path(*sign)), 60))
                started.signal(signal.SIGINT)
                ended = started.wait(LIMIT)
                self.assert_failed(ended, INTERRUPTED, "interrupted", windows=2)
                self.assertEqual(ended.record.windows, 2)
                self.assert_nothing_left()


if __name__ == "__main__":
    unittest.main()
