"""The participant protocol, version 1, for a solver written in or driven from Python.

    from sandglass_participant import connect

    participant = connect()

    def advance():
        drag = participant.receive("drag")              # numpy array, SI
        participant.send("velocity", new_velocity)

    participant.serve(advance)

The protocol and the layout of the slot are documented in templates/README.md.
"""

import mmap
import os
import sys
import time
import traceback

import h5py
import numpy

__all__ = ["connect", "Participant", "Window"]

FILETYPE = "sandglass slot"
VERSION = 1  # of the protocol and of the slot's layout


class Window:
    """The coupling window that is being computed; the numbers are those of the slot at this moment."""

    def __init__(self, window, time):
        self._window = window
        self._time = time

    @property
    def index(self):
        """Index of the window, from 1."""
        return int(self._window[0])

    @property
    def iteration(self):
        """Iteration within the window, from 1."""
        return int(self._window[1])

    @property
    def begin(self):
        """Begin of the window in s."""
        return float(self._time[0])

    @property
    def end(self):
        """End of the window in s."""
        return float(self._time[1])


def connect():
    """The participant that the environment describes (SANDGLASS_COMMANDS, _REPLIES, _SLOT).

    Raises RuntimeError when a variable is missing, ValueError when the slot is not one.
    """
    missing = [name for name in ("SANDGLASS_COMMANDS", "SANDGLASS_REPLIES", "SANDGLASS_SLOT") if name not in os.environ]
    if missing:
        raise RuntimeError("%s not set: this script is started by Sandglass, as a participant" % ", ".join(missing))
    return Participant(
        int(os.environ["SANDGLASS_COMMANDS"]), int(os.environ["SANDGLASS_REPLIES"]), os.environ["SANDGLASS_SLOT"]
    )


