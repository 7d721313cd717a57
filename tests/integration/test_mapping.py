"""Fields between points that do not coincide: two small programs on one line, through the whole orchestrator."""

import os

import numpy

from case import DONE, HOME, PARTICIPANT, REFUSED, Case

# Nodes of the body, which change in the third window; tips of the grains, which lie between them.
BODY = """
import numpy
from sandglass_participant import connect
participant = connect()

def advance():
    nodes = numpy.linspace(0, 1, 6 if participant.window.index < 3 else 9)
    participant.send("nodes", numpy.column_stack([nodes, 0 * nodes]))
    participant.send("shape", numpy.column_stack([2 + 3 * nodes, -nodes]))
    push = participant.receive("push")
    moment = nodes[: len(push)] @ push[:, 1] if len(push) else 0.0
    participant.send("seen", [len(push), push.sum(), moment])

participant.serve(advance)
"""

GRAINS = """
import numpy
from sandglass_participant import connect
participant = connect()
all_tips = numpy.array([0.03, 0.31, 0.5, 0.97])
height, gone = %s, %s  # m, the window without any tip

def advance():
    count = 0 if participant.window.index == gone else 4
    tips = all_tips[:count]
    participant.send("tips", numpy.column_stack([tips, height + 0 * tips]))
    bent = participant.receive("shape")
    exact = numpy.column_stack([2 + 3 * all_tips, -all_tips])
    error = abs(bent - exact).max() if len(bent) else 0.0
    participant.send("error", [len(bent), error])
    participant.send("push", numpy.column_stack([0 * tips, [1.0, -2.0, 4.0, 0.5][:count]]))

participant.serve(advance)
"""

WORKFLOW = """
sandglass: 1
name: mapping
stages: {couple: {run: coupling}}
participants:
  grains: {solver: command, command: [/usr/bin/python3, "%(place)s/grains.py"]}
  body: {solver: command, command: [/usr/bin/python3, "%(place)s/body.py"]}
coupling:
  window: 1 ms
  end: 5 ms
  order: [grains, body]
  scheme: %(scheme)s
  fields:
    tips: {unit: m, shape: [{at_most: 10}, 2], from: grains}
    nodes: {unit: m, shape: [{at_most: 10}, 2], from: body}
    push: {unit: N, shape: [{at_most: 10}, 2], from: grains, to: body,
           mapping: {method: %(method)s, kind: conservative, from_points: tips, to_points: %(to)s, limit: %(limit)s}}
    shape: {unit: m, shape: [{at_most: 10}, 2], from: body, to: grains,
            mapping: {method: linear, kind: consistent, from_points: nodes, to_points: tips, limit: 10 mm}}
    error: {unit: m, shape: [2], from: grains}
    seen: {unit: N, shape: [3], from: body}
"""


class Mapping(Case):
    def run_scene(self, height=0.001, name="mapping", scheme="serial-explicit", method="linear", to="nodes", limit="10 mm", gone=0):
        self.place.write("body.py", BODY)
        self.place.write("grains.py", GRAINS % (height, gone))
        text = WORKFLOW % dict(place=self.place.path, scheme=scheme, method=method, to=to, limit=limit)
        return self.run_workflow(text, name=name)

    def test_values_are_exact_and_sums_and_moments_are_kept(self):
        for scheme in ("serial-explicit", "parallel-explicit"):
            run = self.run_scene(name=scheme, scheme=scheme)
            self.assert_code(run, DONE)
            seen, error = run.record["seen"], run.record["error"]
            # Nothing arrives before both sides have told their points; the nodes become nine in window 3.
            self.assertEqual(seen[-1, 0], 9)
            self.assertEqual(seen[0, 0], 0)
            mapped = seen[seen[:, 0] > 0]
            numpy.testing.assert_allclose(mapped[:, 1], 3.5, rtol=1e-14)
            # The moment about the origin, of windows whose push was shared out to the nodes of that window.
            numpy.testing.assert_allclose(mapped[-1:, 2], 0.03 - 2 * 0.31 + 4 * 0.5 + 0.5 * 0.97, rtol=1e-13)
            self.assertEqual(list(error[:, 0])[-3:], [4, 4, 4])
            self.assertLess(error[:, 1].max(), 1e-14)

    def test_where_nobody_pushes_the_push_is_zero(self):
        run = self.run_scene(name="gone", gone=4)
        self.assert_code(run, DONE)
        numpy.testing.assert_array_equal(run.record["seen"][3], [9, 0, 0])
        numpy.testing.assert_allclose(run.record["seen"][4, :2], [9, 3.5], rtol=1e-14)

    def test_the_nearest_point_keeps_the_sum_only(self):
        run = self.run_scene(name="nearest", method="nearest", limit="200 mm")
        self.assert_code(run, DONE)
        seen = run.record["seen"]
        numpy.testing.assert_allclose(seen[-1, 1], 3.5, rtol=1e-14)
        self.assertGreater(abs(seen[-1, 2] - 1.895), 1e-3)

    def test_a_point_out_of_reach_is_named(self):
        run = self.run_scene(height=0.02, name="far")
        self.assert_failed(run, PARTICIPANT, "failed")
        self.assert_said(run, "mapping of field 'shape' from 'nodes' to 'tips'", "point 0 at (0.03, 0.02) m is 0.02 m",
                         "limit is 0.01 m")

    def test_wrong_names_are_refused(self):
        run = self.run_scene(name="wrong", to="noodles")
        self.assert_refused(run, "there is no field 'noodles'; did you mean 'nodes'?", file="wrong.yaml")
        run = self.run_scene(name="swapped", to="tips")
        self.assert_refused(run, "field 'tips' is sent by 'grains', not by 'body'", file="swapped.yaml")
