"""YADE and FreeFEM that are missing, and scripts that they cannot run."""

import os
import re
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "integration"))

from case import ENVIRONMENT, PARTICIPANT, SPHERE, UNSTABLE, Case, change, copy_of_home, read, sets


class RealSolvers(Case):
    """YADE and FreeFEM themselves."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.home = copy_of_home(cls.place)

    def template(self, name):
        return os.path.join(self.home, "templates", name)

    def test_freefem_is_missing(self):
        os.makedirs(self.place.join("no-solvers"), exist_ok=True)
        ended = self.sandglass("run", SPHERE, out="missing", environment={"PATH": self.place.join("no-solvers")})
        self.assert_failed(ended, ENVIRONMENT, "environment", windows=0)
        self.assert_said(ended, "FreeFem++", "doctor")

    def test_gmsh_is_missing(self):
        os.makedirs(self.place.join("no-solvers"), exist_ok=True)
        ended = self.sandglass("run", SPHERE, *sets(fluid="box"), out="no-gmsh",
                               environment={"PATH": self.place.join("no-solvers")})
        self.assert_failed(ended, ENVIRONMENT, "environment", windows=0)
        self.assert_said(ended, "gmsh", "doctor")

    def test_templates_with_a_typing_error(self):
        for name, old, new, word in (("yade/settling_sphere.py", "{{diameter}}", "{{diametre}}", "diameter"),
                                     ("freefem/stokes_axisymmetric.edp", "{{viscosity}}", "{{viscosty}}", "viscosity"),
                                     ("freefem/scaled_drag.idp", "{{unit_answer}}", "{{unit_anwser}}", "unit_answer"),
                                     ("analysis/settling_sphere.py", "{{window}}", "{{windw}}", "window")):
            with self.subTest(name):
                home = copy_of_home(self.place, "home-" + name.replace("/", "-"))
                path = change(os.path.join(home, "templates", name), (old, new))
                before, _, _ = read(path).partition(new)
                line, column = before.count("\n") + 1, len(before) - (before.rfind("\n") + 1)
                for verb in ("check", "run"):
                    ended = self.sandglass(verb, SPHERE, *(["--out", self.place.join("typo")] if verb == "run" else []),
                                           home=home)
                    # The column of the braces, or that of the name within them.
                    self.assert_refused(ended, word)
                    self.assertRegex(ended.err, r"%s:%d:(%d|%d): " % (re.escape(name), line, column + 1, column + 3))
                self.assertFalse(os.path.exists(self.place.join("typo")))

    def scene(self, name, freefem, *words, code=PARTICIPANT, status="failed", windows=0):
        """A FreeFEM participant with this script, alone."""
        with open(self.template("freefem/%s.edp" % name), "w") as file:
            file.write(freefem)
        text = """\
sandglass: 1
name: %s
stages: {couple: {run: coupling}}
participants:
  fluid: {solver: freefem, template: freefem/%s.edp, deadline: 20 s}
coupling:
  window: 1 ms
  end: 4 ms
  order: [fluid]
  fields: {drag: {unit: N, shape: [1], from: fluid}}
""" % (name, name)
        ended = self.run_workflow(text, name=name, home=self.home)
        self.assert_failed(ended, code, status, windows)
        self.assert_said(ended, "fluid", *words)
        self.assertEqual(ended.record.windows, windows)
        return ended

    LOOP = """load "sandglass"
sandglassReady("stateless");
real[int] drag(1);
while (true) {
  string command = sandglassNext();
  if (command == "advance") {
    drag[0] = 1;
    %s
    sandglassSend("drag", drag);
  }
  if (command == "stop") break;
  sandglassDone();
}
sandglassDone();
"""

    def test_freefem_does_not_understand_its_script(self):
        self.scene("misspelt", 'load "sandglass"\nreal a = 1;\nreal b = a + unknownname;\n', "unknownname", "fluid.log")

    def test_freefem_fails_on_the_way(self):
        self.scene("asserts", self.LOOP % "if (sandglassWindow(0) == 3) assert(drag[0] > 2);", "window 3", "assert",
                   windows=2)

    def test_freefem_leaves_with_status_0(self):
        self.scene("exits", self.LOOP % "if (sandglassWindow(0) == 3) exit(0);", "window 3", "exit status 0", windows=2)

    def test_freefem_ends_before_it_is_ready(self):
        self.scene("silent", 'load "sandglass"\ncout << "nothing to do" << endl;\n', "nothing to do")

    def test_freefem_sends_what_is_not_a_number(self):
        self.scene("notanumber", self.LOOP % "if (sandglassWindow(0) == 3) drag[0] = sqrt(-drag[0]);",
                   "window 3", "drag", "not a number", code=UNSTABLE, status="unstable", windows=2)

    def test_freefem_divides_by_zero(self):
        self.scene("divides", self.LOOP % "drag[0] = 1/(sandglassWindow(0) - 3.0);", "window 3", "Div by 0", windows=2)

    def test_freefem_sends_a_longer_array(self):
        self.scene("longer", self.LOOP % "if (sandglassWindow(0) == 3) drag.resize(2);", "window 3", "drag", windows=2)

    def test_yade_fails_in_its_window(self):
        change(self.template("yade/settling_sphere_window.py"),
               ("for step in", "assert O.iter < 2, 'the sphere is gone'\nfor step in"))
        ended = self.sandglass("run", SPHERE, *sets(end_time="5 ms"), out="yade", home=self.home)
        self.assert_failed(ended, PARTICIPANT, "failed", windows=2)
        self.assert_said(ended, "grains", "window 3", "the sphere is gone")
        self.assertEqual(ended.record.windows, 2)

    def test_yade_has_no_folder_of_temporary_files(self):
        change(self.template("yade/settling_sphere_window.py"),
               ("for step in", "import os\nassert False, 'it would be <%s>' % os.path.dirname(O.tmpFilename())\nfor step in"))
        ended = self.sandglass("run", SPHERE, *sets(end_time="5 ms"), out="folder", home=self.home)
        self.assert_failed(ended, PARTICIPANT, "failed", windows=0)
        folder = re.search("it would be <(/[^>]+)>", read(ended.path("logs", "grains.log"))).group(1)
        self.assertIn("yade", os.path.basename(folder))
        self.assertFalse(os.path.exists(folder))


if __name__ == "__main__":
    unittest.main()
