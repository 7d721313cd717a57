"""What goes wrong outside: solvers that fail or lie, run directories that cannot be had, full disks.

Each ends clearly, with no process left and nothing recorded lost. Participants are scripted
(scripted_participant.py) and answer in milliseconds.
"""

import fcntl
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "integration"))

import numpy

from case import (BINARY, DONE, ENVIRONMENT, HOME, INTERRUPTED, PARTICIPANT, PYTHON, REFUSED, SOON, UNSTABLE, Record, read,
                  wait_until)
from pair import FaultCase, pair, windows_of

RANK = """\
sandglass: 1
name: rank
stages: {couple: {run: coupling}}
participants:
  one: {solver: command, command: ['%s', '%s']}
coupling:
  window: 1 ms
  end: 3 ms
  order: [one]
  exchange: %s
  fields: {motion: {unit: m, shape: [3, 2], from: one}}
"""


class Solvers(FaultCase):
    """A participant that does not do what it should, in window 3 of 5: two windows stay."""

    def fails(self, name, code, status, *words, windows=2, left=(), right=(), **options):
        ended = self.run_workflow(pair(left, right, **options), name=name)
        self.assert_failed(ended, code, status, windows)
        self.assert_said(ended, *words)
        if windows:
            self.assert_record(ended.record, windows)
        self.assert_nothing_left()
        return ended

    def test_well_behaved_ones_are_recorded_as_they_should(self):
        ended = self.run_workflow(pair(), name="well")
        self.assert_code(ended, DONE)
        self.assert_record(ended.record, 5)
        fresh = self.run_workflow(pair(process="fresh", windows=3), name="fresh")
        self.assert_code(fresh, DONE)
        self.assert_record(fresh.record, 3)

    def test_it_exits(self):
        self.fails("exits", PARTICIPANT, "failed", "right", "window 3", "exit status 3", "leaving on purpose",
                   "right.log",
                   right=("advance@3", "exit=3"))

    def test_it_exits_with_status_0(self):
        self.fails("leaves", PARTICIPANT, "failed", "right", "window 3", "exit status 0", right=("advance@3", "exit=0"))

    def test_it_is_killed(self):
        self.fails("killed", PARTICIPANT, "failed", "right", "window 3", "SIGKILL", right=("advance@3", "kill"))

    def test_it_dies_while_the_other_works(self):
        self.fails("dies", PARTICIPANT, "failed", "right", "exit status 3", scheme="parallel-explicit", windows=0,
                   left=("advance@1", "stall"), right=("advance@1", "exit=3"))

    def test_it_hangs_past_its_deadline(self):
        start = time.monotonic()
        self.fails("hangs", PARTICIPANT, "failed", "right", "window 3", "deadline of 3 s", "asked advance",
                   right=("advance@3", "stall"), deadline="3 s")
        self.assertLess(time.monotonic() - start, 20)

    def test_it_talks_past_its_deadline(self):
        self.fails("drips", PARTICIPANT, "failed", "right", "deadline", right=("advance@3", "drip"), deadline="3 s")
        self.fails("floods", PARTICIPANT, "failed", "right", "deadline", right=("advance@3", "flood"), deadline="3 s")

    def test_it_never_ends_its_line(self):
        self.fails("endless", PARTICIPANT, "failed", "right", right=("advance@3", "endless"), deadline="2 s")
        self.fails("half", PARTICIPANT, "failed", "right", "deadline", right=("advance@3", "half"), deadline="3 s")

    def test_it_stalls_and_cannot_be_asked_to_go(self):
        """Neither does what it started stay."""
        self.fails("stays", PARTICIPANT, "failed", "right", "deadline",
                   right=("ready", "grandchild", "ready", "deaf", "advance@1", "stall"), deadline="3 s", windows=0)

    def test_it_sends_what_is_not_finite(self):
        for value, word in (("nan", "not a number"), ("inf", "infinite"), ("-inf", "infinite")):
            self.fails("sends" + value, UNSTABLE, "unstable", "right", "window 3", "motion", word, "last lines", "asked advance",
                       right=("advance@3", "value=" + value))
        self.fails("nan_fresh", UNSTABLE, "unstable", "right", "window 3", "motion", right=("advance@3", "value=nan"),
                   process="fresh")

    def test_it_sends_another_shape(self):
        self.fails("short", PARTICIPANT, "failed", "right", "window 3", "motion", "[2, 2]", "[3, 2]", "asked advance",
                   right=("advance@3", "rows=2"))
        self.fails("long", PARTICIPANT, "failed", "right", "window 3", "motion", "[9, 2]",
                   right=("advance@3", "rows=9"))
        self.fails("narrow", PARTICIPANT, "failed", "right", "window 3", "motion", "[3, 1]",
                   right=("advance@3", "columns=1"))
        self.fails("negative", PARTICIPANT, "failed", "right", "window 3", "motion", right=("advance@3", "rows=-5"))
        self.fails("nothing", PARTICIPANT, "failed", "right", "window 3", "motion", "not sent",
                   right=("advance@3", "forget"))

    def test_it_cuts_its_slot(self):
        """To touch what is gone would be a deadly signal for the orchestrator."""
        self.fails("cut", PARTICIPANT, "failed", "right", "slot", "made shorter", right=("advance@3", "truncate"))

    def test_a_sender_that_receives_nothing_works_in_both_ways(self):
        for exchange in ("mapped", "file"):
            with self.subTest(exchange):
                script = self.place.write("sender.py", """\
import os, sys
sys.path.insert(0, os.environ["SANDGLASS_PYTHON"])
import numpy
import sandglass_participant
participant = sandglass_participant.connect()
participant.serve(lambda: participant.send("motion", numpy.full((3, 2), participant.window.end)))
""")
                ended = self.run_workflow(RANK % (PYTHON, script, exchange), name="sender_" + exchange)
                self.assert_code(ended, DONE)
                numpy.testing.assert_array_equal(ended.record["motion"][:, 0, 0], ended.record.time[:, 1])

    def test_it_sends_another_rank(self):
        """A number of axes is fixed by the slot; a fresh file can have any."""
        for shape in ("3", "3, 2, 1", "6", "2, 3"):
            script = self.place.write("another_rank.py", """\
import os, sys
sys.path.insert(0, os.environ["SANDGLASS_PYTHON"])
import h5py, numpy
import sandglass_participant
replace = os.replace
def spoil(part, path):
    with h5py.File(part, "r+") as file:
        del file["out/motion/values"]
        file["out/motion/values"] = numpy.ones((%s,))
    replace(part, path)
participant = sandglass_participant.connect()
def advance():
    if participant.window.index == 2:
        sandglass_participant.os.replace = spoil
    participant.send("motion", numpy.ones((3, 2)))
participant.serve(advance)
""" % shape)
            with self.subTest(shape=shape):
                name = "rank" + re.sub(r"\W", "", shape)
                ended = self.run_workflow(RANK % (PYTHON, script, "file"), name=name)
                self.assert_failed(ended, PARTICIPANT, "failed", windows=1)
                self.assert_said(ended, "one", "motion", "[%s]" % shape, "[3, 2]")

    def test_it_is_never_ready(self):
        self.fails("unready", PARTICIPANT, "failed", "right", "ready", "deadline", right=("ready", "stall"),
                   deadline="3 s",
                   windows=0)
        self.fails("early", PARTICIPANT, "failed", "right", "exit status 9", right=("ready", "exit=9"), windows=0)

    def test_it_speaks_another_version_or_another_language(self):
        self.fails("version", PARTICIPANT, "failed", "right", "ready 2", right=("ready", "say=ready 2"), windows=0)
        self.fails("hello", PARTICIPANT, "failed", "right", "hello", right=("ready", "say=hello"), windows=0)
        self.fails("answer", PARTICIPANT, "failed", "right", "fine", right=("advance@3", "say=fine"))
        self.fails("twice", PARTICIPANT, "failed", "right", right=("advance@2", "before=ok"), windows=None)

    def test_it_says_what_is_wrong(self):
        self.fails("says", PARTICIPANT, "failed", "right", "window 3", "the mesh is inside out",
                   right=("advance@3", "say=error the mesh is inside out"))

    def test_it_does_not_leave_when_asked(self):
        self.fails("lingers", PARTICIPANT, "failed", "right", "stop", right=("stop", "deaf"), deadline="3 s",
                   windows=5)
        self.fails("crashes", PARTICIPANT, "failed", "right", "exit status 3", right=("stop", "exit-soon=3"), windows=5)

    def test_its_notes_are_kept(self):
        ended = self.run_workflow(pair(right=("advance@3", "before=note the bed is <b>loose</b>")), name="notes")
        self.assert_code(ended, DONE)
        self.assertEqual(ended.result["notes"], [{"from": "right", "text": "the bed is <b>loose</b>"}])
        self.assertNotIn("<b>loose", read(ended.path("report.html")))

    def test_its_program_is_not_there(self):
        text = pair().replace("'%s'" % PYTHON, "'no-such-solver'", 1)
        ended = self.run_workflow(text, name="absent")
        self.assert_failed(ended, ENVIRONMENT, "environment", windows=0)
        self.assert_said(ended, "left", "no-such-solver", "doctor")

    def test_its_program_cannot_be_run(self):
        program = self.place.write("program", "not a program")
        os.chmod(program, 0o644)
        ended = self.run_workflow(pair().replace("'%s'" % PYTHON, "'%s'" % program, 1), name="unrunnable")
        self.assert_failed(ended, ENVIRONMENT, "environment", windows=0)
        os.chmod(program, 0o755)
        ended = self.run_workflow(pair().replace("'%s'" % PYTHON, "'%s'" % program, 1), name="nonsense")
        self.assert_failed(ended, ENVIRONMENT, "environment", windows=0)
        self.assert_said(ended, "left")


