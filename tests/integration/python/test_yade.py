"""YADE behind the participant protocol: real YADE, the real templates, no fluid solver."""

import math
import os
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

from stand_in import PYTHON, RESIDENT, MappedSlot, Partner, make_slot, render, write

SPHERE = {
    "diameter": 1e-4,
    "density": 2650.0,
    "fluid_density": 1000.0,
    "gravity": 9.80665,
    "numerical_damping": 0.0,
    "time_step": 1e-3,
    "grain_steps": 1,
    "contact_detection": True,
}
VISCOSITY = 1e-3


def listening_sockets(pid):
    """Inodes of the process's sockets that listen for TCP connections or receive UDP."""
    own = set()
    for descriptor in os.listdir("/proc/%d/fd" % pid):
        try:
            target = os.readlink("/proc/%d/fd/%s" % (pid, descriptor))
        except FileNotFoundError:
            continue
        if target.startswith("socket:["):
            own.add(target[len("socket:[") : -1])
    open_ports = set()
    for table, states in (("tcp", {"0A"}), ("tcp6", {"0A"}), ("udp", {"07"}), ("udp6", {"07"})):
        path = "/proc/%d/net/%s" % (pid, table)
        if os.path.exists(path):
            with open(path) as file:
                rows = [line.split() for line in file.readlines()[1:]]
            open_ports |= {row[9] for row in rows if row[3] in states}
    return own & open_ports


class YadeTest(unittest.TestCase):
    def setUp(self):
        self.place = tempfile.TemporaryDirectory()
        self.addCleanup(self.place.cleanup)

    def path(self, name):
        return os.path.join(self.place.name, name)

    def start(self, setup, window=None, outgoing=("velocity", "acceleration", "position"), threads=1, name="slot.h5"):
        """A resident YADE that is ready, with its slot."""
        slot = make_slot(self.path(name), {"drag": (1,)}, {field: (1,) for field in outgoing})
        script = write(self.path("setup.py"), setup)
        partner = Partner([RESIDENT], self.place.name, slot, script, threads)
        self.addCleanup(partner.close)
        self.assertEqual(partner.line(), "ready 1 memory disk")
        if window is not None:
            self.assertEqual(partner.ask("script " + write(self.path("window.py"), window)), "ok")
        return partner, MappedSlot(slot)

    def start_sphere(self, **changes):
        values = dict(SPHERE, **changes)
        partner, fields = self.start(
            render("yade/settling_sphere.py", values),
            render("yade/settling_sphere_window.py", values),
            name=changes.get("name", "slot.h5"),
        )
        return values, partner, fields

    def settle(self, windows, **changes):
        """Velocities and accelerations of YADE, and of `expected_windows`, window by window."""
        values, partner, fields = self.start_sphere(**changes)
        rows = []
        state = (0.0, 0.0)
        for _ in range(windows):
            drag = 3 * math.pi * VISCOSITY * values["diameter"] * fields["out/velocity/values"][0]
            fields["in/drag/values"][0] = drag
            self.assertEqual(partner.ask("advance"), "ok")
            state, acceleration = expected_window(values, state, drag)
            rows.append(
                [fields["out/%s/values" % name][0] for name in ("velocity", "acceleration", "position")]
                + [state[0], acceleration, state[1]]
            )
        return values, rows


def expected_window(values, state, drag):
    """One window by our own arithmetic: symplectic Euler, Cundall's damping at mid-step (positive downward)."""
    velocity, depth = state
    radius = values["diameter"] / 2
    mass = values["density"] * 4 / 3 * math.pi * radius**3
    force = mass * values["gravity"] * (1 - values["fluid_density"] / values["density"]) - drag
    step = values["time_step"] / values["grain_steps"]
    for _ in range(values["grain_steps"]):
        acceleration = force / mass
        power = acceleration * (velocity + acceleration * step / 2)
        if power != 0:
            acceleration *= 1 - values["numerical_damping"] * math.copysign(1, power)
        velocity += acceleration * step
        depth += velocity * step
    return (velocity, depth), acceleration