class Participant:
    """One side of the exchange. Fields are float64 arrays in SI units.

    Fields live in `_incoming` and `_outgoing`, by name, as (values, shape): views of the mapped slot, or arrays of
    their own where fields cross as fresh files.
    """

    def __init__(self, commands, replies, slot):
        self._commands = commands
        self._replies = replies
        self._pending = b""
        self._sent = set()
        self._scripts = {os.environ.get("SANDGLASS_SCRIPT"), os.path.abspath(sys.argv[0] if sys.argv else "")}
        self._open_slot(slot)

    # ---- fields

    def receive(self, name):
        """The field `name` of this window: an array of the actual shape, the caller's own to change."""
        whole = self._whole_incoming.get(name)
        if whole is not None and whole[1][0] == len(whole[0]):
            return whole[0].copy()
        try:
            values, shape = self._incoming[name]
        except KeyError:
            raise self._unknown(name, "received", self._incoming) from None
        return values[: shape[0]].copy() if shape.size else values.copy()

    def send(self, name, values):
        """Sends an array (or a number, for a field of one value) as the field `name`.

        A shape other than the workflow's is sent as it is: the orchestrator then ends the run and says so.
        """
        whole = self._whole_outgoing.get(name)
        if whole is not None and type(values) is numpy.ndarray and values.shape == whole[0].shape:
            target, shape, its_bytes = whole
            target[...] = values
            shape[:] = its_bytes
            self._sent.add(name)
            return
        try:
            target, shape = self._outgoing[name]
        except KeyError:
            raise self._unknown(name, "sent", self._outgoing) from None
        values = numpy.asarray(values, dtype=numpy.float64)
        if values.ndim == 0 and shape.size == 1:
            values = values.reshape(1)
        if values.ndim != shape.size:
            raise ValueError(
                "field '%s' is sent with shape %s, the workflow gives it shape %s"
                % (name, list(values.shape), list(target.shape))
            )
        shape[:] = values.shape
        if self._file is not None:
            self._outgoing[name] = (values.copy(), shape)
        elif values.shape == target.shape:
            target[...] = values
        elif values.shape[1:] == target.shape[1:] and len(values) < len(target):
            target[: len(values)] = values
        self._sent.add(name)

    def wants(self, name):
        """Whether anybody receives or records the field `name` from this participant."""
        return name in self._outgoing

    # ---- lines without answer

    def note(self, text):
        """A remark for the report."""
        self._write("note " + _one_line(text))

    def saved(self, name, seconds):
        """What leaving out `name` has saved in this run, in s."""
        self._write("saved %s %.9g" % (name, seconds))

    def failed(self, problem):
        """Replies `error` for an exception; its traceback goes to the log. Also usable in place of `ready`."""
        traceback.print_exception(type(problem), problem, problem.__traceback__)
        sys.stderr.flush()
        self._write("error " + self._describe(problem))

    # ---- the loop

    def serve(self, advance, save=None, restore=None, checkpoint=None, load=None, script=None):
        """Says `ready` and answers commands until `stop` or the end of the command descriptor.

        `advance()`, `save()` and `restore()` take nothing; `checkpoint(path)`, `load(path)` and `script(path)` a path.
        """
        plain = {"save": save, "restore": restore}
        with_path = {"checkpoint": checkpoint, "load": load, "script": script}
        abilities = (" memory" if save and restore else "") + (" disk" if checkpoint and load else "")
        ok = b"ok\n"
        try:
            self._write("ready %d%s" % (VERSION, abilities))
            while True:
                line = self._read_line()
                begin = time.perf_counter_ns()
                if line is None:
                    return
                try:
                    if line == "advance":
                        self._advance(advance)
                    elif line == "stop":
                        os.write(self._replies, ok)
                        return
                    elif line.startswith("advance "):
                        self._advance_files(advance, line[len("advance ") :], begin)
                    else:
                        self._other(line, plain, with_path)
                except KeyboardInterrupt:
                    raise
                except BaseException as problem:  # sys.exit() in a script must not end the conversation either
                    self.failed(problem)
                else:
                    self._seconds[0] = (time.perf_counter_ns() - begin) * 1e-9
                    os.write(self._replies, ok)
        except BrokenPipeError:
            return  # nobody listens any more: the same as the end of the commands

    def _advance(self, advance):
        if self._map is None:
            raise ValueError("'advance' without files, but the slot is not mapped (transport 'file')")
        self._sent.clear()
        advance()
        self._check_sent()

    def _advance_files(self, advance, paths, begin):
        read, write = _two_paths(paths)
        kept = self._incoming, self._outgoing, self.window, self._whole_incoming, self._whole_outgoing
        self._whole_incoming, self._whole_outgoing = {}, {}
        self._sent.clear()
        try:
            with h5py.File(read, "r", locking=False) as file:
                self._incoming = {
                    name: (group["values"][...], group["shape"][...]) for name, group in file.get("in", {}).items()
                }
                numbers, times = file["window"][...], file["time"][...]
            # The declared shapes stay at hand for the message about a wrong number of axes.
            self._outgoing = {name: (values, shape.copy()) for name, (values, shape) in kept[1].items()}
            self.window = Window(numbers, times)
            self._file = write
            advance()
            self._check_sent()
            self._write_file(write, numbers, times, begin)
        finally:
            self._file = None
            self._incoming, self._outgoing, self.window, self._whole_incoming, self._whole_outgoing = kept

    def _other(self, line, plain, with_path):
        command, _, argument = line.partition(" ")
        if command in plain and not argument:
            handler = plain[command]
            arguments = ()
        elif command in with_path and argument:
            handler = with_path[command]
            arguments = (argument,)
            if command == "script":
                self._scripts.add(argument)
        else:
            raise ValueError("unknown command '%s'" % line)
        if handler is None:
            raise ValueError("this participant is not able to '%s'" % command)
        handler(*arguments)

    def _check_sent(self):
        if len(self._sent) != len(self._outgoing):
            forgotten = sorted(set(self._outgoing) - self._sent)
            raise ValueError("field%s %s not sent in this window" % ("s" * (len(forgotten) > 1), ", ".join(forgotten)))

    # ---- lines

    def _read_line(self):
        """The next line without its end, or None at the end of the commands."""
        if not self._pending:
            chunk = os.read(self._commands, 4096)
            if chunk == b"advance\n":  # nearly always: what a short window costs is partly here
                return "advance"
            if not chunk:
                return None
            self._pending = chunk
        while True:
            line, end, rest = self._pending.partition(b"\n")
            if end:
                self._pending = rest
                return os.fsdecode(line)
            chunk = os.read(self._commands, 4096)
            if not chunk:
                return None
            self._pending += chunk

    def _write(self, text):
        data = text.encode("utf-8", "replace") + b"\n"
        while data:
            data = data[os.write(self._replies, data) :]

    def _describe(self, problem):
        """`TYPE: text (script:line)`, in one line; the line is the innermost one in a script of the user."""
        text = _one_line(problem.msg if isinstance(problem, SyntaxError) else problem)
        place = ""
        if isinstance(problem, SyntaxError) and problem.filename:
            place = " (%s:%s)" % (problem.filename, problem.lineno)
        else:
            frames = [(frame.f_code.co_filename, line) for frame, line in traceback.walk_tb(problem.__traceback__)]
            own = [frame for frame in frames if frame[0] in self._scripts]
            frames = own or [frame for frame in frames if frame[0] != __file__]
            if frames:
                place = " (%s:%d)" % frames[-1]
        return (type(problem).__name__ + (": " + text if text else ""))[:2000] + place

    @staticmethod
    def _unknown(name, verb, known):
        return KeyError(
            "field '%s' is not %s by this participant; it has: %s" % (name, verb, ", ".join(sorted(known)) or "none")
        )

    # ---- the slot

    def _open_slot(self, path):
        """Maps the slot; HDF5 is asked once where the bytes are and then left alone."""
        self._map = None
        self._file = None
        self._units = {}
        with h5py.File(path, "r", locking=False) as file:
            filetype = _text(file.attrs.get("filetype", ""))
            version = list(file.attrs.get("version", [0, 0]))
            if filetype != FILETYPE or version[0] != VERSION:
                raise ValueError(
                    "%s: filetype '%s' version %s, expected '%s' version %d.x"
                    % (path, filetype, ".".join(str(number) for number in version), FILETYPE, VERSION)
                )
            mapped = _text(file.attrs.get("transport", "mapped")) == "mapped"
            if mapped:
                with open(path, "r+b") as raw:
                    self._map = mmap.mmap(raw.fileno(), 0)
            array = self._view if mapped else lambda dataset: dataset[...]
            fields = {
                side: {name: (array(group["values"]), array(group["shape"])) for name, group in file[side].items()}
                for side in ("in", "out")
                if side in file
            }
            for group in file.get("out", {}).values():
                self._units[group.name.rpartition("/")[2]] = _text(group["values"].attrs.get("unit", ""))
            self.window = Window(array(file["window"]), array(file["time"]))
            self._seconds = array(file["seconds"])
        self._incoming = fields.get("in", {})
        self._outgoing = fields.get("out", {})
        # The same fields for when they are as large as they can be, which most always are: numpy's small operations
        # take longer than the rest of a short window. Number of rows as a plain integer, shape as its bytes.
        self._whole_incoming, self._whole_outgoing = {}, {}
        if mapped:
            self._whole_incoming = {
                name: (values, memoryview(shape)) for name, (values, shape) in self._incoming.items() if values.ndim
            }
            self._whole_outgoing = {
                name: (values, memoryview(shape).cast("B"), numpy.array(values.shape, dtype=numpy.int64).tobytes())
                for name, (values, shape) in self._outgoing.items()
                if values.size
            }

    def _view(self, dataset):
        if dataset.size == 0:
            return numpy.empty(dataset.shape, dataset.dtype)
        offset = dataset.id.get_offset()
        if offset is None:
            raise ValueError("dataset %s of the slot is not contiguous and allocated" % dataset.name)
        view = numpy.frombuffer(self._map, dtype=dataset.dtype, count=dataset.size, offset=offset)
        return view.reshape(dataset.shape)

    def _write_file(self, path, numbers, times, begin):
        part = path + ".part"
        with h5py.File(part, "w") as file:
            file.attrs["filetype"] = FILETYPE
            file.attrs["version"] = numpy.array([VERSION, 0], dtype=numpy.int64)
            file["window"] = numbers
            file["time"] = times
            for name, (values, shape) in self._outgoing.items():
                group = file.create_group("out/" + name)
                group["values"] = values
                group["values"].attrs["unit"] = self._units.get(name, "")
                group["shape"] = shape
            file["seconds"] = numpy.array([(time.perf_counter_ns() - begin) * 1e-9])
        os.replace(part, path)


def _one_line(text):
    # str() of a KeyError is the quoted text; the plain text reads better.
    if isinstance(text, KeyError) and len(text.args) == 1 and isinstance(text.args[0], str):
        text = text.args[0]
    return " ".join(str(text).split())


def _text(attribute):
    return attribute.decode("utf-8", "replace") if isinstance(attribute, bytes) else str(attribute)


def _two_paths(text):
    """IN and OUT of `advance IN OUT`; a space within IN is recognised by the file being there."""
    place = text.find(" ")
    while place > 0:
        if os.path.isfile(text[:place]):
            return text[:place], text[place + 1 :]
        place = text.find(" ", place + 1)
    raise FileNotFoundError("no such file to read fields from: 'advance %s'" % text)


if __name__ == "__main__":
    # python3 -m sandglass_participant: a participant whose whole program is its rendered script.
    import runpy

    runpy.run_path(os.environ["SANDGLASS_SCRIPT"], run_name="__main__")
