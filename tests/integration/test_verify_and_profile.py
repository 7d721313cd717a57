"""What a run directory says of itself afterwards: its crate, whether it was altered, and where its time went."""

import datetime
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import unittest

from case import (DONE, ENVIRONMENT, HOME, MISMATCH, SPHERE, USAGE, Case, Record, change, copy_of_home, read, sets, wait_until,
                  write)

PAIR = os.path.join(HOME, "templates", "bench", "pair.yaml")
PROVENANCE = os.path.join(HOME, "tests", "provenance")


def validate(directory):
    """roc-validator's issues with a run directory; None where it cannot be had, and why."""
    folder = os.path.join(HOME, ".build", "provenance")
    python = os.path.join(folder, "bin", "python")
    requirements = os.path.join(PROVENANCE, "requirements.txt")
    mark = os.path.join(folder, "installed")
    if not (os.path.exists(mark) and read(mark) == read(requirements)):
        made = subprocess.run([sys.executable, "-m", "venv", folder], capture_output=True, text=True)
        if made.returncode == 0:
            made = subprocess.run([python, "-m", "pip", "install", "-q", "--disable-pip-version-check", "--require-hashes",
                                   "-r", requirements], capture_output=True, text=True)
        if made.returncode != 0:
            raise unittest.SkipTest("roc-validator cannot be installed from PyPI here: " + made.stderr[-300:])
        write(mark, read(requirements))
    return subprocess.run([python, os.path.join(PROVENANCE, "validate_crate.py"), directory], capture_output=True, text=True)


