"""A look at what a run has recorded so far: finished, going on, killed."""

import json
import os
import signal
import unittest

from case import DONE, ENVIRONMENT, SPHERE, Case, Record, read, sets, wait_until


class Analyse(Case):
    def analyse(self, run, code, out):
        ended = self.sandglass("analyse", run, out=out)
        self.assert_code(ended, code)
        return ended

    def test_a_finished_run_says_the_same_again(self):
        run = self.sandglass("run", SPHERE, out="finished")
        self.assert_code(run, DONE)
        again = self.analyse(run.directory, DONE, "again")
        for key in ("quantities", "comparisons", "windows", "curves"):
            self.assertEqual(again.result[key], run.result[key], key)
        for path in run.result["curves"].values():
            self.assertEqual(read(again.path(path)), read(run.path(path)), path)
        self.assertNotIn("notes", again.result)
        self.assert_code(self.sandglass("verify", again.directory), DONE)
        self.assert_code(self.sandglass("verify", run.directory), DONE)
        # Whoever reads it finds how the record came to be.
        provenance = json.loads(read(again.path("provenance.json")))
        self.assertEqual(provenance["recorded_by"]["command"][:2], ["sandglass", "run"])
        self.assertIn("yade/settling_sphere.py", str(provenance["recorded_by"]["templates"]))
        # A second look into the same folder is refused.
        self.assert_code(self.sandglass("analyse", run.directory, out="again"), ENVIRONMENT)

    def test_a_run_that_goes_on_and_one_that_was_killed(self):
        started = self.place.start("run", SPHERE, *sets(end_time="1000 s", checkpoint_every=0), out="going")
        record = started.path("record.h5")
        self.assertTrue(wait_until(lambda: os.path.exists(record) and Record(record).windows >= 20))
        look = self.analyse(started.directory, DONE, "look")
        self.assertTrue(started.running())
        windows = look.result["windows"]
        self.assertGreaterEqual(windows, 20)
        self.assertEqual(look.record.windows, windows)
        self.assertIn("%d of 1000000 windows" % windows, str(look.result["notes"]))
        started.signal(signal.SIGKILL)
        started.wait()
        later = self.analyse(started.directory, DONE, "later")
        self.assertGreater(later.result["windows"], windows)
        self.assertEqual(later.record["velocity"][:windows].tobytes(), look.record["velocity"].tobytes())

    def test_where_there_is_nothing_to_analyse(self):
        self.assert_said(self.analyse(self.place.join("nowhere"), ENVIRONMENT, "a"), "is not a run directory")
        begun = self.sandglass("run", SPHERE, *sets(density="1 kg/m3"), out="begun")
        os.remove(begun.path("record.h5"))
        self.assert_said(self.analyse(begun.directory, ENVIRONMENT, "b"), "no recorded window")


if __name__ == "__main__":
    unittest.main()
