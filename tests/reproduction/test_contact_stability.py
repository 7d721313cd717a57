"""A mass on a contact spring against a body with mass, exchanged once a window: growth and limits against theory.

Theory, with kp = k dt^2 / m_p and ks = k dt^2 / m_s: the order of the MPM-DEM paper (sphere by velocity Verlet against the
old wall, then Newmark's method with the new force) has the amplification factors

    z^3 + (kp + ks/4 - 2) z^2 + (1 + ks/2) z + ks/4 = 0,

which is unstable for every window; a dashpot c > dt k m* / m_s holds it (m* the reduced mass, one window of lag). One impact
ends with the restitution exp(l pi/2 dt sqrt(k m*) / m_s), l windows of lag; a mode of the body that is much faster than the
contact, of frequency w_j, grows by l k dt^2 / (2 m_s) / (1 + (w_j dt/2)^2)^2 per window. Where the body steps by leapfrog
there is no lag and a limit, dt < 2 sqrt(m* / k), which a light node of the body makes small; a dashpot alone gives
G = 1 - c dt / m_s. Where the contact comes to rest within a window, the sphere is an attached mass: G = -m_p/m_s per window
whatever its length, and a relaxation w gives 1 - w (1 + m_p/m_s).
"""

import math
import os
import re
import sys
import unittest

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "integration"))

from case import DONE, UNSTABLE, Case

SPHERE = """
from sandglass_participant import connect
participant = connect()
m, k, c, dt, predicted = %(sphere_mass)r, %(stiffness)r, %(dashpot)r, %(window)r, %(predicted)r
x, v, force, kept = 0.0, 1.0, 0.0, None

def advance():
    global x, v, force
    u, w = participant.receive("wall")
    half = v + dt / 2 * force / m
    x += dt * half
    depth = x - u - predicted * dt * w
    force = -k * depth - c * (half - w) if depth > 0 or not %(opens)r else 0.0
    v = half + dt / 2 * force / m
    participant.send("force", -force)
    participant.send("gap", x - u)

def save():
    global kept
    kept = x, v, force

def restore():
    global x, v, force
    x, v, force = kept

participant.serve(advance, save, restore)
"""

# A sphere that has come to rest on the wall: it resists the wall's acceleration since the window before.
ATTACHED = """
from sandglass_participant import connect
participant = connect()
m, dt = %(sphere_mass)r, %(window)r
last, now, kept = 0.0, 0.0, 0.0

def advance():
    global now
    now = participant.receive("wall")[1]
    participant.send("force", -m * (now - last) / dt)
    participant.send("gap", now)

def save():
    global kept, last
    last = kept = now  # a window begins: what came last is the velocity before it

def restore():
    global last
    last = kept

%(explicit)s
participant.serve(advance, save, restore)
"""

BODY = """
from sandglass_participant import connect
participant = connect()
m, dt, push, K = %(body_mass)r, %(window)r, %(push)r, %(body_stiffness)r
u, v, a, kept = 0.0, 0.0, 0.0, None

def advance():
    global u, v, a
    force = participant.receive("force")[0] + push
    if %(leapfrog)r:
        v += dt * force / m
        u += dt * v
    else:
        # Newmark's method (1/4, 1/2), with a spring of the body's own
        new = (force - K * (u + dt * v + dt * dt / 4 * a)) / (m + dt * dt / 4 * K)
        u += dt * v + dt * dt / 4 * (a + new)
        v += dt / 2 * (a + new) if %(newmark)r else dt * new
        a = new
    participant.send("wall", [u, v])

def save():
    global kept
    kept = u, v, a

def restore():
    global u, v, a
    u, v, a = kept

participant.serve(advance, save, restore)
"""

WORKFLOW = """
sandglass: 1
name: contact
stages: {couple: {run: coupling}}
participants:
  sphere: {solver: command, command: [/usr/bin/python3, "%(place)s/%(name)s-sphere.py"]}
  body: {solver: command, command: [/usr/bin/python3, "%(place)s/%(name)s-body.py"]}
coupling:
  window: %(window)r s
  end: %(end)r s
  order: [%(order)s]
  scheme: %(scheme)s
  acceleration: %(acceleration)s
  relaxation: %(relaxation)r
  relax: [%(relax)s]
  tolerance: 1e-8
  stability: {growth: %(watched)r}  # 1.3: a body that is pushed changes faster and faster by itself
  fields:
    wall: {unit: m, shape: [2], from: body, to: sphere}
    force: {unit: N, shape: [1], from: sphere, to: body}
    gap: {unit: m, shape: [1], from: sphere}
"""


