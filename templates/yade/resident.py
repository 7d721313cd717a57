"""Keeps one YADE alive: as a participant between coupling windows, or for a single script.

    /usr/bin/python3 resident.py

With SANDGLASS_COMMANDS in the environment it runs the script of SANDGLASS_SCRIPT once and then answers the participant
protocol: every `advance` executes the script that `script PATH` named last. Both see YADE's own names and `sandglass`,
the participant. Without SANDGLASS_COMMANDS it runs the script and exits, 1 after an exception: a `yade` stage.

SANDGLASS_THREADS is the number of OpenMP threads; 1, the default, repeats bit by bit.

Two things that YADE's files do not hold and that a window script therefore sets or fetches anew in every window:
permanent forces (O.forces.setPermF), and references to bodies and engines (loading replaces the objects).
"""

import builtins
import os
import shutil
import sys
import traceback
import types


def start_yade(threads):
    """Starts YADE within this process and returns its namespace, in which scripts run.

    YADE's launcher opens two network ports when it runs as a program (a Python prompt and an XML-RPC service, on all
    addresses) but none when its code runs under another name than `__main__`; everything else is the same.
    """
    launcher = shutil.which("yade")
    if launcher is None:
        raise FileNotFoundError("no program 'yade' on PATH (Debian: apt install yade)")
    # YADE's PyRunner evaluates in the module __main__ and keeps engine labels in its __builtins__: scripts live there.
    main = types.ModuleType("__main__")
    namespace = main.__dict__
    namespace["__builtins__"] = builtins
    namespace["__name__"] = "yade_launcher"
    sys.modules["__main__"] = main
    # YADE imports IPython for its version only: a quarter of the start-up time for a prompt that is never shown.
    ipython = types.ModuleType("IPython")
    ipython.__version__ = "8.5.0"
    sys.modules["IPython"] = ipython
    os.environ.setdefault("HOME", os.getcwd())  # YADE does not start without one
    os.environ.pop("OMPI_COMM_WORLD_RANK", None)  # nor does it belong to an MPI job around us
    sys.argv = ["yade", "-n", "-x", "-j", str(threads)]
    with open(launcher, encoding="utf-8") as file:
        code = compile(file.read(), launcher, "exec")
    exec(code, namespace)
    # YADE removes its folder in /tmp only when it leaves in its own way; nothing of ours uses it.
    folder = os.path.dirname(namespace["O"].tmpFilename())
    if os.path.basename(folder).startswith("yade-"):
        shutil.rmtree(folder, ignore_errors=True)
    del sys.modules["IPython"]  # a script that wants the real one gets it
    namespace["__name__"] = "__main__"
    return namespace


def compile_script(path):
    """The script's code, under its real name so that tracebacks show it."""
    with open(path, "rb") as file:
        return compile(file.read(), path, "exec")


def run_script(path, namespace):
    """Executes a script in YADE's namespace as if YADE had been started with it."""
    namespace["__file__"] = path
    sys.argv = [path]
    exec(compile_script(path), namespace)


class Grains:
    """The handlers of the protocol's commands; the state is YADE's own."""

    def __init__(self, namespace):
        self._namespace = namespace
        self._omega = namespace["O"]
        self._code = None

    def script(self, path):
        self._code = compile_script(path)

    def advance(self):
        if self._code is None:
            raise RuntimeError("'advance' before 'script': there is no script to execute")
        exec(self._code, self._namespace)

    def save(self):
        # Loaded at once, for the reason given at checkpoint: the first try of a window is then like its repetitions.
        self._omega.saveTmp()
        self._omega.loadTmp()

    def restore(self):
        self._omega.loadTmp()

    def checkpoint(self, path):
        self._omega.save(path)
        # Collider and contact list keep a history that is not in the file: whoever loads goes on differently in the
        # last bits from the process that saved. So this process loads as well, and both go on alike.
        self._omega.load(path)

    def load(self, path):
        self._omega.load(path)


def take_part(script, threads):
    """Runs the script and serves as a participant. Returns the exit status."""
    namespace = start_yade(threads)
    from sandglass_participant import connect  # after YADE, which must find its thread number unread

    participant = connect()
    namespace["sandglass"] = participant
    try:
        if script is not None:
            run_script(script, namespace)
    except BaseException as problem:
        participant.failed(problem)
        return 1
    grains = Grains(namespace)
    participant.serve(
        grains.advance, grains.save, grains.restore, grains.checkpoint, grains.load, grains.script
    )
    return 0


def run_once(script, threads):
    """Runs the script as a stage. Returns the exit status."""
    try:
        run_script(script, start_yade(threads))
    except SystemExit as ending:
        if isinstance(ending.code, str):
            print(ending.code, file=sys.stderr)
        return ending.code if isinstance(ending.code, int) else int(ending.code is not None)
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


def main():
    script = os.environ.get("SANDGLASS_SCRIPT")
    threads = int(os.environ.get("SANDGLASS_THREADS", "1"))
    if "SANDGLASS_COMMANDS" in os.environ:
        return take_part(script, threads)
    if script is None:
        print("resident.py: SANDGLASS_SCRIPT names no script to run", file=sys.stderr)
        return 2
    return run_once(script, threads)


if __name__ == "__main__":
    try:
        status = main()
    except BaseException:
        traceback.print_exc()
        status = 1
    # Leaving the ordinary way runs the destructors of YADE's libraries, which takes long and can crash.
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
