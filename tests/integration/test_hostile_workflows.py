"""Workflows that are broken, careless or malicious: refused with a place, or carried out as the data that they are.

Every participant and stage here would leave the file `started` behind, and every injected text the file `pwned`.
"""

import os
import signal
import unittest

from case import DONE, ENVIRONMENT, PARTICIPANT, PYTHON, REFUSED, SPHERE, UNSTABLE, USAGE, Case, copy_of_home, read, \
    sets, wait_until

QUICK = 10.0  # s; a refusal takes milliseconds, but the machine may be busy

PARAMETERS = """\
parameters:
  window: {value: 1 ms, unit: ms, above: 0, meaning: time between exchanges}
  length: {value: 2 mm, unit: mm, above: 0}
  number: {value: 3, type: count, minimum: 1}
  kind: {value: soft, choices: [soft, hard]}
  words: {value: "some words", type: text}
"""
STAGES = "stages:\n  couple: {run: coupling}\n"
PARTICIPANTS = """\
participants:
  left: {solver: command, command: [%s, STARTED]}
  right: {solver: command, command: [%s, STARTED]}
""" % (PYTHON, PYTHON)
COUPLING = """\
coupling:
  scheme: serial-explicit
  window: $window
  end: 5 ms
  order: [left, right]
  fields:
    force: {unit: N, shape: [3], from: left, to: right}
    motion: {unit: m, shape: [3], from: right, to: left}
"""
HEAD = "sandglass: 1\nname: scene\n"
SCENE = HEAD + PARAMETERS + STAGES + PARTICIPANTS + COUPLING

HOSTILE_TEXTS = (
    "'); import os; os.system(\"touch pwned\") #",
    "\"); import os; os.system('touch pwned') #",
    "'''); import os; os.system('touch pwned') #",
    "\\'); import os; os.system(\"touch pwned\") #",
    "\\\"); exec(\"touch pwned\"); //",
    "\"; exec(\"touch pwned\"); string b = \"",
    "\"; System \"touch pwned\"; //",
    "$(touch pwned) `touch pwned` ; touch pwned",
    "{{length}} {{#kind}} {{> yade/settling_sphere.py}} {{{x}}}",
    "{0} %s %(x)s %n ${HOME} ~",
    "*/ exec(\"touch pwned\"); /* // #",
    "grüße ≤ 安全 🙂",
)