class Coupled(Case):
    def couple(self, name, sphere=SPHERE, windows=300, **changed):
        values = dict(sphere_mass=1.0, body_mass=2.0, stiffness=1.0, dashpot=0.0, window=0.2, predicted=False, push=0.0,
                      newmark=True, leapfrog=False, opens=False, body_stiffness=0.0, watched=1.3, scheme="serial-explicit", acceleration="none", relaxation=0.5, explicit="",
                      order="sphere, body", relax="wall")
        values.update(changed, place=self.place.path, name=name)
        values["end"] = windows * values["window"]
        self.place.write(name + "-sphere.py", sphere % values)
        self.place.write(name + "-body.py", BODY % values)
        return self.run_workflow(WORKFLOW % values, name=name)


class Contact(Coupled):
    def growth(self, run):
        """Amplification per window of the gap's oscillation: g(n+1) = a g(n) + b g(n-1) + c has |z|^2 = -b."""
        gap = run.record["gap"][20:, 0]
        known = numpy.column_stack([gap[1:-1], gap[:-2], numpy.ones(len(gap) - 2)])
        fitted = numpy.linalg.lstsq(known, gap[2:], rcond=None)[0]
        return math.sqrt(-fitted[1])

    def test_a_lasting_contact_grows_as_the_cubic_says(self):
        for name, window in (("short", 0.1), ("long", 0.3)):
            run = self.couple(name, window=window)
            self.assert_code(run, DONE)
            kp, ks = window**2 / 1.0, window**2 / 2.0
            roots = numpy.roots([1, kp + ks / 4 - 2, 1 + ks / 2, ks / 4])
            expected = max(abs(roots))
            self.assertGreater(expected, 1 + ks / 4)
            self.assertAlmostEqual(self.growth(run), expected, delta=1e-6)

    def test_the_parallel_scheme_grows_twice_as_fast_and_prediction_holds(self):
        serial = self.growth(self.couple("serial", window=0.1)) - 1
        parallel = self.growth(self.couple("parallel", window=0.1, scheme="parallel-explicit")) - 1
        predicted = self.growth(self.couple("predicted", window=0.1, predicted=True)) - 1
        self.assertAlmostEqual(parallel / serial, 2, delta=0.05)
        self.assertLess(abs(predicted), 0.05 * serial)

    def test_a_dashpot_holds_it_from_the_limit_on(self):
        # c > l dt k m*/m_s with l = 1; the dashpot sees the old velocity of the wall too, which is of higher order.
        window, reduced = 0.05, 1.0 * 2.0 / 3.0
        limit = window * 1.0 * reduced / 2.0
        # Growth per window, linear in c about the limit.
        below = self.growth(self.couple("below", window=window, dashpot=0.8 * limit)) - 1
        above = self.growth(self.couple("above", window=window, dashpot=1.2 * limit)) - 1
        self.assertGreater(below, 0)
        self.assertLess(above, 0)

    def test_without_lag_the_lighter_side_sets_the_limit(self):
        # Leapfrog on both sides, 2 sqrt(m*/k): a node of a hundredth of the sphere's mass, bracketed by two percent.
        limit = 2 * math.sqrt(1.0 * 0.01 / 1.01 / 1.0)
        light = dict(body_mass=0.01, leapfrog=True, windows=400)
        run = self.couple("inside", window=0.98 * limit, **light)
        self.assert_code(run, DONE)
        self.assertAlmostEqual(self.growth(run), 1, delta=1e-9)
        run = self.couple("outside", window=1.02 * limit, **light)
        self.assert_failed(run, UNSTABLE, "unstable")
        # z^2 + (k dt^2/m* - 2) z + 1 = 0
        grows = max(abs(numpy.roots([1, 4 * 1.02**2 - 2, 1])))
        told = re.search(r"window \d+: field '\w+' from \w+ diverges: its change grows ([\d.]+) times per window", run.err)
        self.assertAlmostEqual(float(told.group(1)) / grows, 1, delta=0.02, msg=run.err)

    def test_at_once_by_leapfrog(self):
        run = self.couple("jacobi", window=0.1, leapfrog=True, scheme="parallel-explicit")
        self.assertAlmostEqual(self.growth(run), math.sqrt(1 + 0.1**2 / 2.0), delta=1e-9)  # (z - 1)^2 + kp z + ks = 0

    def test_restitution_of_one_impact(self):
        window, reduced = 0.01, 1.0 * 2.0 / 3.0
        for name, lag, scheme in (("once", 1, "serial-explicit"), ("twice", 2, "parallel-explicit")):
            run = self.couple(name, window=window, opens=True, scheme=scheme, windows=400)  # a contact takes 257
            self.assert_code(run, DONE)
            gap = run.record["gap"][:, 0]
            self.assertLess(gap[-1], 0)
            restitution = -(gap[-1] - gap[-2]) / window
            expected = lag * math.pi / 2 * window * math.sqrt(1.0 * reduced) / 2.0
            self.assertAlmostEqual(math.log(restitution) / expected, 1, delta=0.02)  # the next order is window * sqrt(k/m*)

    def test_a_fast_mode_of_the_body(self):
        for name, window in (("resolved", 0.02), ("unresolved", 0.3)):
            own = 30.0**2 * 2.0  # 30 times faster than the contact
            run = self.couple(name, window=window, body_stiffness=own, windows=3000)
            self.assert_code(run, DONE)
            # The lag is exact to first order in k: modes of mass 2 and stiffness k + K, seen in the wall's own motion.
            wall = run.record["wall"][:, 0]
            known = numpy.column_stack([wall[4 - n:len(wall) - n] for n in range(1, 5)])
            roots = numpy.roots([1, *-numpy.linalg.lstsq(known, wall[4:], rcond=None)[0]])
            fastest = max(roots, key=lambda root: abs(numpy.angle(root)))
            expected = window**2 / (2 * 2.0) / (1 + (30.0 * window / 2) ** 2) ** 2
            self.assertAlmostEqual((abs(fastest) - 1) / expected, 1, delta=0.05, msg=name)

    def test_a_dashpot_beside_a_light_body(self):
        # The body sees c (v - w) of its own last velocity w: G = 1 - c dt/m_s.
        for name, ratio in (("calm", 1.9), ("wild", 2.1)):
            run = self.couple(name, window=0.01, dashpot=ratio * 2.0 / 0.01, stiffness=0.0, sphere_mass=1e9, leapfrog=True,
                              windows=60, watched=1.05)
            if ratio > 2:
                self.assert_failed(run, UNSTABLE, "unstable")
                self.assert_said(run, "grows 1.1 times per window, with alternating sign")
                continue
            self.assert_code(run, DONE)
            distance = run.record["wall"][:20, 1] - 1.0
            numpy.testing.assert_allclose(distance[1:] / distance[:-1], 1 - ratio, rtol=1e-6)

    def test_iterated_windows_neither_grow_nor_decay(self):
        for acceleration in ("constant", "aitken", "iqn-ils"):
            run = self.couple(acceleration.replace("-", "_"), window=0.3, scheme="serial-implicit", acceleration=acceleration)
            self.assert_code(run, DONE)
            self.assertAlmostEqual(self.growth(run), 1, delta=1e-6, msg=acceleration)


