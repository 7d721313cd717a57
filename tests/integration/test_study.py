"""A small study with YADE and FreeFEM: the points are ordinary runs, the summary's diagrams and theory come out right, and a
cluster's scheduler gives the same as the local pool."""

import glob
import json
import os
import shutil
import signal
import socket
import subprocess
import unittest

from case import DONE, ENVIRONMENT, MISMATCH, REFUSED, SPHERE, UNSTABLE, Case, Loads, read, sets, wait_until, write

TAU = 2650 * 1e-4**2 / (18 * 1e-3)  # s
STUDY = """\
sandglass: 1
name: small
study:
  of: %s
  set: {end_time: 20 ms}
  points:
    - name: windows
      grid: {window: [0.5 ms, 1 ms]}
    - name: elements
      list: [{element_order: quadratic}, {element_order: cubic}]
    - name: beyond
      set: {window: 4 ms, end_time: 200 ms}
      expect: unstable
  judge: false
  work_precision:
    - {error: drag_relative_error, points: [windows, elements], method: [element_order], seconds: [fluid]}
    - {error: terminal_velocity, reference: {quantity: stokes_terminal_velocity}}
stages:
  theory: {run: python, template: analysis/settling_sphere_stability.py, analysis: true}
compare:
  - {name: growth, quantity: growth_difference_max, metric: value, tolerance: 1e-6, because: exact formulas}
""" % SPHERE


