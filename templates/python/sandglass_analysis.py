"""What an analysis stage says: quantities, curves and figures, computed from the record of a run.

    import sandglass_analysis as sandglass

    record = sandglass.open_record()
    velocity = record["velocity"][:, 0]
    sandglass.quantity("terminal_velocity", velocity[-1], "m/s", meaning="velocity at the end of the last window")
    sandglass.curve("velocity", record.time, velocity, x_unit="s", y_unit="m/s", label="computed", kind="computed")
    sandglass.figure("figure_2", title="...", panels=[dict(x="time", y="velocity", curves=["velocity"])])
    sandglass.finish()

Everything is collected and only `finish()` writes (analysis.json and one CSV per curve, into the work directory): a
script that ends early, by an exception or otherwise, leaves nothing behind that could pass for a result. Values are
SI. The format is documented in templates/README.md.
"""

import csv
import io
import json
import math
import os
import re

import h5py
import numpy

__all__ = ["open_record", "open_study", "Record", "Point", "quantity", "curve", "figure", "table", "finish"]

FORMAT = 1
KINDS = ("computed", "analytic", "published", "measured")
SCALES = ("linear", "log")

_quantities = {}
_curves = {}
_figures = []
_tables = []


class Record:
    """The complete windows of a record. Arrays have the window as their first axis."""

    def __init__(self, path):
        self._file = h5py.File(path, "r", locking=False)
        attributes = self._file.attrs
        filetype = _text(attributes.get("filetype", ""))
        if filetype != "sandglass record" or attributes["version"][0] != 1:
            raise ValueError("%s: filetype '%s', expected 'sandglass record' version 1.x" % (path, filetype))
        self.windows = int(self._file["windows"][0])
        self.begin = self._rows("time")[:, 0]  # s, begin of each window
        self.time = self._rows("time")[:, 1]  # s, end of each window

    def __getitem__(self, name):
        """The field `name`, [windows, shape...], SI. Raises KeyError naming the fields there are."""
        if name not in self:
            raise KeyError("field '%s' is not in the record; it has: %s" % (name, ", ".join(self.names) or "none"))
        return self._rows("fields/" + name)

    def __contains__(self, name):
        return name in self._file["fields"]

    @property
    def names(self):
        """The recorded fields."""
        return sorted(self._file["fields"])

    def unit(self, name):
        """The unit in which the workflow declares the field (values are SI)."""
        return _text(self._file["fields/" + name].attrs["unit"])

    def count(self, name):
        """For a field with a variable first axis: how many entries of it each window filled."""
        return self._rows("counts/" + name)

    @property
    def iterations(self):
        """Iterations of each window."""
        return self._rows("iterations")

    def timing(self, column):
        """A column of the measured times, s per window."""
        return self._rows("timings/" + column)

    def _rows(self, dataset):
        # A run that ended early may have allocated more rows than it completed.
        return self._file[dataset][: self.windows]


def open_record(path=None):
    """The record of this run (SANDGLASS_RECORD), or the one at `path`."""
    if path is None:
        path = os.environ.get("SANDGLASS_RECORD")
        if path is None:
            raise RuntimeError("SANDGLASS_RECORD is not set: an analysis is started by Sandglass, as a stage")
    return Record(path)