class SettlingSphereTest(YadeTest):
    def check(self, windows, **changes):
        values, rows = self.settle(windows, **changes)
        speed = max(abs(row[3]) for row in rows)
        for velocity, acceleration, depth, expected, expected_acceleration, expected_depth in rows:
            self.assertLessEqual(abs(velocity - expected), 1e-13 * speed)
            step = values["time_step"] / values["grain_steps"]
            self.assertLessEqual(abs(acceleration - expected_acceleration), 1e-13 * speed / step)
            self.assertLessEqual(abs(depth - expected_depth), 1e-13 * speed * values["time_step"] * windows)
        self.assertGreater(speed, 0)
        return values, rows

    def test_one_step_with_frozen_drag_is_explicit_euler(self):
        # v(n) - v_t = -v_t (1 - lambda)^n, lambda = window / tau; exact to rounding.
        values, rows = self.check(30)
        tau = values["density"] * values["diameter"] ** 2 / (18 * VISCOSITY)
        terminal = (values["density"] - values["fluid_density"]) * values["gravity"] * values["diameter"] ** 2
        terminal /= 18 * VISCOSITY
        for n, row in enumerate(rows, 1):
            theory = terminal * (1 - (1 - values["time_step"] / tau) ** n)
            self.assertLessEqual(abs(row[0] - theory), 1e-14 * terminal)

    def test_numerical_damping_is_yades_rule(self):
        self.check(30, numerical_damping=0.509)

    def test_numerical_damping_with_overshoot_and_substeps(self):
        # window 2.3 ms = 1.56 tau: the velocity overshoots, so forces act along and against the motion.
        self.check(20, numerical_damping=0.3, time_step=2.3e-3, grain_steps=7)

    def test_substeps_under_a_frozen_drag_make_no_difference(self):
        _, one = self.settle(12, name="one.h5")
        _, ten = self.settle(12, grain_steps=10, name="ten.h5")
        for a, b in zip(one, ten):
            self.assertAlmostEqual(a[0], b[0], delta=1e-14)

    def test_a_micron_and_a_nanosecond(self):
        self.check(30, diameter=1e-6, time_step=1e-9)

    def test_a_light_sphere_rises(self):
        _, rows = self.check(40, density=500.0, time_step=1e-4)
        self.assertLess(rows[-1][0], 0)
        self.assertLess(rows[-1][2], 0)

    def test_fields_nobody_wants_are_not_sent(self):
        slot_out = ("velocity",)
        partner, fields = self.start(
            render("yade/settling_sphere.py", SPHERE), render("yade/settling_sphere_window.py", SPHERE), slot_out
        )
        self.assertEqual(partner.ask("advance"), "ok")
        self.assertGreater(fields["out/velocity/values"][0], 0)