class Streams(FaultCase):
    """Nobody hears what is said."""

    def ended(self, verb, name, redirection):
        command = '"$0" "$1" "$2" --out "$3" ' + redirection if verb == "run" else '"$0" "$1" "$2" ' + redirection
        return subprocess.run(["/bin/sh", "-c", command, BINARY, verb, self.place.join(name + ".yaml"), self.place.join(name + "-run")],
                              env=dict(os.environ, SANDGLASS_HOME=HOME, SANDGLASS_TEST=self.place.mark), timeout=60).returncode

    def test_a_message_that_cannot_be_written_changes_nothing(self):
        self.place.write("bad.yaml", "sandglass: 1\n")
        for number, redirection in enumerate(("2>/dev/full", "2>&-", ">&- 2>&-", "<&- >&- 2>&-")):
            self.assertEqual(self.ended("check", "bad", redirection), REFUSED, redirection)
            name = "unheard%d" % number
            self.place.write(name + ".yaml", pair())
            ended = self.ended("run", name, redirection + ("" if ">&- 2" in redirection else " >/dev/null"))
            self.assertEqual(ended, DONE, redirection)
            self.assert_record(Record(self.place.join(name + "-run", "record.h5")), 5)


class Stages(FaultCase):
    """A stage that does not do what it should; the coupling behind it is not started."""

    def stage(self, script, name, rest="", **options):
        script = self.place.write(name + ".py", script)
        stage = "  first: {run: command, command: ['%s', '%s']%s}" % (PYTHON, script, rest)
        text = pair(stages=stage).replace("couple: {run: coupling}", "couple: {run: coupling, after: [first]}")
        return self.run_workflow(text, name=name, **options)

    def test_it_fails(self):
        ended = self.stage("import sys; print('no mesh today'); sys.exit(3)", "stage_exit")
        self.assert_failed(ended, PARTICIPANT, "failed", windows=0)
        self.assert_said(ended, "first", "exit status 3", "no mesh today")
        self.assertFalse(os.path.exists(ended.path("logs", "left.log")))

    def test_it_hangs(self):
        ended = self.stage("import time; print('thinking', flush=True); time.sleep(1000)", "stage_hang",
                           ", deadline: 0.5 s")
        self.assert_failed(ended, PARTICIPANT, "failed", windows=0)
        self.assert_said(ended, "first", "0.5 s")

    def test_it_does_not_make_what_it_promised(self):
        ended = self.stage("print('all is well')", "stage_makes", ", makes: [box.msh]")
        self.assert_failed(ended, PARTICIPANT, "failed", windows=0)
        self.assert_said(ended, "first", "box.msh", "all is well")