class Point:
    """One point of a study, from points.json of its summary: how its run ended and what it gave.

    name, set (of points), label ("window=1 ms, seed=2"), sample_of (the label without seeds and repetition),
    repetition, expect ("done" or "unstable"), good (it ended as expected), status and exit_code (None without a
    result), error, windows, parameters (SI), seconds (of the run, stages, participants), load (of the
    machine when it ended: processes waiting or running, on average over a minute), quantities, notes.
    """

    def __init__(self, row, folder):
        self.name, self.set, self.label = row["name"], row["set"], row["label"]
        self.sample_of, self.repetition = row["sample_of"], row["repetition"]
        self.expect, self.good = row["expect"], row["good"]
        self.status, self.exit_code = row.get("status"), row.get("exit_code")
        self.error, self.windows = row.get("error", ""), row.get("windows", 0)
        self.parameters, self.seconds = row.get("parameters", {}), row.get("seconds", {})
        self.quantities, self.notes = row.get("quantities", {}), row.get("notes", [])
        self.load = row.get("load")
        self.run = os.path.join(folder, row["run"])

    def record(self):
        """The record of its run, also of one that ended early."""
        return Record(os.path.join(self.run, "record.h5"))

    def counted(self, name):
        """(times, counts): what the field `name` [1] counted in every window to the planned end, and the borders of these
        windows, s. A run that came to rest before has nothing more to count. For workflows with `window` and `end_time`.
        """
        record, window = self.record(), self.parameters["window"]
        counts = numpy.zeros(max(record.windows, math.ceil(self.parameters["end_time"] / window * (1 - 1e-9))))
        counts[: record.windows] = record[name][:, 0]
        return window * numpy.arange(len(counts) + 1), counts


def open_study():
    """The points of the study that this stage looks at, in its order."""
    folder = os.path.abspath(os.path.join("..", ".."))  # a stage runs in stages/NAME of the run directory
    path = os.path.join(folder, "points.json")
    if not os.path.exists(path):
        raise RuntimeError("there are no points here: this stage belongs to a study, run it by 'sandglass study'")
    with open(path, encoding="utf-8") as file:
        return [Point(row, folder) for row in json.load(file)["points"]]


def quantity(name, value, unit, meaning=""):
    """A result: a number, a (nested) list of numbers, or None where it is not defined in this run.

    A number that is not finite is kept as "nan" or "inf": a comparison with it fails, where one with None is skipped.
    """
    _fresh_name(name, _quantities, "quantity")
    _quantities[name] = {"value": _plain(value), "unit": unit, "meaning": meaning}


def curve(name, x, y, x_unit, y_unit, label, kind, x_name="time", y_name=None, source="", points=False, x_error=None,
          y_error=None):
    """A curve, drawn where a figure names it. A y that is not finite is a gap; such an x has no place and is left out.

    `kind` is computed, analytic, published or measured; `source` says where a published curve was published. With
    `points` only its points are drawn, without a line; `x_error` and `y_error` are half the lengths of error bars.
    Returns the name, so that a figure can be put together from what was made.
    """
    _fresh_name(name, _curves, "curve")
    if kind not in KINDS:
        raise ValueError("curve '%s': kind '%s' is not one of %s" % (name, kind, ", ".join(KINDS)))
    x = numpy.atleast_1d(numpy.asarray(x, dtype=numpy.float64))
    y = numpy.atleast_1d(numpy.asarray(y, dtype=numpy.float64))
    if x.ndim != 1 or x.shape != y.shape:
        raise ValueError("curve '%s': x has shape %s, y %s; two equal lists are needed" % (name, x.shape, y.shape))
    there = numpy.isfinite(x)
    bars = {}
    for axis, error in (("x", x_error), ("y", y_error)):
        if error is not None:
            error = numpy.broadcast_to(numpy.asarray(error, dtype=numpy.float64), x.shape)[there]
            bars[axis] = {"error": [v if math.isfinite(v) else 0.0 for v in error.tolist()]}
    x, y = x[there], y[there]
    _curves[name] = {
        "kind": kind,
        "label": label,
        "source": source,
        "x": {"name": x_name, "unit": x_unit, "values": x.tolist(), **bars.get("x", {})},
        "y": {"name": y_name or name, "unit": y_unit, "values": [v if math.isfinite(v) else None for v in y.tolist()],
              **bars.get("y", {})},
        "file": name + ".csv",
    }
    if points:
        _curves[name]["points"] = True
    return name


def figure(name, title, panels, caption=""):
    """A figure of one or more panels, each a dict with `curves` and, as wanted, `title`, `x` and `y` (labels),
    `x_unit` and `y_unit` (to draw in; default: those of the first curve), `x_scale`, `y_scale` (linear or log), `marks`
    (dicts of axis, value in SI, label) and `y_names` ({ordinate: name}, for ordinates that stand for things).
    """
    if any(name == other["name"] for other in _figures):
        raise ValueError("figure '%s' is defined twice" % name)
    _check_name(name, "figure")
    _figures.append(
        {"name": name, "title": title, "caption": caption, "panels": [_panel(name, panel) for panel in panels]}
    )


