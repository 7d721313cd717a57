"""What scripted_participant.py computes, through Sandglass's own Python module: mapped slots and fresh files alike.

With an argument NAME=SHAPE (velocity=1,3) it sends that field with this shape, through a file of its own making.
"""

import os
import sys

import h5py
import numpy
import sandglass_participant
from sandglass_participant import connect

participant = connect()
state = 0.0
inputs = os.environ["INPUTS"].split()
outputs = dict(text.split("=") for text in os.environ["OUTPUTS"].split())


def advance():
    global state
    state += sum(float(numpy.sum(participant.receive(name))) for name in inputs) + participant.window.index
    for name, shape in outputs.items():
        size = [int(length) for length in shape.split(",")]
        participant.send(name, state * (numpy.arange(numpy.prod(size)) + 1.0).reshape(size))


def checkpoint(path):
    with open(path, "w") as file:
        file.write(repr(state))


def load(path):
    global state
    with open(path) as file:
        state = float(file.read())


def send_another_shape(name, shape):
    """As a foreign program would: it writes the file by itself and replaces ours."""
    replace = os.replace

    def write(part, path):
        with h5py.File(part, "r+") as file:
            del file["out/%s/values" % name]
            file["out/%s/values" % name] = numpy.ones(shape)
        replace(part, path)

    sandglass_participant.os.replace = write


for argument in sys.argv[1:]:
    field, _, lengths = argument.partition("=")
    send_another_shape(field, [int(length) for length in lengths.split(",") if length])
participant.serve(advance, checkpoint=checkpoint, load=load)
