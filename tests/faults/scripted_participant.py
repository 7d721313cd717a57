"""A participant for tests: it does as it is told, also badly. Python's standard library alone.

    scripted_participant.py [--abilities "memory disk"] [MOMENT BEHAVIOUR]...

Unless told otherwise it speaks the protocol of templates/README.md over a mapped slot. In every window it adds the
sum of what it receives, and the window's index, to its state, and sends state * (i + 1) as value i of every field.
What it is asked goes to its log.

MOMENT is `ready`, a command (`advance`, `save`, `stop`, ...), or `advance@3`: the advance of window 3.

BEHAVIOUR      what it does at that moment
exit=N         ends with this status
kill           kills itself with SIGKILL
exit-soon=N    answers as it should, then ends with this status
stall          never answers
idle           does nothing of it, and answers as it should
deaf           answers, then neither exits nor listens, whatever it is sent
late=S         answers as it should, after S seconds
half           writes half a line, then stalls
half-exit=N    writes half a line, then ends
say=TEXT       writes this line in place of its answer
before=TEXT    writes this line ahead of its answer
flood          writes notes without end, as fast as it can
drip           writes notes without end, one every 20 ms
endless        writes one line without end
value=X        sends X (nan, inf, -inf, 1e300) as its first value
rows=N         says that the first axis of its fields has N rows
columns=N      says that the last axis of its fields is N long
forget         sends nothing
truncate       cuts its own slot to nothing, then answers
grandchild     starts a program that ignores signals, writes its number to the file `grandchild`, goes on as it should
"""

import mmap
import os
import signal
import struct
import sys
import time

from plain_hdf5 import contiguous_datasets


class Slot:
    """The mapped slot: datasets by path as (memory, shape)."""

    def __init__(self, path):
        with open(path, "r+b") as file:
            self._memory = mmap.mmap(file.fileno(), 0)
        self._places = contiguous_datasets(self._memory[:])

    def fields(self, side):
        return sorted({path.split("/")[2] for path in self._places if path.startswith("/" + side + "/")})

    def size(self, path):
        count = 1
        for length in self._places[path][1]:
            count *= length
        return count

    def shape(self, path):
        return list(self._places[path][1])

    def read(self, path, kind, count=None):
        count = self.size(path) if count is None else count
        return struct.unpack_from("<%d%s" % (count, kind), self._memory, self._places[path][0])

    def write(self, path, kind, values):
        struct.pack_into("<%d%s" % (len(values), kind), self._memory, self._places[path][0], *values)


class Participant:
    def __init__(self, abilities, script):
        self.abilities = abilities
        self.script = script
        self.commands = os.fdopen(int(os.environ["SANDGLASS_COMMANDS"]))
        self.replies = int(os.environ["SANDGLASS_REPLIES"])
        self.slot = Slot(os.environ["SANDGLASS_SLOT"])
        self.state = 0.0
        self.kept = 0.0

    def run(self):
        self.answer("ready", ("ready 1 " + self.abilities).strip())
        for line in self.commands:
            command, _, path = line.rstrip("\n").partition(" ")
            self.answer(command, "ok", path)
            if command == "stop":
                return

    # ---- what it should do

    def perform(self, command, path, faults):
        if "idle" in faults:
            return
        if command == "advance":
            self.advance(faults)
        elif command == "save":
            self.kept = self.state
        elif command == "restore":
            self.state = self.kept
        elif command == "checkpoint":
            with open(path, "w") as file:
                file.write(repr(self.state))
        elif command == "load":
            with open(path) as file:
                self.state = float(file.read())

    def advance(self, faults):
        index = self.slot.read("/window", "q")[0]
        for name in self.slot.fields("in"):
            count = 1
            for length in self.slot.read("/in/%s/shape" % name, "q"):
                count *= length
            self.state += sum(self.slot.read("/in/%s/values" % name, "d", count))
        self.state += index
        for name in self.slot.fields("out"):
            path = "/out/%s/" % name
            values = [self.state * (i + 1) for i in range(self.slot.size(path + "values"))]
            shape = self.slot.shape(path + "values")
            if "value" in faults:
                values[0] = float(faults["value"])
            if "rows" in faults:
                shape[0] = int(faults["rows"])
            if "columns" in faults:
                shape[-1] = int(faults["columns"])
            self.slot.write(path + "values", "d", values)
            if "forget" not in faults:
                self.slot.write(path + "shape", "q", shape)
        self.slot.write("/seconds", "d", [0.125])

    # ---- what it is told to do

    def answer(self, command, line, path=""):
        print("asked", command, path, file=sys.stderr, flush=True)
        faults = self.faults(command)
        if "exit" in faults:
            print("leaving on purpose", file=sys.stderr, flush=True)
            os._exit(int(faults["exit"]))
        if "kill" in faults:
            os.kill(os.getpid(), signal.SIGKILL)
        if "stall" in faults:
            self.sleep_for_ever()
        if "half" in faults or "half-exit" in faults:
            os.write(self.replies, line[: len(line) // 2].encode())
            if "half-exit" in faults:
                os._exit(int(faults["half-exit"]))
            self.sleep_for_ever()
        if "flood" in faults:
            while True:
                os.write(self.replies, b"note flood\n" * 1000)
        if "drip" in faults:
            while True:
                self.write("note drip")
                time.sleep(0.02)
        if "endless" in faults:
            while True:
                os.write(self.replies, b"x" * 10000)
        if "grandchild" in faults:
            self.start_grandchild()
        if "truncate" in faults:
            self.perform(command, path, faults)
            os.truncate(os.environ["SANDGLASS_SLOT"], 0)
            self.write(line)  # its own mapping is gone too
            self.sleep_for_ever()
        if "late" in faults:
            time.sleep(float(faults["late"]))
        if "before" in faults:
            self.write(faults["before"])
        self.perform(command, path, faults)
        if "deaf" in faults:
            for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
                signal.signal(number, signal.SIG_IGN)
        self.write(faults.get("say", line))
        if "exit-soon" in faults:
            os._exit(int(faults["exit-soon"]))
        if "deaf" in faults:
            self.sleep_for_ever()

    def faults(self, command):
        """Behaviours of this moment: name to what stands behind the equals sign."""
        moments = [command]
        if command == "advance":
            moments.append("advance@%d" % self.slot.read("/window", "q")[0])
        told = [behaviour for moment, behaviour in self.script if moment in moments]
        return {name: value for name, _, value in (behaviour.partition("=") for behaviour in told)}

    def start_grandchild(self):
        import subprocess  # slow to load, and seldom needed

        program = "import signal, time; [signal.signal(n, signal.SIG_IGN) for n in (1, 2, 15)]; time.sleep(1000)"
        grandchild = subprocess.Popen([sys.executable, "-S", "-E", "-c", program])
        with open("grandchild", "w") as file:
            file.write("%d\n" % grandchild.pid)

    def write(self, line):
        os.write(self.replies, line.encode() + b"\n")

    @staticmethod
    def sleep_for_ever():
        while True:
            time.sleep(1000)


def main():
    arguments = sys.argv[1:]
    abilities = "memory disk"
    if arguments[:1] == ["--abilities"]:
        abilities = arguments[1]
        del arguments[:2]
    Participant(abilities, list(zip(arguments[::2], arguments[1::2]))).run()


main()
