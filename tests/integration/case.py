"""Whole-program tests: the built binary in a temporary folder, what it leaves behind, and that no process stays.

Environment: SANDGLASS_BINARY, the binary; SANDGLASS_HOME, the checkout with templates/, workflows/ and data/.
Every process that a test starts carries a mark of that test in its environment and hands it on, so what is left of it
is found in /proc, whoever its parent and whatever its process group has become.
"""

import concurrent.futures
import html.parser
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import h5py

HOME = os.path.realpath(os.environ.get("SANDGLASS_HOME") or os.path.join(os.path.dirname(__file__), "..", ".."))
BINARY = os.path.realpath(os.environ["SANDGLASS_BINARY"])  # the test means nothing without it
SPHERE = os.path.join(HOME, "workflows", "icy_stokes_sphere.yaml")
SCRIPTED = os.path.join(HOME, "tests", "faults", "scripted_participant.py")
PYTHON = "/usr/bin/python3"  # Debian's, for which h5py and YADE are made

LONG = 120.0  # s, for what takes seconds: only a hang is meant to be caught
SOON = 5.0    # s, for what must end at once

DONE, USAGE, REFUSED, PARTICIPANT, UNSTABLE, MISMATCH, ENVIRONMENT, INTERRUPTED = 0, 2, 3, 4, 5, 6, 7, 130


def read(path, mode="r"):
    with open(path, mode) as file:
        return file.read()


def write(path, text):
    with open(path, "w") as file:
        file.write(text)
    return path


def wait_until(condition, seconds=LONG, every=0.01):
    """What `condition` returned when it was first true; its last answer when the time is over."""
    end = time.monotonic() + seconds
    while not (answer := condition()) and time.monotonic() < end:
        time.sleep(every)
    return answer


def text_of(value):
    """An attribute's text, whichever of HDF5's kinds of string it is."""
    return value.decode() if isinstance(value, bytes) else value


class Record:
    """record.h5 by its documented format (orchestrator/record/README.md), complete windows only."""

    def __init__(self, path):
        with h5py.File(path, "r") as file:
            self.filetype = text_of(file.attrs["filetype"])
            self.version = list(file.attrs["version"])
            self.windows = int(file["windows"][0])
            self.rows = len(file["time"])
            self.time = file["time"][: self.windows]
            self.iterations = file["iterations"][: self.windows]
            self.fields = {name: file["fields"][name][: self.windows] for name in file["fields"]}
            self.attributes = {name: {key: text_of(value) for key, value in file["fields"][name].attrs.items()}
                               for name in file["fields"]}
            self.timings = {name: file["timings"][name][: self.windows] for name in file["timings"]}

    def __getitem__(self, field):
        return self.fields[field]


class Ended:
    """One call of the program: its exit status, what it printed, and what lies in its run directory."""

    def __init__(self, arguments, code, out, err, directory):
        self.arguments, self.code, self.out, self.err, self.directory = arguments, code, out, err, directory

    def path(self, *names):
        return os.path.join(self.directory, *names)

    @property
    def result(self):
        return json.loads(read(self.path("result.json")))

    @property
    def record(self):
        return Record(self.path("record.h5"))

    def quantity(self, name):
        return self.result["quantities"][name]["value"]

    def comparison(self, name):
        found = [one for one in self.result["comparisons"] if one["name"] == name]
        if len(found) != 1:
            raise AssertionError("%d comparisons are named '%s': %s" % (len(found), name, self))
        return found[0]

    def __str__(self):
        return "sandglass %s\nexit status %s\n%s%s" % (" ".join(self.arguments), self.code, self.out, self.err)


class Started:
    """A call that is still running."""

    def __init__(self, process, arguments, directory):
        self.process, self.arguments, self.directory = process, arguments, directory

    def path(self, *names):
        return os.path.join(self.directory, *names)

    def signal(self, number):
        self.process.send_signal(number)

    def running(self):
        return self.process.poll() is None

    def wait(self, seconds=LONG):
        """Ends as soon as the program has, not when the last holder of its output has."""
        try:
            code = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise AssertionError("did not end within %g s: sandglass %s" % (seconds, " ".join(self.arguments)))
        texts = []
        for file in (self.process.stdout_file, self.process.stderr_file):
            file.seek(0)
            texts.append(file.read())
            file.close()
        return Ended(self.arguments, code, *texts, self.directory)