class ResidentTest(YadeTest):
    def test_no_port_is_open(self):
        with socket.socket() as listener:  # the check itself must be able to see one
            listener.bind(("127.0.0.1", 0))
            listener.listen()
            self.assertEqual(len(listening_sockets(os.getpid())), 1)
        _, partner, _ = self.start_sphere()
        self.assertEqual(partner.ask("advance"), "ok")
        self.assertEqual(listening_sockets(partner.process.pid), set())

    def test_stop_end_of_commands_and_sigterm(self):
        _, partner, _ = self.start_sphere()
        self.assertEqual(partner.ask("stop"), "ok")
        self.assertEqual(partner.wait(), 0)
        _, partner, _ = self.start_sphere(name="second.h5")
        partner.end_of_commands()
        self.assertEqual(partner.wait(), 0)
        _, partner, _ = self.start_sphere(name="third.h5")
        partner.process.send_signal(signal.SIGTERM)
        self.assertEqual(partner.wait(), -signal.SIGTERM)

    def test_fresh_processes_give_the_same_bytes_as_a_resident_one(self):
        windows = 5

        def advance(partner, fields, drag):
            fields["in/drag/values"][0] = drag
            self.assertEqual(partner.ask("advance"), "ok")
            return [fields["out/%s/values" % name][0] for name in ("velocity", "acceleration", "position")]

        def drag_of(row):
            return 3 * math.pi * VISCOSITY * SPHERE["diameter"] * row[0]

        resident, row = [], [0.0]
        _, partner, fields = self.start_sphere()
        for _ in range(windows):
            row = advance(partner, fields, drag_of(row))
            resident.append(row)
        fresh, row = [], [0.0]
        for n in range(windows):
            _, partner, fields = self.start_sphere(name="fresh%d.h5" % n)
            if n > 0:
                self.assertEqual(partner.ask("load " + self.path("state")), "ok")
            row = advance(partner, fields, drag_of(row))
            self.assertEqual(partner.ask("checkpoint " + self.path("state")), "ok")
            self.assertEqual(partner.ask("stop"), "ok")
            fresh.append(row)
        self.assertEqual(resident, fresh)

    def test_save_and_restore_repeat_a_window(self):
        _, partner, fields = self.start_sphere()
        partner.ask("advance")
        self.assertEqual(partner.ask("save"), "ok")
        partner.ask("advance")
        first = fields["out/position/values"][0]
        partner.ask("advance")
        self.assertNotEqual(fields["out/position/values"][0], first)
        self.assertEqual(partner.ask("restore"), "ok")
        partner.ask("advance")
        self.assertEqual(fields["out/position/values"][0], first)

    def test_errors_name_the_script_and_the_line(self):
        partner, fields = self.start("x = 1\n", outgoing=())
        window = write(self.path("bad window.py"), "# a comment\nutils.nothing()\n")
        self.assertEqual(partner.ask("script " + window), "ok")
        self.assertEqual(
            partner.ask("advance"), "error AttributeError: module 'yade.utils' has no attribute 'nothing' (%s:2)" % window
        )
        broken = write(self.path("broken.py"), "x = 1\nif x\n")
        self.assertEqual(partner.ask("script " + broken), "error SyntaxError: expected ':' (%s:2)" % broken)

    def test_advance_without_a_script_is_an_error(self):
        partner, _ = self.start("x = 1\n", outgoing=())
        self.assertIn("'advance' before 'script'", partner.ask("advance"))

    def test_a_set_up_that_fails_says_so_instead_of_ready(self):
        slot = make_slot(self.path("slot.h5"), {}, {})
        script = write(self.path("setup.py"), "O.dt = 1e-3\nraise ValueError('no such\\nspecimen')\n")
        partner = Partner([RESIDENT], self.place.name, slot, script)
        self.addCleanup(partner.close)
        self.assertEqual(partner.line(), "error ValueError: no such specimen (%s:2)" % script)
        self.assertEqual(partner.wait(), 1)

    def test_without_yade_the_log_says_what_to_install(self):
        slot = make_slot(self.path("slot.h5"), {}, {})
        script = write(self.path("setup.py"), "")
        partner = Partner([RESIDENT], self.place.name, slot, script, path=self.place.name)
        self.addCleanup(partner.close)
        self.assertIsNone(partner.line())
        self.assertEqual(partner.wait(), 1)
        with open(partner.log) as log:
            self.assertIn("apt install yade", log.read())

    def test_scripts_live_where_pyrunner_and_labels_look(self):
        setup = """
O.engines = [ForceResetter(), NewtonIntegrator(label='newton'), PyRunner(command='count()', iterPeriod=1, initRun=True)]
O.dt = 1.0
counted = 0
def count():
    global counted
    counted += 1
"""
        window = """
newton.damping = 0.125
O.step()
O.step()
sandglass.send('velocity', counted + newton.damping)
"""
        partner, fields = self.start(setup, window, outgoing=("velocity",))
        self.assertEqual(partner.ask("advance"), "ok")
        self.assertEqual(fields["out/velocity/values"][0], 2.125)
        # Loading replaces the engines; the label must then mean the new one.
        self.assertEqual(partner.ask("checkpoint " + self.path("state")), "ok")
        self.assertEqual(partner.ask("advance"), "ok")
        self.assertEqual(fields["out/velocity/values"][0], 4.125)

    def test_threads_are_those_asked_for(self):
        for threads in (1, 2):
            partner, fields = self.start(
                "x = 1\n", "sandglass.send('velocity', O.numThreads)\n", ("velocity",), threads, "%d.h5" % threads
            )
            self.assertEqual(partner.ask("advance"), "ok")
            self.assertEqual(fields["out/velocity/values"][0], threads)


class StageTest(YadeTest):
    """Without the protocol's variables a script runs once."""

    def run_stage(self, text):
        script = write(self.path("stage.py"), text)
        environment = {name: value for name, value in os.environ.items() if not name.startswith("SANDGLASS_")}
        environment.update(SANDGLASS_SCRIPT=script, PYTHONPATH=PYTHON)
        return subprocess.run(
            [sys.executable, RESIDENT], cwd=self.place.name, env=environment, capture_output=True, text=True, timeout=60
        )

    def test_a_good_script(self):
        result = self.run_stage("O.bodies.append(sphere((0, 0, 0), 1))\nO.save('packing.yade')\nprint('made')\n")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("made", result.stdout)
        self.assertTrue(os.path.exists(self.path("packing.yade")))

    def test_a_script_that_raises(self):
        result = self.run_stage("x = 1\nraise ValueError('bad grain')\n")
        self.assertEqual(result.returncode, 1)
        self.assertIn("bad grain", result.stderr)
        self.assertIn('stage.py", line 2', result.stderr)

    def test_a_script_that_exits(self):
        self.assertEqual(self.run_stage("import sys\nsys.exit(3)\n").returncode, 3)


if __name__ == "__main__":
    unittest.main()