class Finished(Case):
    """One run of two Python programs, 30 windows; each test works on a copy."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.ended = cls.place.sandglass("run", PAIR, "--set", "end_time=30 ms", out="original")
        assert cls.ended.code == DONE, str(cls.ended)
        cls.crate = json.loads(read(cls.ended.path("ro-crate-metadata.json")))
        cls.entities = {entity["@id"]: entity for entity in cls.crate["@graph"]}

    def copy(self, name):
        return shutil.copytree(self.ended.directory, self.place.join(name))

    def of_type(self, kind):
        return [one for one in self.crate["@graph"] if kind == one["@type"] or kind in one["@type"]]

    @staticmethod
    def ids(value):
        return [one["@id"] for one in (value if isinstance(value, list) else [value])]


class Verify(Finished):
    def verify(self, directory, code, *words):
        ended = self.sandglass("verify", directory)
        self.assert_code(ended, code)
        for word in words:
            self.assertIn(word, ended.out + ended.err)
        return ended

    def test_a_run_as_it_was_left(self):
        crate = read(self.ended.path("ro-crate-metadata.json"), "rb")
        ended = self.verify(self.ended.directory, DONE, "every file is what the run left", hashlib.sha256(crate).hexdigest())
        self.assertNotIn("altered", ended.out)
        self.assertNotIn("changed since", ended.out)
        self.verify(self.copy("moved"), DONE)

    def test_what_was_altered_is_missing_or_was_added(self):
        script = [name for name in self.entities if name.startswith("scripts/")][0]
        for name, change, words in (
                ("script", lambda run: write(os.path.join(run, script), "print()"), ("altered", script)),
                ("workflow", lambda run: write(os.path.join(run, "workflow.yaml"), "x"), ("altered", "workflow.yaml")),
                ("byte", self.change_one_byte_of_the_record, ("altered", "record.h5")),
                ("gone", lambda run: os.remove(os.path.join(run, "result.json")), ("missing", "result.json")),
                ("more", lambda run: write(os.path.join(run, "scripts", "other.py"), ""), ("added", "scripts/other.py"))):
            with self.subTest(name):
                run = self.copy(name)
                change(run)
                self.verify(run, MISMATCH, *words)

    @staticmethod
    def change_one_byte_of_the_record(run):
        with open(os.path.join(run, "record.h5"), "r+b") as file:
            file.seek(-1, os.SEEK_END)
            byte = file.read(1)
            file.seek(-1, os.SEEK_END)
            file.write(bytes([byte[0] ^ 1]))

    def test_a_report_made_again_is_no_alteration_but_hides_none(self):
        run = self.copy("again")
        self.assert_code(self.sandglass("report", run), DONE)
        self.verify(run, DONE)
        write(os.path.join(run, "workflow.yaml"), "x")
        self.assert_code(self.sandglass("report", run), DONE)
        self.verify(run, MISMATCH, "altered", "workflow.yaml")

    def test_templates_that_changed_since_are_named(self):
        home = self.place.join("home")
        os.makedirs(os.path.join(home, "data"))
        shutil.copytree(os.path.join(HOME, "templates"), os.path.join(home, "templates"))
        write(os.path.join(home, "templates", "bench", "echo.py"), "pass")
        ended = self.sandglass("verify", self.ended.directory, home=home)
        self.assert_code(ended, DONE)
        self.assertIn("changed since  templates/bench/echo.py", ended.out)

    def test_no_crate_or_a_broken_one(self):
        run = self.copy("broken")
        for text in ("", "{", "[]", '{"@graph": 3}', '{"@graph": [{"sha256": 3, "@id": [], "@type": "File"}]}'):
            write(os.path.join(run, "ro-crate-metadata.json"), text)
            self.verify(run, ENVIRONMENT, "cannot be understood")
        os.remove(os.path.join(run, "ro-crate-metadata.json"))
        self.verify(run, ENVIRONMENT, "resume")
        self.verify(self.place.join("nowhere"), ENVIRONMENT)


class Crate(Finished):
    """The profile's required properties, tested here; and by roc-validator where it can be had."""

    def test_the_description_and_the_root(self):
        self.assertEqual(self.ids(self.entities["ro-crate-metadata.json"]["about"]), ["./"])
        root = self.entities["./"]
        for profile in ("process", "workflow", "provenance"):
            self.assertIn("https://w3id.org/ro/wfrun/%s/0.5" % profile, self.ids(root["conformsTo"]))
        self.assertEqual(self.ids(root["mainEntity"]), ["workflow.yaml"])
        for identifier in self.ids(root["hasPart"]) + self.ids(root["mentions"]):
            self.assertIn(identifier, self.entities)

    def test_every_file_with_its_digest(self):
        for name in ("record.h5", "result.json", "provenance.json", "workflow.yaml", "workflow.json", "report.html"):
            self.assertEqual(self.entities[name]["sha256"],
                             hashlib.sha256(read(self.ended.path(name), "rb")).hexdigest(), name)
        self.assertFalse([name for name in self.entities if name.startswith(("exchange", "work/", "lock", "status"))])

    def test_the_workflow_its_parameters_and_steps(self):
        workflow = self.entities["workflow.yaml"]
        self.assertEqual(set(workflow["@type"]), {"File", "SoftwareSourceCode", "ComputationalWorkflow", "HowTo"})
        values = {}
        for identifier in self.ids(workflow["input"]):
            parameter = self.entities[identifier]
            value = self.entities[self.ids(parameter["workExample"])[0]]
            self.assertEqual((parameter["@type"], value["@type"]), ("FormalParameter", "PropertyValue"))
            self.assertTrue(parameter["additionalType"])
            values[value["name"]] = value["value"]
        self.assertEqual(values, {"window": "1 ms", "end_time": "0.03 s"})
        tools = self.ids(workflow["hasPart"])
        for identifier in self.ids(workflow["step"]):
            step = self.entities[identifier]
            self.assertEqual(step["@type"], "HowToStep")
            self.assertIn(self.ids(step["workExample"])[0], tools)
        self.assertEqual([self.entities[one]["name"] for one in self.ids(workflow["step"])], ["there", "back"])

    def test_actions(self):
        run = self.entities["#run"]
        self.assertEqual(self.ids(run["instrument"]), ["workflow.yaml"])
        self.assertIn("record.h5", self.ids(run["result"]))
        organize = self.of_type("OrganizeAction")
        self.assertEqual([self.ids(one["result"]) for one in organize], [["#run"]])
        controls = [self.entities[one] for one in self.ids(organize[0]["object"])]
        self.assertEqual(len(controls), 2)
        scripts = set()
        for control in controls:
            self.assertEqual(self.entities[self.ids(control["instrument"])[0]]["@type"], "HowToStep")
            for identifier in self.ids(control["object"]):
                action = self.entities[identifier]
                self.assertEqual(action["@type"], "CreateAction")
                self.assertEqual(self.entities[self.ids(action["instrument"])[0]]["@type"], "SoftwareApplication")
                self.assertIn("windows 1 to 30", action["name"])
                scripts |= set(self.ids(action["object"]))
        self.assertEqual(scripts, {name for name in self.entities if name.startswith("scripts/")})

    def test_roc_validator(self):
        checked = validate(self.ended.directory)
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        broken = self.copy("invalid")
        crate = json.loads(read(os.path.join(broken, "ro-crate-metadata.json")))
        crate["@graph"] = [one for one in crate["@graph"] if one["@type"] != "ControlAction"]
        write(os.path.join(broken, "ro-crate-metadata.json"), json.dumps(crate))
        self.assertEqual(validate(broken).returncode, 1, "the validator accepts what it must not")