def memory(process):
    """Bytes that the process has in memory."""
    try:
        return int(read("/proc/%d/statm" % process).split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0


class HostileCase(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.started = cls.place.write("leaves_a_trace.py", "open(%r, 'w').close()\n" % cls.place.join("started"))
        cls.count = 0

    def tearDown(self):
        super().tearDown()
        for folder, _, files in os.walk(self.place.path):
            self.assertNotIn("pwned", files, folder)

    def attempt(self, text, *arguments, verb="run", **options):
        type(self).count += 1
        name = "scene%d" % self.count
        path = self.place.write(name + ".yaml", "")
        with open(path, "wb") as file:
            file.write(text.replace("STARTED", self.started).encode() if isinstance(text, str) else text)
        self.out = self.place.join(name)
        words = [verb, path, *arguments] + (["--out", self.out] if verb == "run" else [])
        return self.sandglass(*words, seconds=QUICK, **options)

    def assert_not_started(self, ended):
        self.assertFalse(os.path.exists(self.place.join("started")), str(ended))
        self.assertFalse(os.path.exists(self.out), "a run directory was made for a refused workflow")

    def refused(self, text, *words, arguments=(), line=None, column=None, where=None, **options):
        """Refused by `run` and `check` alike, before anything was started or made; `where`: if not in the text."""
        ended = self.attempt(text, *arguments, **options)
        self.assert_code(ended, REFUSED)
        self.assert_not_started(ended)
        name = os.path.basename(self.out) + ".yaml"
        place = r"%s:%s:%s: " % (name, line or r"[1-9]\d*", column or r"[1-9]\d*")
        self.assertRegex(ended.err, where or place, str(ended))
        self.assert_said(ended, *words)
        for bad in ("Traceback", "yaml-cpp", "terminate", "exception"):
            self.assertNotIn(bad, ended.err)
        checked = self.attempt(text, *arguments, verb="check", **options)
        self.assert_code(checked, REFUSED)
        return ended

    def replaced(self, old, new, text=SCENE):
        self.assertIn(old, text)
        return text.replace(old, new, 1)

    def place_of(self, text, words):
        """Line and column of these words in a text, from 1."""
        before, found, _ = text.partition(words)
        self.assertTrue(found)
        return before.count("\n") + 1, len(before) - (before.rfind("\n") + 1) + 1


class Malformed(HostileCase):
    """Not YAML, or more YAML than data needs."""

    def test_the_scene_itself_is_well(self):
        ended = self.attempt(SCENE, verb="check")
        self.assert_code(ended, DONE)

    def test_it_would_be_noticed_if_a_solver_started(self):
        ended = self.attempt(SCENE)
        self.assert_code(ended, PARTICIPANT)
        self.assertTrue(os.path.exists(self.place.join("started")))
        os.remove(self.place.join("started"))

    def test_not_yaml(self):
        for text in ("", "\n\n", "# nothing but words\n", "{", "a: [1, 2", "a: b: c", "- just\n- a list\n",
                     "just words", "42",
                     "a: 'no end", "\ta: 1", "a: 1\n b: 2", "%YAML 9.9\n---\na: 1", "? \n: x", "a: !!binary zzz", "&",
                     "*", "@a: 1",
                     "sandglass: 1\nname: [", "sandglass: 1\nname: x\nstages: {couple: {run: coupling}\n",
                     "---\n...\n---\n"):
            with self.subTest(text):
                self.refused(text)

    def test_not_text(self):
        for text in (b"\x00\x01\x02\xff", SCENE.encode("utf-16"), b"sandglass: 1\nname: \xff\xfe\n",
                     b"\x7fELF" + bytes(100),
                     b"sandglass: 1\nname: a\x00b\n", b"a: " + b"\xc3"):
            with self.subTest(text[:20]):
                self.refused(text)

    def test_anchors_and_what_grows_from_them(self):
        self.refused(self.replaced("{value: 2 mm, unit: mm, above: 0}", "&a {value: 2 mm, unit: mm, above: 0}"), line=5)
        self.refused(self.replaced("{value: 2 mm, unit: mm, above: 0}", "*a"))
        laughs = "".join("l%d: &l%d [%s]\n" % (n, n, ", ".join(["*l%d" % (n - 1)] * 9)) for n in range(1, 30))
        self.refused("l0: &l0 [ha]\n" + laughs + SCENE)
        self.refused(SCENE + "<<: {name: other}\n")
        self.refused(self.replaced("name: scene", "name: !!python/object/apply:os.system [touch pwned]"))
        self.refused(SCENE + "---\n" + SCENE)

    def test_far_too_much_of_everything(self):
        self.refused("[" * 100000)
        self.refused("a: " + "{a: " * 5000 + "1" + "}" * 5000)
        self.refused(SCENE + "description: " + "x" * (2 << 20) + "\n", where=r"\.yaml: [^\n]*MiB")
        self.refused(HEAD + "parameters:\n" + "".join("  p%d: {value: 1}\n" % n for n in range(30000)) + STAGES)
        self.refused(self.replaced("name: scene", "n" * 100000 + ": scene"))

    def test_no_file_or_no_ordinary_one(self):
        for path in (self.place.join("absent.yaml"), self.place.path, self.place.join("absent", "scene.yaml")):
            ended = self.sandglass("run", path, seconds=QUICK)
            self.assertIn(ended.code, (USAGE, REFUSED, ENVIRONMENT), str(ended))
            self.assertIn(path, ended.err)
        os.mkfifo(self.place.join("pipe.yaml"))
        for path in ("/dev/zero", self.place.join("pipe.yaml")):
            started = self.place.start("check", path)
            # Should it read all that there is, then not into all the memory of this machine.
            wait_until(lambda: not started.running() or memory(started.process.pid) > 1 << 29, QUICK)
            if started.running():
                started.signal(signal.SIGKILL)
            ended = started.wait(QUICK)
            self.assertIn(ended.code, (USAGE, REFUSED, ENVIRONMENT), str(ended))


class Wrong(HostileCase):
    """Good YAML that is no workflow."""

    def test_duplicate_keys(self):
        ended = self.refused(self.replaced("name: scene", "name: scene\nname: other"), "name", line=3, column=1)
        self.assertIn("2", ended.err)  # where it was said first
        self.refused(self.replaced("above: 0}", "above: 0, above: 1}"), "above")
        self.refused(self.replaced("  number:", "  length: {value: 1 mm}\n  number:"), "length", line=6)
        self.refused(self.replaced("  right:", "  left:"), "left")

    def test_unknown_keys_and_the_nearest_valid_one(self):
        for old, new, nearest in (("stages:", "stage:", "stages"), ("scheme:", "sheme:", "scheme"),
                                  ("above: 0", "abov: 0", "above"), ("solver: command", "slover: command", "solver"),
                                  ("from: left", "form: left", "from"), ("name: scene", "nmae: scene", "name")):
            with self.subTest(new):
                text = self.replaced(old, new)
                line, column = self.place_of(text, new)
                self.refused(text, new.split(":")[0], nearest, line=line, column=column)

    def test_unknown_names_and_the_nearest_valid_one(self):
        for old, new, nearest in (("solver: command", "solver: comand", "command"),
                                  ("[left, right]", "[left, rihgt]", "right"),
                                  ("$window", "$windwo", "window"), ("to: right", "to: rigth", "right"),
                                  ("serial-explicit", "serial-explict", "serial-explicit"),
                                  ("run: coupling", "run: couplin", "coupling"),
                                  ("value: soft", "value: sft", "soft")):
            with self.subTest(new):
                text = self.replaced(old, new)
                self.refused(text, nearest, line=self.place_of(text, new)[0])

    def test_wrong_units(self):
        for old, new in (("{value: 1 ms, unit: ms", "{value: 1 mm, unit: ms"),
                         ("value: 2 mm, unit: mm", "value: 2 mm, unit: kg"),
                         ("value: 2 mm, unit: mm", "value: 2 furlong/wombat"),
                         ("value: 2 mm, unit: mm", "value: 2 mm, unit: wombat"),
                         ("end: 5 ms", "end: 5 m"), ("end: 5 ms", "end: 5 ms extra"), ("end: 5 ms", "end: five ms"),
                         ("unit: N", "unit: newtonnes"), ("window: $window", "window: $length")):
            with self.subTest(new):
                text = self.replaced(old, new)
                self.refused(text, line=self.place_of(text, new)[0])

    def test_wrong_types(self):
        for old, new in (("sandglass: 1", "sandglass: 2"), ("sandglass: 1", "sandglass: one"),
                         ("name: scene", "name: [scene]"),
                         ("name: scene", "name: ''"), ("name: scene", "name: 7up"),
                         ("value: 3, type: count", "value: 3.5, type: count"),
                         ("value: 3, type: count", "value: -3, type: count"),
                         ("value: 3, type: count", "value: true, type: count"),
                         ("value: 2 mm", "value: [2 mm]"), ("value: 2 mm", "value: -2 mm"),
                         ("value: 2 mm", "value: .nan"),
                         ("value: 2 mm", "value: .inf"), ("value: 2 mm", "value: 1e999 mm"), ("shape: [3]", "shape: 3"),
                         ("shape: [3]", "shape: [0]"), ("shape: [3]", "shape: [-1]"), ("shape: [3]", "shape: [2.5]"),
                         ("shape: [3]", "shape: [99999999999999999999]"), ("order: [left, right]", "order: left"),
                         ("order: [left, right]", "order: [left, left]"), ("order: [left, right]", "order: []"),
                         ("choices: [soft, hard]", "choices: []"), ("end: 5 ms", "end: 0 s"),
                         ("end: 5 ms", "end: -5 ms"),
                         ("end: 5 ms", "end:"), ("{run: coupling}", "{run: [coupling]}"),
                         ("{run: coupling}", "coupling")):
            with self.subTest(new):
                self.refused(self.replaced(old, new))

    def test_fields_that_cannot_be_reached(self):
        for old, new in (("from: left, to: right", "from: left, to: left"),
                         ("from: left, to: right", "from: nobody, to: right"),
                         ("from: left, to: right", "to: right"), ("order: [left, right]", "order: [left]")):
            with self.subTest(new):
                self.refused(self.replaced(old, new))

    def test_stages_that_wait_for_each_other(self):
        def stages(first, second):
            return self.replaced(STAGES, """\
stages:
  first: {run: command, command: [%s, STARTED], %s}
  second: {run: command, command: [%s, STARTED], %s}
  couple: {run: coupling}
""" % (PYTHON, first, PYTHON, second))
        self.refused(stages("after: [second]", "after: [first]"), "first", "second")
        self.refused(stages("after: [first]", "makes: [a.txt]"), "first")
        self.refused(stages("after: [frist]", "makes: [a.txt]"), "frist", "first")

    def test_missing_things(self):
        for part in (STAGES, PARTICIPANTS, COUPLING, "sandglass: 1\n", "name: scene\n", "  order: [left, right]\n",
                     "  window: $window\n"):
            with self.subTest(part):
                self.refused(self.replaced(part, ""))
        self.refused(self.replaced("{solver: command, command: [%s, STARTED]}" % PYTHON, "{solver: command}"),
                     "command")
        self.refused(self.replaced("{solver: command, command: [%s, STARTED]}" % PYTHON,
                                   "{solver: yade, template: yade/no_such.py}"),
                     "no_such.py")
        self.refused(self.replaced("{solver: command, command: [%s, STARTED]}" % PYTHON, "{solver: yade}"), "template")

    def test_everything_is_said_at_once(self):
        text = self.replaced("unit: N", "unit: newtonnes",
                             self.replaced("scheme:", "sheme:", self.replaced("above: 0", "abov: 0")))
        ended = self.refused(text, "newtonnes", "sheme", "abov")
        self.assertEqual(len([line for line in ended.err.splitlines() if ".yaml:" in line]), 3)

    def test_templates_get_all_that_they_use_and_use_all_that_they_get(self):
        text = read(SPHERE)
        for old, new, word in (("given: [diameter, viscosity]", "given: [diameter]", "viscosity"),
                               ("given: [diameter, viscosity]", "given: [diameter, viscosity, gravity]", "gravity"),
                               ("given: [diameter, viscosity]", "given: [diameter, viscosty]", "viscosity")):
            with self.subTest(new):
                self.refused(self.replaced(old, new, text), word, where=r"\w\.(yaml|edp):[1-9]\d*:[1-9]\d*: ")

    def test_hostile_settings(self):
        for setting in ("length", "=1", "length=", "length=1 kg", "length=-1 mm", "length=1e999", "length=nan",
                        "number=2.5",
                        "number=1 mm", "kind=softer", "kind=", "lenght=1 mm", "length=$(touch pwned)",
                        "length=1 mm; touch pwned",
                        "window=0", "window.value=1", "sandglass=2", "number=99999999999999999999"):
            with self.subTest(setting):
                ended = self.attempt(SCENE, "--set", setting)
                self.assertIn(ended.code, (USAGE, REFUSED), str(ended))
                self.assert_not_started(ended)
                self.assertIn("sandglass: ", ended.err)


class Paths(HostileCase):
    """Names of files that lead elsewhere."""

    def stage(self, keys):
        return self.replaced(STAGES, "stages:\n  first: {run: command, command: [%s, STARTED]%s}\n"
                                     "  couple: {run: coupling}\n"
                             % (PYTHON, keys))

    def test_makes(self):
        for path in ("../escaped", "/tmp/sandglass-escaped", "a/../../escaped", "..", ""):
            with self.subTest(path):
                self.refused(self.stage(", makes: ['%s']" % path))

    def test_files_of_other_stages(self):
        for path in ("first/../../escaped", "../escaped", "/etc/passwd", "first//etc/passwd", "nobody/a.txt",
                     "first/b.txt", "first"):
            with self.subTest(path):
                second = "\n  second: {run: python, template: report/draw.py, given: [{mesh: {file: '%s'}}]}" % path
                text = self.stage(", makes: [a.txt]").replace("\n  couple:", second + "\n  couple:")
                self.refused(text)

    def test_templates_and_data(self):
        for path in ("../README.md", "/etc/passwd", "yade/../../README.md", "yade", "", ".",
                     "yade/settling_sphere.py/"):
            with self.subTest(path):
                self.refused(self.replaced("{solver: command, command: [%s, STARTED]}" % PYTHON,
                                           "{solver: yade, template: '%s'}" % path))
        for path in ("../README.md", "/etc/passwd", "a/../../README.md"):
            with self.subTest(data=path):
                self.refused(self.stage("").replace("\n  couple:",
                                                    "\n  second: {run: python, template: report/draw.py, "
                                                    "given: [{mesh: {data: '%s'}}]}\n  couple:" % path))

    def test_templates_that_include_what_lies_outside(self):
        home = copy_of_home(self.place)
        self.place.write("home/templates/python/escape.py", "{{> ../README.md}}\n")
        self.place.write("home/templates/python/loop.py", "{{> python/loop.py}}\n")
        self.place.write("home/templates/python/absent.py", "{{> python/no_such.py}}\n")
        for name in ("escape", "loop", "absent"):
            with self.subTest(name):
                text = self.stage("").replace("\n  couple:",
                                              "\n  second: {run: python, template: python/%s.py}\n  couple:" % name)
                ended = self.attempt(text, home=home)
                self.assert_refused(ended)
                self.assert_not_started(ended)
                self.assertRegex(ended.err, name + r"\.py:1:[1-9]")

    def test_names_with_slashes_and_worse(self):
        for old, new in (("name: scene", "name: ../scene"), ("name: scene", "name: a/b"), ("name: scene", "name: '.'"),
                         ("name: scene", "name: 'a b'"), ("  left:", "  le/ft:"), ("  left:", "  '../left':"),
                         ("  couple:", "  a/b:"),
                         ("force:", "for/ce:"), ("force:", "'../force':"), ("  length:", "  'len gth':"),
                         ("force:", "'':"),
                         ("name: scene", "name: %s" % ("x" * 5000))):
            with self.subTest(new[:30]):
                self.refused(self.replaced(old, new))

    def test_the_run_directory_is_the_users_own_choice(self):
        """--out may lead anywhere; the workflow's text may not."""
        path = self.place.write("in/here/scene.yaml", SCENE.replace("STARTED", self.started))
        ended = self.sandglass("run", path, "--out", "../there", directory=self.place.join("in", "here"), seconds=QUICK)
        self.assert_code(ended, PARTICIPANT)
        self.assertTrue(os.path.exists(self.place.join("in", "there", "result.json")))
        os.remove(self.place.join("started"))
        for out in ("", "a\nb"):
            ended = self.sandglass("run", path, "--out=" + out, directory=self.place.join("in", "here"), seconds=QUICK)
            self.assertIn(ended.code, (USAGE, PARTICIPANT), str(ended))
        if os.path.exists(self.place.join("started")):
            os.remove(self.place.join("started"))


class Extremes(HostileCase):
    """Numbers at the end of what can be written."""

    def test_extreme_values_do_not_crash_the_check(self):
        for value in ("1e308", "-0", "-0.0", "5e-324", "1e-308", "2.2250738585072014e-308", "0x10", "1_000", "1e", "+1",
                      ".5", "5."):
            with self.subTest(value):
                ended = self.attempt(self.replaced("length: {value: 2 mm, unit: mm, above: 0}",
                                                   "length: {value: %s, unit: m}" % value),
                                     verb="check")
                self.assertIn(ended.code, (DONE, REFUSED), str(ended))

    def test_times_that_no_run_can_reach_are_refused_or_planned(self):
        for window, end in (("1e-300 s", "1e300 s"), ("5e-324 s", "1 s"), ("1 ns", "1e30 s"), ("1e308 s", "1e308 s"),
                            ("1 s", "1e-300 s"),
                            ("1e-308 s", "1e-308 s")):
            with self.subTest(window=window, end=end):
                text = self.replaced("value: 1 ms, unit: ms", "value: %s, unit: s" % window,
                                     self.replaced("end: 5 ms", "end: %s" % end))
                ended = self.attempt(text, "--dry-run")
                self.assertIn(ended.code, (DONE, REFUSED), str(ended))
                self.assert_not_started(ended)

    def test_a_billion_windows_can_be_planned(self):
        text = self.replaced("end: 5 ms", "end: 1e6 s")
        for verb, arguments in (("check", ()), ("plan", ()), ("run", ("--dry-run",))):
            ended = self.attempt(text, *arguments, verb=verb)
            self.assert_code(ended, DONE)
            self.assert_not_started(ended)

    def test_a_field_larger_than_any_memory(self):
        text = self.replaced("shape: [3]", "shape: [1000000000, 1000000000]")
        ended = self.attempt(text)
        self.assertIn(ended.code, (REFUSED, ENVIRONMENT), str(ended))
        self.assertFalse(os.path.exists(self.place.join("started")))
        self.assertNotIn("bad_alloc", ended.err)

    def test_minus_zero_arrives_as_a_number(self):
        ended = self.sandglass("run", SPHERE, *sets(numerical_damping="-0"), "--dry-run", seconds=QUICK)
        self.assertIn(ended.code, (DONE, REFUSED), str(ended))

    def test_spheres_that_cannot_be_computed_end_with_a_word(self):
        """A diameter of 1e-300 m has no mass that a number can hold."""
        ended = self.sandglass("run", SPHERE, *sets(diameter="1e-300", end_time="2 ms"), out="nothing")
        self.assertIn(ended.code, (REFUSED, PARTICIPANT, UNSTABLE), str(ended))
        if ended.code != REFUSED:
            self.assertEqual(ended.result["exit_code"], ended.code)


class Texts(HostileCase):
    """Text parameters given to stages: they arrive as they are, or are refused."""

    LANGUAGES = {
        "python": ("python/take.py", "with open('arrived.txt', 'w', encoding='utf-8') as file:\n"
                                     "    file.write({{words}})\n"),
        "freefem": ("freefem/take.edp", "load \"sandglass\"\n{ ofstream file(\"arrived.txt\"); file << {{words}}; }\n"
                                        "sandglassFinished();\n"),
        "gmsh": ("gmsh/take.geo", "Printf({{words}}) > \"arrived.txt\";\n"),
    }

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.home = copy_of_home(cls.place)
        for path, script in list(cls.LANGUAGES.values()):
            cls.place.write("home/templates/" + path, script)
        cls.place.write("home/templates/yade/take.py", "with open('arrived.txt', 'w', encoding='utf-8') as file:\n"
                                                       "    file.write({{words}})\n")

    def stages(self, languages):
        text = HEAD + "parameters:\n  words: {value: nothing, type: text}\nstages:\n"
        return text + "".join("  %s: {run: %s, template: %s, given: [words], makes: [arrived.txt]}\n"
                              % (name, name, path)
                              for name, path in languages)

    def arrives(self, words, languages):
        for name, path in languages:
            with self.subTest(words=words, language=name):
                ended = self.attempt(self.stages([(name, path)]), "--set", "words=" + words, home=self.home)
                if ended.code == REFUSED:
                    self.assertRegex(ended.err, r":[1-9]\d*:[1-9]\d*: |--set|words")
                    self.assertFalse(os.path.exists(self.out))
                    continue
                self.assert_code(ended, DONE)
                with open(os.path.join(self.out, "stages", name, "arrived.txt"), encoding="utf-8") as file:
                    arrived = file.read()
                self.assertEqual(arrived.rstrip("\n") if name == "gmsh" else arrived, words)

    def test_they_arrive_in_python_freefem_and_gmsh(self):
        for words in HOSTILE_TEXTS:
            self.arrives(words, [(name, path) for name, (path, _) in self.LANGUAGES.items()])

    def test_they_arrive_in_yade(self):
        self.arrives(HOSTILE_TEXTS[0], [("yade", "yade/take.py")])

    def test_they_arrive_by_the_file_too(self):
        words = HOSTILE_TEXTS[0]
        text = self.stages([("python", "python/take.py")]).replace("value: nothing", "value: '%s'"
                                                                   % words.replace("'", "''"))
        ended = self.attempt(text, home=self.home)
        self.assert_code(ended, DONE)
        self.assertEqual(read(os.path.join(self.out, "stages", "python", "arrived.txt")), words)

    def test_an_ordinary_text_arrives_everywhere(self):
        """Refusing all would be no quoting."""
        for name, (path, _) in self.LANGUAGES.items():
            ended = self.attempt(self.stages([(name, path)]), "--set", "words=ordinary words, 'quoted' and (bracketed)",
                                 home=self.home)
            self.assert_code(ended, DONE)

    def test_arguments_are_not_read_by_a_shell(self):
        words = "; touch pwned #"
        script = self.place.write("say.py", "import sys\nopen('arrived.txt', 'w').write(sys.argv[1])\n")
        stage = "  say: {run: command, command: [%s, %s, '%s'], makes: [arrived.txt]}\n" % (PYTHON, script, words)
        text = HEAD + "stages:\n" + stage
        ended = self.attempt(text)
        self.assert_code(ended, DONE)
        self.assertEqual(read(os.path.join(self.out, "stages", "say", "arrived.txt")), words)

    def test_texts_do_not_become_html(self):
        text = SCENE.replace("name: scene", "name: scene\ntitle: \"<script>alert('pwned')</script>\"\n"
                                            "description: \"<img src=x onerror=1>\"")
        ended = self.attempt(text)
        self.assert_code(ended, PARTICIPANT)
        os.remove(self.place.join("started"))
        report = read(os.path.join(self.out, "report.html"))
        self.assertIn("&lt;script", report)
        self.assertNotIn("<script>alert", report)
        self.assertNotIn("<img src=x", report)


if __name__ == "__main__":
    unittest.main()