def table(name, title, columns, rows, caption=""):
    """A table of the report: `rows` hold one text or number for each of the columns."""
    _check_name(name, "table")
    if any(name == other["name"] for other in _tables):
        raise ValueError("table '%s' is defined twice" % name)
    rows = [[cell if isinstance(cell, str) else "%.4g" % cell for cell in row] for row in rows]
    for row in rows:
        if len(row) != len(columns):
            raise ValueError("table '%s': a row of %d cells for %d columns" % (name, len(row), len(columns)))
    _tables.append({"name": name, "title": title, "caption": caption, "columns": list(columns), "rows": rows})


def finish():
    """Writes the curves' CSV files and, last, analysis.json."""
    # Everything is put into text first: a value that cannot be written must not leave half a result.
    files = {entry["file"]: _csv(entry) for entry in _curves.values()}
    files["analysis.json"] = json.dumps(
        {"format": FORMAT, "quantities": _quantities, "curves": _curves, "figures": _figures, "tables": _tables},
        indent=1,
        allow_nan=False,
        ensure_ascii=False,
    )
    for path, text in files.items():
        part = path + ".part"
        with open(part, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        os.replace(part, path)


def _panel(figure_name, panel):
    known = {"title", "x", "y", "x_unit", "y_unit", "x_scale", "y_scale", "curves", "marks", "y_names"}
    unknown = sorted(set(panel) - known)
    if unknown:
        raise ValueError("figure '%s': a panel has no '%s'; it has %s" % (figure_name, unknown[0], sorted(known)))
    if not panel.get("curves"):
        raise ValueError("figure '%s': a panel without curves" % figure_name)
    for name in panel["curves"]:
        if name not in _curves:
            raise ValueError("figure '%s': there is no curve '%s' (yet)" % (figure_name, name))
    for axis in ("x_scale", "y_scale"):
        if panel.get(axis, "linear") not in SCALES:
            raise ValueError("figure '%s': %s '%s' is not one of %s" % (figure_name, axis, panel[axis], SCALES))
    first = _curves[panel["curves"][0]]
    marks = [
        {"axis": mark["axis"], "value": float(mark["value"]), "label": mark["label"]} for mark in panel.get("marks", [])
    ]
    names = [{"value": float(value), "name": str(name)} for value, name in panel.get("y_names", {}).items()]
    return {
        "title": panel.get("title", ""),
        "x_label": panel.get("x", first["x"]["name"]),
        "x_unit": panel.get("x_unit", first["x"]["unit"]),
        "y_label": panel.get("y", first["y"]["name"]),
        "y_unit": panel.get("y_unit", first["y"]["unit"]),
        "x_scale": panel.get("x_scale", "linear"),
        "y_scale": panel.get("y_scale", "linear"),
        "curves": list(panel["curves"]),
        "marks": marks,
        "y_names": names,
    }


def _plain(value):
    if value is None:
        return None
    if isinstance(value, numpy.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    # A result that is not finite is said to be so: a comparison with it fails, where None is skipped.
    number = float(value)
    return number if math.isfinite(number) else str(number)


def _text(attribute):
    # HDF5 strings of fixed length arrive as bytes, those of variable length as text.
    return attribute.decode("utf-8", "replace") if isinstance(attribute, bytes) else str(attribute)


def _csv(entry):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow("%s [%s]" % (axis["name"], axis["unit"]) for axis in (entry["x"], entry["y"]))
    writer.writerows(zip(entry["x"]["values"], entry["y"]["values"]))
    return text.getvalue()


def _fresh_name(name, known, what):
    _check_name(name, what)
    if name in known:
        raise ValueError("%s '%s' is defined twice" % (what, name))


def _check_name(name, what):
    # Names become file names and keys.
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
        raise ValueError("%s '%s': a name is letters, digits and underscores" % (what, name))