class Directory(FaultCase):
    """The run directory cannot be had."""

    def setUp(self):
        self.workflow = self.place.write("pair.yaml", pair())

    def refused(self, out, *words):
        ended = self.sandglass("run", self.workflow, "--out", out)
        self.assert_code(ended, ENVIRONMENT)
        self.assert_said(ended, *words)
        return ended

    def test_below_a_file_or_where_nothing_can_be_made(self):
        file = self.place.write("file", "")
        self.refused(file, file)
        self.refused(os.path.join(file, "run"), os.path.join(file, "run"))
        self.refused("/proc/sandglass-run", "/proc/sandglass-run")
        self.refused(self.place.join("x" * 300), "name too long")

    def test_it_was_used_already(self):
        for name in ("once", "thing/by/somebody.txt"):
            self.place.write("used/" + name, "keep me")
        before = sorted(os.listdir(self.place.join("used")))
        self.refused(self.place.join("used"), "already used", "--out")
        self.assertEqual(sorted(os.listdir(self.place.join("used"))), before)
        self.assertEqual(read(self.place.join("used", "once")), "keep me")

    def test_it_is_in_use(self):
        self.place.write("slow.yaml", pair(right=("advance", "late=0.2"), windows=1000, answered=False))
        first = self.place.start("run", self.place.join("slow.yaml"), out="busy")
        self.assertTrue(wait_until(lambda: windows_of(first)))
        status = self.sandglass("status", first.directory)
        self.assert_code(status, DONE)
        second = self.refused(first.directory, first.directory, "in use")
        self.assertNotIn("Traceback", second.err)
        windows = windows_of(first)
        self.assertTrue(wait_until(lambda: windows_of(first) > windows, SOON), "the first run was disturbed")
        first.signal(signal.SIGINT)
        self.assert_failed(first.wait(SOON), INTERRUPTED, "interrupted")

    def test_it_is_locked_before_anything_is_in_it(self):
        os.makedirs(self.place.join("locked"))
        with open(self.place.join("locked", "lock"), "w") as file:
            fcntl.lockf(file, fcntl.LOCK_EX)
            self.refused(self.place.join("locked"), "in use")
        # Nobody holds it any more.
        ended = self.sandglass("run", self.workflow, out="locked")
        self.assert_code(ended, DONE)