class SmallStudy(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        file = cls.place.write("small.yaml", STUDY)
        cls.ended = cls.place.sandglass("study", file, "--jobs", "2", out="small", seconds=600)
        cls.summary = cls.place.join("small", "summary")

    def analysis(self, stage):
        return json.loads(read(os.path.join(self.summary, "stages", stage, "analysis.json")))

    def test_it_ends_well(self):
        self.assert_code(self.ended, DONE)
        self.assertIn("5 points: 5 run", self.ended.out)
        page = read(os.path.join(self.summary, "report.html"))
        self.assertEqual(Loads(page).outside, [])
        self.assertIn("Points of the study", page)
        self.assertIn("Cheapest setting for an error", page)

    def test_check_looks_at_the_points_too(self):
        well = self.sandglass("check", self.place.write("well.yaml", STUDY))
        self.assert_code(well, DONE)
        self.assertIn("all 5 points are well", well.out)
        bad = self.sandglass("check", self.place.write("bad.yaml", STUDY.replace("[0.5 ms, 1 ms]", "[0.5 ms, 1 mm]")))
        self.assert_code(bad, REFUSED)
        self.assertIn("bad.yaml:8:31", bad.err)
        self.assertEqual(bad.out, "")

    def test_a_point_is_an_ordinary_run(self):
        run = self.sandglass("run", SPHERE, *sets(end_time="20 ms", window="0.5 ms"), out="alone")
        self.assert_code(run, DONE)
        with open(self.place.join("small", "points", "window=0.5ms", "result.json")) as file:
            point = json.load(file)
        self.assertEqual(point["quantities"], run.result["quantities"])
        self.assertIn("Inputs: all the same", self.sandglass(
            "compare", run.directory, self.place.join("small", "points", "window=0.5ms")).out)

    def test_growth_of_stable_and_unstable_points(self):
        result = json.loads(read(os.path.join(self.summary, "result.json")))
        self.assertEqual([one["passed"] for one in result["comparisons"]], [True])
        self.assertEqual(result["quantities"]["growths_measured"]["value"], 5)
        rows = {row[1]: row for row in self.analysis("theory")["tables"][0]["rows"]}
        for window, outcome in ((0.5e-3, "stable"), (4e-3, "unstable")):
            row = rows["%.4g" % (window / TAU)]
            # FreeFEM's own drag differs from Stokes' by up to 3.4e-7 with the elements of these points.
            self.assertAlmostEqual(float(row[2]), 1 - window / TAU, delta=2e-6)
            self.assertEqual(row[5], outcome)

    def test_the_frontier_is_that_of_the_points(self):
        analysis = self.analysis("precision_of_drag_relative_error")
        with open(os.path.join(self.summary, "points.json")) as file:
            points = json.load(file)["points"]
        shown = [(one["seconds"]["fluid"], one["quantities"]["drag_relative_error"]) for one in points if one["set"] != "beyond"]
        best = sorted(one for one in shown if not any(
            other != one and other[0] <= one[0] and other[1] <= one[1] for other in shown))
        frontier = analysis["curves"]["drag_relative_error_frontier"]
        self.assertEqual(list(zip(frontier["x"]["values"], frontier["y"]["values"])), best)
        # For every error in the table nothing else is as good and cheaper.
        for row in analysis["tables"][0]["rows"]:
            enough = min(seconds for seconds, error in shown if error <= float(row[0]))
            self.assertEqual(row[2], "%.3g s" % enough)
        methods = {curve["label"] for name, curve in analysis["curves"].items() if "method" in name}
        self.assertEqual(methods, {"windows, quartic", "elements, quadratic", "elements, cubic"})

    def test_the_unstable_point_says_so(self):
        self.assertEqual(json.loads(read(self.place.join("small", "points", "window=4ms,end_time=200ms", "result.json")))
                         ["exit_code"], UNSTABLE)
        status = self.sandglass("status", self.place.join("small"))
        self.assertIn("5 done", status.out)


class Slurm:
    """A controller and one node, as root, in a folder of their own; ended by their process numbers."""

    def __init__(self, folder):
        self.folder = folder
        self.processes = []
        name = socket.gethostname().split(".")[0]
        for part in ("state", "spool", "munge"):
            os.makedirs(os.path.join(folder, part))
        os.chmod(folder, 0o755)
        ports = []
        for _ in range(2):
            with socket.socket() as free:
                free.bind(("127.0.0.1", 0))
                ports.append(free.getsockname()[1])
        self.configuration = write(os.path.join(folder, "slurm.conf"), "\n".join((
            "ClusterName=test", "SlurmctldHost=%s(127.0.0.1)" % name, "SlurmUser=root", "SlurmdUser=root",
            "AuthType=auth/munge", "AuthInfo=socket=%s/munge/socket" % folder,
            "CryptoType=crypto/munge", "StateSaveLocation=%s/state" % folder,
            "SlurmdSpoolDir=%s/spool" % folder, "SlurmctldPidFile=%s/slurmctld.pid" % folder,
            "SlurmdPidFile=%s/slurmd.pid" % folder, "SlurmctldLogFile=%s/slurmctld.log" % folder,
            "SlurmdLogFile=%s/slurmd.log" % folder, "ProctrackType=proctrack/linuxproc", "TaskPlugin=task/none",
            "SelectType=select/cons_tres", "SelectTypeParameters=CR_CPU", "ReturnToService=2", "MpiDefault=none",
            "CommunicationParameters=NoCtldInAddrAny,NoInAddrAny",
            "SlurmctldPort=%d" % ports[0], "SlurmdPort=%d" % ports[1],
            "NodeName=%s NodeAddr=127.0.0.1 CPUs=%d" % (name, os.cpu_count()),
            "PartitionName=all Nodes=%s Default=YES MaxTime=INFINITE State=UP" % name, "")))
        self.environment = dict(os.environ, SLURM_CONF=self.configuration)

    def start(self):
        """True when jobs can be run."""
        munge = os.path.join(self.folder, "munge")
        key = os.path.join(munge, "key")
        with open(key, "wb") as file:
            file.write(os.urandom(1024))
        os.chmod(key, 0o400)
        os.chmod(munge, 0o755)
        for command in (
                ["munged", "--foreground", "--force", "--socket", munge + "/socket", "--key-file", key, "--log-file",
                 munge + "/log", "--pid-file", munge + "/pid", "--seed-file", munge + "/seed"],
                ["slurmctld", "-D", "-f", self.configuration], ["slurmd", "-D", "-f", self.configuration]):
            with open(os.path.join(self.folder, command[0] + ".out"), "w") as log:
                self.processes.append(subprocess.Popen(command, stdout=log, stderr=log, env=self.environment))
            if command[0] == "munged" and not wait_until(lambda: os.path.exists(munge + "/socket"), 10):
                return False
        return bool(wait_until(lambda: subprocess.run(
            ["sinfo", "--noheader", "--format=%T"], env=self.environment, capture_output=True,
            text=True).stdout.strip() == "idle", 20, 0.2))

    def stop(self):
        for process in reversed(self.processes):
            process.send_signal(signal.SIGTERM)
        for process in self.processes:
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


class OnACluster(Case):
    def test_what_an_earlier_job_was_told_does_not_hide_a_refusal(self):
        """A cluster that refuses is stood in for by a script: a real one takes every job of a test."""
        sbatch = self.place.write("refusing/sbatch", "#!/bin/sh\necho 'sbatch: error: invalid account' >&2\nexit 1\n")
        os.chmod(sbatch, 0o755)
        file = self.place.write("refused.yaml", "sandglass: 1\nname: refused\nstudy:\n  of: %s\n"
                                                "  points:\n    - set: {window: 1 ms}\n" % SPHERE)
        path = os.path.dirname(sbatch) + os.pathsep + os.environ["PATH"]
        refused = self.sandglass("study", file, "--slurm", out="refused", environment={"PATH": path})
        write(self.place.join("refused", "slurm", "sbatch.log"), "Submitted batch job 7\n")
        again = self.sandglass("study", file, "--slurm", out="refused", environment={"PATH": path})
        for ended in (refused, again):
            self.assert_code(ended, ENVIRONMENT)
            self.assert_said(ended, "invalid account", "SBATCH_PARTITION")

    def test_a_job_array_gives_what_the_pool_gives(self):
        if os.geteuid() != 0 or not all(map(shutil.which, ("munged", "slurmctld", "slurmd", "sbatch", "sinfo"))):
            self.skipTest("Slurm is not here (packages slurm-wlm, munge), or this is not root")
        slurm = Slurm(self.place.join("slurm"))
        self.addCleanup(slurm.stop)
        if not slurm.start():
            self.skipTest("slurmd does not run on this machine: " + read(os.path.join(slurm.folder, "slurmd.out"))[-300:])
        file = self.place.write("cluster.yaml", """\
sandglass: 1
name: cluster
study:
  of: %s
  judge: false
  points:
    - grid: {window: [1 ms, 2 ms]}
    - set: {window: 4 ms, end_time: 200 ms}
      expect: unstable
""" % SPHERE)
        ended = self.sandglass("study", file, "--slurm", "--jobs", "2", out="cluster", seconds=300,
                               environment={"SLURM_CONF": slurm.configuration})
        self.assert_code(ended, DONE)
        self.assertIn("3 points: 3 run", ended.out)
        script = read(self.place.join("cluster", "slurm", "study.sh"))
        self.assertIn("'--set' 'window=1 ms'", script)
        self.assertEqual(len(glob.glob(self.place.join("cluster", "slurm", "*_*.log"))), 3)
        again = self.sandglass("study", file, "--slurm", out="cluster", environment={"SLURM_CONF": slurm.configuration})
        self.assertIn("nothing to do", again.out)
        local = self.sandglass("study", file, out="local", seconds=300)
        self.assert_code(local, DONE)
        for point in ("window=1ms", "window=2ms"):
            results = [json.loads(read(self.place.join(name, "points", point, "result.json")))["quantities"]
                       for name in ("cluster", "local")]
            self.assertEqual(*results)


if __name__ == "__main__":
    unittest.main()
