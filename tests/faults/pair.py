"""Two scripted participants in a workflow, what they must send, and what must be left of their run when it fails."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "integration"))

import numpy

from case import PYTHON, SCRIPTED, Case, Record


def command(*behaviour, abilities=None):
    words = [PYTHON, "-S", "-E", SCRIPTED]
    if abilities is not None:
        words += ["--abilities", abilities]
    return "[%s]" % ", ".join("'%s'" % word for word in words + list(behaviour))


def pair(left=(), right=(), windows=5, length=3, deadline="20 s", scheme="serial-explicit", process="resident",
         exchange="mapped", stages="", abilities=None, answered=True):
    """A workflow of two scripted participants: `left` sends a force, `right` a motion, which answers the force or not.

    Answered, numbers grow a hundredfold in every window; for long runs they must not.
    """
    return """\
sandglass: 1
name: pair
stages:
  couple: {run: coupling}
%s
participants:
  left: {solver: command, command: %s, deadline: %s, process: %s}
  right: {solver: command, command: %s, deadline: %s, process: %s}
coupling:
  scheme: %s
  window: 1 ms
  end: %g ms
  order: [left, right]
  exchange: %s
  fields:
    force: {unit: N, shape: [%d], from: left, to: right}
    motion: {unit: m, shape: [%d, 2], from: right%s}
""" % (stages, command(*left, abilities=abilities), deadline, process, command(*right, abilities=abilities), deadline,
       process,
       scheme, windows, exchange, length, length, ", to: left" if answered else "")


def expected(windows, length=3, answered=True):
    """What the two of `pair` send, by the rules in scripted_participant.py: force and motion of every window."""
    left = right = 0.0
    motion = numpy.zeros(2 * length)
    forces, motions = [], []
    for window in range(1, windows + 1):
        left += (sum(motion.tolist()) if answered else 0) + window
        force = left * numpy.arange(1.0, length + 1)
        right += sum(force.tolist()) + window
        motion = right * numpy.arange(1.0, 2 * length + 1)
        forces.append(force)
        motions.append(motion.reshape(length, 2))
    return numpy.array(forces).reshape(windows, length), numpy.array(motions).reshape(windows, length, 2)


def windows_of(started):
    """How many windows the record of a run holds by now; 0 while it is being made."""
    try:
        return Record(started.path("record.h5")).windows
    except (OSError, KeyError):
        return 0


class FaultCase(Case):
    def assert_record(self, record, windows, length=3, answered=True):
        """A readable record with exactly these windows, all of them right."""
        self.assertEqual((record.filetype, record.version, record.windows), ("sandglass record", [1, 0], windows))
        forces, motions = expected(windows, length, answered)
        numpy.testing.assert_array_equal(record["force"], forces)
        numpy.testing.assert_array_equal(record["motion"], motions)