class AddedMass(Coupled):
    """A push of 1 N on a body with a sphere that rests on it: unstable where the sphere is heavier."""

    NOTES = dict(newmark=False, push=1.0, windows=60)

    def attached(self, name, mass, **changed):
        # In explicit schemes nobody saves: the window's begin is every advance.
        explicit = "" if changed.get("scheme") == "serial-implicit" else """
plain = advance
def advance():
    global last
    last = now
    plain()
"""
        return self.couple(name, sphere=ATTACHED, sphere_mass=mass, body_mass=1.0, explicit=explicit, order="sphere, body",
                           **{**self.NOTES, **changed})

    def test_a_lighter_sphere_settles_a_heavier_one_does_not_whatever_the_window(self):
        for name, window in (("light", 0.1), ("light_fine", 0.001)):
            run = self.attached(name, 0.5, window=window)
            self.assert_code(run, DONE)
            acceleration = numpy.diff(run.record["wall"][:, 1]) / window
            self.assertAlmostEqual(acceleration[-1] * 1.5, 1, delta=1e-6)  # 1 N on 1.5 kg
            error = acceleration - 1 / 1.5
            numpy.testing.assert_allclose(error[1:10] / error[:9], -0.5, rtol=1e-6)
        for name, window in (("heavy", 0.1), ("heavy_fine", 0.001)):
            run = self.attached(name, 1.5, window=window)
            self.assert_failed(run, UNSTABLE, "unstable")
            self.assertRegex(run.err, r"window \d+: field '\w+' from \w+ diverges: its change grows 1\.5\d* times per window, "
                                      r"with alternating sign")

    def test_relaxation_and_quasi_newton_cure_it(self):
        mass = 3.0  # limit of the relaxation 2 / (1 + 3) = 0.5
        cured = self.attached("cured", mass, scheme="serial-implicit", acceleration="constant", relaxation=0.45)
        self.assert_code(cured, DONE)
        lost = self.attached("lost", mass, scheme="serial-implicit", acceleration="constant", relaxation=0.55)
        self.assert_failed(lost, UNSTABLE, "unstable", windows=0)
        self.assert_said(lost, "did not converge")
        iterations = {}
        for acceleration in ("aitken", "iqn-ils"):
            run = self.attached(acceleration.replace("-", "_"), mass, scheme="serial-implicit", acceleration=acceleration,
                                relaxation=0.2)
            self.assert_code(run, DONE)
            speed = run.record["wall"][-1, 1]
            self.assertAlmostEqual(speed / (60 * 0.2 / (1 + mass)), 1, delta=1e-5)
            iterations[acceleration] = run.record.iterations.mean()
        self.assertLess(iterations["iqn-ils"], 5)
        self.assertLess(iterations["iqn-ils"], cured.record.iterations.mean())


if __name__ == "__main__":
    unittest.main()