class ScriptsOfWindows(Case):
    """A sphere whose window script differs from window to window, killed once: each window's script is found in the crate."""

    EVERY, WINDOWS = 5, 23

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        home = copy_of_home(cls.place)
        change(os.path.join(home, "templates", "yade", "settling_sphere_window.py"),
               ("state = O.bodies[grain].state", "import time\n"
                "time.sleep(0.1)  # the kill comes between the first checkpoint and the end\n"
                "this_window = {{window.index}}\nstate = O.bodies[grain].state"))
        started = cls.place.start("run", SPHERE, *sets(checkpoint_every=cls.EVERY, end_time="%d ms" % cls.WINDOWS),
                                  out="sphere", home=home)
        folder = started.path("checkpoints", "%09d" % cls.EVERY)
        assert wait_until(lambda: os.path.isdir(folder))
        started.signal(signal.SIGKILL)
        started.wait(30)
        cls.place.left_over()
        ended = cls.place.sandglass("resume", started.directory, home=home)
        assert ended.code == DONE and "nothing to resume" not in ended.out, str(ended)
        cls.directory = started.directory
        graph = json.loads(read(started.path("ro-crate-metadata.json")))["@graph"]
        cls.entities = {entity["@id"]: entity for entity in graph}

    def actions_of(self, step):
        control = self.entities["#control-" + step]
        self.assertEqual(Finished.ids(control["instrument"]), ["#step-" + step])
        return [self.entities[one] for one in Finished.ids(control["object"])]

    def action_of(self, step, window):
        """The one action whose interval holds the window."""
        found = [one for one in self.actions_of(step)
                 if (span := [int(word) for word in one["name"].split("windows ")[1].split(" to ")]) and span[0] <= window <= span[1]]
        self.assertEqual(len(found), 1)
        return found[0]

    def scripts_of(self, step, window):
        scripts = []
        for identifier in Finished.ids(self.action_of(step, window)["object"]):
            entity = self.entities[identifier]
            named = [self.entities[one] for one in Finished.ids(entity.get("additionalProperty", []))]
            spans = [word for one in named if one["name"] == "windows of " + step for word in one["value"].split()]
            if not spans or any(int(first) <= window <= int(last or first)
                                for first, _, last in (span.partition("-") for span in spans)):
                scripts.append(entity)
        return scripts

    def test_nothing_it_used_has_changed_since(self):
        """YADE, FreeFEM, the plugin, the changed template: all found where they are."""
        ended = self.sandglass("verify", self.directory, home=self.place.join("home"))
        self.assert_code(ended, DONE)
        self.assertNotIn("changed since", ended.out)

    def test_the_script_of_every_window(self):
        for window in range(1, self.WINDOWS + 1):
            texts = [read(os.path.join(self.directory, one["@id"])) for one in self.scripts_of("grains", window)]
            self.assertEqual(len(texts), 2, "the set-up's, and the window's own")
            self.assertEqual([text.count("this_window = %d\n" % window) for text in texts].count(1), 1, window)
            self.assertEqual([one["name"].split("/")[1].split("-")[0] for one in self.scripts_of("fluid", window)],
                             ["stokes_axisymmetric"])

    def test_an_action_has_its_own_times_and_scripts(self):
        actions = self.actions_of("grains")
        self.assertEqual(len(actions), -(-self.WINDOWS // self.EVERY))
        times = [datetime.datetime.fromisoformat(one[when]) for one in actions for when in ("startTime", "endTime")]
        self.assertEqual(times, sorted(times))
        timings = Record(os.path.join(self.directory, "record.h5")).timings
        for number, time in enumerate(times):
            window = (number + 1) // 2 * self.EVERY if number % 2 == 0 else min((number + 1) // 2 * self.EVERY, self.WINDOWS) - 1
            # The crate's words go to the microsecond.
            self.assertAlmostEqual(time.timestamp(), timings["ended" if number % 2 else "began"][window], delta=2e-6)
        run = self.entities["#run"]
        self.assertLessEqual(datetime.datetime.fromisoformat(run["startTime"]), times[0])
        self.assertEqual([len(one["object"]) for one in actions], [self.EVERY + 1] * 4 + [self.WINDOWS % self.EVERY + 1])
        analysis = self.entities["#stage-analyse"]
        self.assertGreaterEqual(datetime.datetime.fromisoformat(analysis["startTime"]), times[-1])

    def test_roc_validator(self):
        checked = validate(self.directory)
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)


class Profile(Case):
    def profile(self, directory, windows):
        trace = self.place.join("trace.json")
        ended = self.sandglass("profile", directory, "--trace", trace)
        self.assert_code(ended, DONE)
        for word in ("there", "back", "waiting", "exchange", "render", "record", "%d windows" % windows):
            self.assertIn(word, ended.out)
        self.assertNotIn("stage couple", ended.out)  # that is the windows, and the start
        return json.loads(read(trace))["traceEvents"]

    def test_a_run_that_came_to_its_end(self):
        ended = self.sandglass("run", PAIR, "--set", "end_time=20 ms", out="whole")
        events = self.profile(ended.directory, 20)
        lines = {event["tid"]: event["args"]["name"] for event in events if event["ph"] == "M"}
        self.assertEqual(lines, {0: "orchestrator", 1: "there", 2: "back"})
        slices = [event for event in events if event["ph"] == "X"]
        self.assertEqual({event["args"]["windows"] for event in slices}, {str(n) for n in range(1, 21)})
        there = sum(event["dur"] for event in slices if event["tid"] == 1)
        self.assertAlmostEqual(there * 1e-6, sum(ended.record.timings["there"]), delta=1e-9)
        last = 0
        for event in sorted(slices, key=lambda event: event["ts"]):
            self.assertGreaterEqual(event["ts"], last - 1e-3, "nothing overlaps where solvers work in turn")
            last = event["ts"] + event["dur"]

    def test_a_run_that_was_killed(self):
        started = self.place.start("run", PAIR, "--set", "end_time=1000 s", out="killed")
        self.assertTrue(wait_until(lambda: os.path.exists(started.path("record.h5")) and self.windows(started) > 100))
        started.signal(signal.SIGKILL)
        started.wait()
        self.assert_nothing_left()
        self.profile(started.directory, self.windows(started))

    def windows(self, started):
        import h5py

        with h5py.File(started.path("record.h5"), "r") as file:
            return int(file["windows"][0])

    def test_long_runs_share_slices(self):
        ended = self.sandglass("run", PAIR, "--set", "end_time=50 s", out="long")
        self.assert_code(ended, DONE)
        self.assertLess(len(self.profile(ended.directory, 50000)), 200000)

    def test_what_is_no_run(self):
        self.assert_code(self.sandglass("profile", self.place.path), ENVIRONMENT)


class Bench(Case):
    def test_it_measures_and_says_with_what(self):
        """The figures are not asserted: they depend on the machine."""
        ended = self.sandglass("bench", "--short", "exchange", "record", "--folder", self.place.path)
        self.assert_code(ended, DONE)
        for word in ("cores", "load", "10 doubles", "1000 doubles", "100000 doubles", "without record", "with record",
                     "bare pipe", "GB/s"):
            self.assertIn(word, ended.out)
        self.assertEqual(os.listdir(self.place.path), [])


if __name__ == "__main__":
    unittest.main()