def mounted(kind):
    """Whether a file system of ours may be mounted here; containers often forbid it, even to root."""
    folder = kind.join("probe")
    os.makedirs(folder, exist_ok=True)
    tried = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", folder], capture_output=True)
    if tried.returncode == 0:
        subprocess.run(["umount", folder], check=True)
    return tried.returncode == 0


class Disk(FaultCase):
    """Small and read-only disks: a tmpfs of our own."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        if not shutil.which("mount") or not mounted(cls.place):
            raise unittest.SkipTest("no file system may be mounted here, so no disk can be filled")

    def mount(self, name, options):
        folder = self.place.join(name)
        os.makedirs(folder)
        subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", folder], check=True)
        return folder

    def test_read_only(self):
        folder = self.mount("fixed", "size=1m,ro")
        ended = self.sandglass("run", self.place.write("pair.yaml", pair()), "--out", os.path.join(folder, "run"))
        self.assert_code(ended, ENVIRONMENT)
        self.assert_said(ended, os.path.join(folder, "run"), "Read-only")

    def test_full_before_the_first_window(self):
        folder = self.mount("tiny", "size=200k")
        ended = self.sandglass("run", self.place.write("pair.yaml", pair(length=20000)), "--out",
                               os.path.join(folder, "run"))
        self.assert_code(ended, ENVIRONMENT)
        self.assert_said(ended, "No space left")

    def test_full_while_it_records(self):
        length, windows = 10000, 60  # 0.24 MB a window, 14 MB in all, and half a megabyte of slots
        self.mount("small", "size=4m")
        # The solvers write nothing but their logs; the record grows by a window at a time until the disk is full.
        ended = self.sandglass("run", self.place.write("pair.yaml",
                                                       pair(length=length, windows=windows, answered=False)),
                               out="small/run")
        self.assert_code(ended, ENVIRONMENT)
        self.assert_said(ended, "No space left", "record")
        record = ended.record
        self.assertGreater(record.windows, 3)
        self.assertLess(record.windows, 20)
        self.assert_record(record, record.windows, length, answered=False)
        result = ended.result
        self.assertEqual((result["status"], result["exit_code"], result["windows"]),
                         ("environment", ENVIRONMENT, record.windows))

    def test_full_because_of_somebody_else(self):
        folder = self.mount("shared", "size=2m")
        text = pair(right=("advance", "late=0.05"), windows=500, length=300, answered=False)
        started = self.place.start("run", self.place.write("slow.yaml", text), out="shared/run")
        self.assertTrue(wait_until(lambda: windows_of(started) > 2))
        with open(os.path.join(folder, "somebody"), "wb", buffering=0) as file:
            try:
                while True:
                    file.write(b"\0" * 4096)
            except OSError:
                pass
        ended = started.wait(30)
        self.assert_code(ended, ENVIRONMENT)
        self.assert_said(ended, "No space left")
        self.assert_record(ended.record, ended.record.windows, 300, answered=False)
        # What cannot be written whole is not written at all.
        for name in os.listdir(ended.directory):
            if name.endswith(".json"):
                json.loads(read(ended.path(name)))


if __name__ == "__main__":
    unittest.main()