class Place:
    """A temporary folder; programs run in it, and are found again by their mark."""

    def __init__(self):
        # The real path: programs see themselves there, whatever links lead to it.
        self.path = os.path.realpath(tempfile.mkdtemp(prefix="sandglass-test-"))
        self.mark = os.path.basename(self.path)

    def join(self, *names):
        return os.path.join(self.path, *names)

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.join(name)), exist_ok=True)
        return write(self.join(name), text)

    def start(self, *arguments, out=None, home=None, environment=None, directory=None):
        """Starts the program here; with `out`, the run directory of that name. `environment` adds (None: removes)."""
        arguments = [str(one) for one in arguments]
        if out is not None:
            arguments += ["--out", self.join(out)]
        variables = dict(os.environ, SANDGLASS_HOME=home or HOME, SANDGLASS_TEST=self.mark)
        for name, value in (environment or {}).items():
            variables.pop(name, None)
            if value is not None:
                variables[name] = value
        # Files, not pipes: a process left behind must not hold up the test that looks for it.
        out_file, err_file = (tempfile.TemporaryFile("w+", errors="replace") for _ in range(2))
        process = subprocess.Popen([BINARY, *arguments], cwd=directory or self.path, env=variables,
                                   stdin=subprocess.DEVNULL,
                                   stdout=out_file, stderr=err_file, start_new_session=True)
        process.stdout_file, process.stderr_file = out_file, err_file
        return Started(process, arguments, self.join(out or ""))

    def sandglass(self, *arguments, seconds=LONG, **options):
        return self.start(*arguments, **options).wait(seconds)

    def processes(self):
        """Numbers and command lines of all living processes that carry the mark."""
        mark = b"SANDGLASS_TEST=" + self.mark.encode()
        found = {}
        for name in filter(str.isdigit, os.listdir("/proc")):
            try:
                if mark in read("/proc/%s/environ" % name, "rb").split(b"\0"):
                    found[int(name)] = read("/proc/%s/cmdline" % name, "rb").replace(b"\0",
                                                                                     b" ").decode(errors="replace")
            except OSError:
                continue  # it has gone, or is somebody else's
        return found

    def left_over(self, seconds=2.0):
        """Processes that are still there after a moment: death by SIGKILL takes one."""
        wait_until(lambda: not self.processes(), seconds)
        return self.processes()

    def close(self):
        for process in self.processes():
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
        shutil.rmtree(self.path, ignore_errors=True)


class Case(unittest.TestCase):
    """A test case with a place of its own for all its tests. After each, no process may be left."""

    maxDiff = None

    @classmethod
    def setUpClass(cls):
        cls.place = Place()
        cls.addClassCleanup(cls.place.close)

    def tearDown(self):
        self.assert_nothing_left()

    def sandglass(self, *arguments, **options):
        return self.place.sandglass(*arguments, **options)

    def run_workflow(self, text, *arguments, name="scene", **options):
        """Writes a workflow and runs it; the run directory is `name`-run."""
        path = self.place.write(name + ".yaml", text)
        return self.sandglass("run", path, *arguments, out=name + "-run", **options)

    def assert_nothing_left(self):
        left = self.place.left_over()
        for process in left:
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.assertEqual(left, {}, "processes were left behind")

    def assert_code(self, ended, code):
        self.assertEqual(ended.code, code, str(ended))

    def assert_refused(self, ended, *words, file=None):
        """Exit status 3, each problem at file:line:column, and the words in what was said."""
        self.assert_code(ended, REFUSED)
        self.assertRegex(ended.err, r"(?m)^sandglass: [^\n]*%s:[1-9]\d*:[1-9]\d*: " % re.escape(file or ""), str(ended))
        self.assert_said(ended, *words)

    def assert_said(self, ended, *words):
        for word in words:
            self.assertIn(word, ended.err, str(ended))

    def assert_failed(self, ended, code, status, windows=None):
        """The exit status, and a result.json that tells the same."""
        self.assert_code(ended, code)
        result = ended.result
        self.assertEqual((result["format"], result["status"], result["exit_code"]), (1, status, code), result)
        self.assertIn(result["error"].splitlines()[0], ended.err)
        if windows is not None:
            self.assertEqual(result["windows"], windows, result)
        for key in ("wall_time_s", "windows", "overhead_s_per_window", "quantities", "comparisons", "left_out"):
            self.assertIn(key, result)


def together(*calls):
    """Calls functions two at a time, as many as the smallest machine we mean has cores; their answers in order."""
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        return [one.result() for one in [pool.submit(call) for call in calls]]


def sets(**parameters):
    """--set NAME=VALUE for every parameter."""
    return [word for name, value in parameters.items() for word in ("--set", "%s=%s" % (name, value))]


def copy_of_home(place, name="home"):
    """A SANDGLASS_HOME of one's own, to put templates into or to change them."""
    home = place.join(name)
    for folder in ("templates", "data"):
        shutil.copytree(os.path.join(HOME, folder), os.path.join(home, folder),
                        ignore=shutil.ignore_patterns("plugin", "__pycache__"))
    return home


def change(path, *replacements):
    """Replaces texts in a file, each of which must be there."""
    text = read(path)
    for old, new in replacements:
        if old not in text:
            raise AssertionError("'%s' is not in %s" % (old, path))
        text = text.replace(old, new)
    return write(path, text)


class Loads(html.parser.HTMLParser):
    """What a page would load when it is opened, beyond itself: `outside` must stay empty."""

    LOADING = {"src", "srcset", "data", "poster", "background", "action", "formaction", "xlink:href", "manifest"}

    def __init__(self, text):
        super().__init__()
        self.outside = []
        self.tags = {}
        self._style = False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags[tag] = self.tags.get(tag, 0) + 1
        self._style = tag == "style"
        for name, value in attributes:
            loads = name in self.LOADING or (name == "href" and tag not in ("a", "area"))
            if loads and value and not value.startswith(("data:", "#")):
                self.outside.append("%s %s=%s" % (tag, name, value[:80]))
            if name == "style":
                self._look_at_style(value or "")
            if tag == "meta" and name == "http-equiv" and (value or "").lower() == "refresh":
                self.outside.append("meta refresh")

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self._style = False

    def handle_endtag(self, tag):
        self._style = False

    def handle_data(self, text):
        if self._style:
            self._look_at_style(text)

    def _look_at_style(self, text):
        self.outside += [url for url in re.findall(r"url\(\s*['\"]?([^)'\"]*)", text)
                         if not url.startswith(("data:", "#"))]
        self.outside += re.findall(r"@import[^;]*", text)
