"""The orchestrator's side of the participant protocol in a few lines, so that the Python side is tested alone."""

import mmap
import os
import re
import select
import subprocess
import sys

import h5py
import numpy

TEMPLATES = os.path.realpath(os.path.join(os.path.dirname(__file__), "..", "..", "..", "templates"))
PYTHON = os.path.join(TEMPLATES, "python")
RESIDENT = os.path.join(TEMPLATES, "yade", "resident.py")


def render(template, values):
    """A template with {{name}} and sections that do not nest, which is all that the tests here need."""
    with open(os.path.join(TEMPLATES, template)) as file:
        text = file.read()
    text = re.sub(r"\{\{([#^])(\w+)\}\}\n(.*?)\{\{/\2\}\}\n",
                  lambda match: match.group(3) if values[match.group(2)] == (match.group(1) == "#") else "", text,
                  flags=re.DOTALL)
    return re.sub(r"\{\{(\w+)\}\}", lambda match: repr(values[match.group(1)]), text)


def write(path, text):
    with open(path, "w") as file:
        file.write(text)
    return path


def make_slot(path, incoming, outgoing, transport="mapped"):
    """A slot as the orchestrator makes it; fields are given as name to shape."""

    def allocate(group, name, shape, kind):
        properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        properties.set_layout(h5py.h5d.CONTIGUOUS)
        properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        space = h5py.h5s.create_simple(shape)
        h5py.h5d.create(group.id, name.encode(), h5py.h5t.py_create(numpy.dtype(kind)), space, properties)

    with h5py.File(path, "w") as file:
        file.attrs["filetype"] = "sandglass slot"
        file.attrs["version"] = numpy.array([1, 0])
        file.attrs["participant"] = "tested"
        file.attrs["transport"] = transport
        allocate(file, "window", (2,), "<i8")
        allocate(file, "time", (2,), "<f8")
        allocate(file, "seconds", (1,), "<f8")
        for side, fields in (("in", incoming), ("out", outgoing)):
            file.create_group(side)
            for name, shape in fields.items():
                group = file.create_group(side + "/" + name)
                allocate(group, "values", shape, "<f8")
                allocate(group, "shape", (len(shape),), "<i8")
                group["values"].attrs["unit"] = "1"
                group["shape"][...] = shape
    return path


class MappedSlot:
    """The slot's datasets as arrays in memory, by their path."""

    def __init__(self, path):
        with open(path, "r+b") as file:
            self._map = mmap.mmap(file.fileno(), 0)
        self._views = {}
        with h5py.File(path, "r", locking=False) as file:
            file.visititems(self._add)

    def _add(self, name, item):
        if isinstance(item, h5py.Dataset):
            view = numpy.frombuffer(self._map, item.dtype, item.size, item.id.get_offset())
            self._views[name] = view.reshape(item.shape)

    def __getitem__(self, name):
        return self._views[name]


class Partner:
    """A participant's process with our ends of its two pipes."""

    def __init__(self, arguments, directory, slot, script=None, threads=1, path=None):
        commands_read, self.commands = os.pipe()
        self.replies, replies_write = os.pipe()
        environment = dict(
            os.environ,
            SANDGLASS_COMMANDS=str(commands_read),
            SANDGLASS_REPLIES=str(replies_write),
            SANDGLASS_SLOT=slot,
            SANDGLASS_THREADS=str(threads),
            SANDGLASS_PYTHON=PYTHON,
            PYTHONPATH=PYTHON,
        )
        if script:
            environment["SANDGLASS_SCRIPT"] = script
        if path is not None:
            environment["PATH"] = path
        self.log = os.path.join(directory, "log")
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                [sys.executable] + arguments,
                cwd=directory,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                pass_fds=(commands_read, replies_write),
            )
        os.close(commands_read)
        os.close(replies_write)
        self._pending = b""

    def line(self, deadline=60):
        """The next line of the participant, or None when it has closed its end."""
        while b"\n" not in self._pending:
            if not select.select([self.replies], [], [], deadline)[0]:
                raise TimeoutError("no answer; log: " + open(self.log).read())
            chunk = os.read(self.replies, 65536)
            if not chunk:
                return None
            self._pending += chunk
        line, _, self._pending = self._pending.partition(b"\n")
        return line.decode()

    def ask(self, command):
        os.write(self.commands, command.encode() + b"\n")
        return self.line()

    def end_of_commands(self):
        os.close(self.commands)
        self.commands = None

    def wait(self, deadline=20):
        return self.process.wait(deadline)

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        for descriptor in (self.commands, self.replies):
            if descriptor is not None:
                os.close(descriptor)
