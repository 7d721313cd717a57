"""Draws the figures of a report: draw.py FIGURES.json FOLDER writes FOLDER/NAME.svg and FOLDER/NAME.png.

FIGURES.json is written by the report room, checked and in the units to be drawn:

    {"figures": [{"name", "title", "columns",
                  "panels": [{"title", "x_label", "y_label", "x_scale", "y_scale",
                              "curves": [{"kind", "label", "x": [..], "y": [..], "x_error": [..],
                                          "error": [..], "points": true or false}],
                              "marks": [{"axis": "x" or "y", "value", "label"}],
                              "y_names": [{"value", "name"}]}]}]}

Labels are complete ("velocity (mm/s)") and plain text, never markup. null is a gap. The kind of a curve decides its
style: computed, analytic, published, measured. The SVG takes its colours from CSS variables that it defines itself for
light and dark, so that it reads well alone and inside the report; the PNG is light.
"""

import json
import math
import re
import sys
from html import escape

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, ScalarFormatter

# name: (light, dark). The series are Okabe and Ito's colours, which stay apart for colour-blind readers, lightened
# for dark paper. Drawing is done in the light ones; each is unique, so it can be replaced by its variable afterwards.
COLOURS = {
    "ink": ("#1b1f24", "#e8eaed"),
    "muted": ("#5b6571", "#a3adb8"),
    "grid": ("#e6e8eb", "#30363d"),
    "paper": ("#fefefe", "#15181c"),
    "series-1": ("#0072b2", "#56b4e9"),
    "series-2": ("#d55e00", "#f4935a"),
    "series-3": ("#009e73", "#45cfa6"),
    "series-4": ("#cc79a7", "#e6a3c7"),
    "series-5": ("#e69f00", "#f3c252"),
    "series-6": ("#5a5ab0", "#a9a9f5"),
    "series-7": ("#8c6d31", "#c9ac74"),
}
INK, MUTED, GRID, PAPER = (COLOURS[name][0] for name in ("ink", "muted", "grid", "paper"))
SERIES = [light for name, (light, _) in COLOURS.items() if name.startswith("series")]
DASHES = [(5, 2.2), (1.6, 1.8), (7, 2, 1.5, 2), (3, 1.5, 1, 1.5)]
MARKERS = ["o", "s", "D", "^", "v", "P"]
KINDS = ["computed", "analytic", "published", "measured"]
FEW = 60  # up to so many points each one is shown by a marker
FONTS = ["DejaVu Sans", "Verdana", "sans-serif"]

# The user's own settings change nothing here.
dict.update(matplotlib.rcParams, matplotlib.rcParamsDefault)
matplotlib.rcParams.update({
    "font.family": "sans-serif", "font.sans-serif": FONTS, "font.size": 9,
    "text.color": INK, "text.parse_math": False, "axes.unicode_minus": True,
    "axes.facecolor": "none", "axes.edgecolor": MUTED, "axes.linewidth": 0.7,
    "axes.labelcolor": INK, "axes.labelsize": 9, "axes.titlesize": 9.5, "axes.titlelocation": "left",
    "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True,
    "xtick.color": MUTED, "ytick.color": MUTED, "xtick.labelsize": 8.5, "ytick.labelsize": 8.5,
    "xtick.major.width": 0.7, "ytick.major.width": 0.7, "xtick.major.size": 3, "ytick.major.size": 3,
    "grid.color": GRID, "grid.linewidth": 0.7,
    "legend.frameon": False, "legend.fontsize": 8.5, "legend.handlelength": 2.6, "legend.columnspacing": 2.0,
    "svg.fonttype": "none",
})

SUPERSCRIPT = str.maketrans("0123456789-\u2212", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁻")


class Numbers(ScalarFormatter):
    """Plain tick numbers; a common power of ten stands at the axis as ×10⁻⁵."""

    def __init__(self):
        super().__init__(useOffset=False, useMathText=False)
        self.set_powerlimits((-3, 4))

    def get_offset(self):
        power = re.fullmatch(r"1e([-\u2212]?)\+?(\d+)", super().get_offset())
        return "×10" + (power[1] + power[2]).translate(SUPERSCRIPT) if power else super().get_offset()


def power_of_ten(value, _position):
    return "10" + str(round(math.log10(value))).translate(SUPERSCRIPT) if value > 0 else ""


def short_number(value, _position):
    return f"{value:.3g}"


def numbers(values):
    return [math.nan if value is None else value for value in values]


def styles_of(figure):
    """One style per (kind, label) in the whole figure, so that a curve looks alike in every panel."""
    seen = []
    for panel in figure["panels"]:
        for curve in panel["curves"]:
            key = (curve["kind"], curve["label"])
            if key not in seen:
                seen.append(key)
    seen.sort(key=lambda key: KINDS.index(key[0]))  # stable: the computed ones get the strongest colours
    count = dict.fromkeys(KINDS, 0)
    styles = {}
    for index, (kind, label) in enumerate(seen):
        turn = count[kind]
        count[kind] += 1
        colour = SERIES[index % len(SERIES)]
        marker = MARKERS[turn % len(MARKERS)]
        if kind == "computed":
            style = dict(color=colour, linewidth=2.0, solid_capstyle="round", marker=marker, markersize=4.2,
                         markeredgewidth=0, zorder=3)
            if turn >= len(SERIES):  # the colours begin anew
                style.update(linewidth=1.2, dashes=(5, 2), markerfacecolor=PAPER, markeredgewidth=1.2)
        elif kind == "analytic":
            style = dict(color=colour, linewidth=1.3, dashes=DASHES[turn % len(DASHES)], zorder=4)
        elif kind == "published":
            style = dict(color=colour, linewidth=0, marker=marker, markersize=5.6, markerfacecolor=PAPER,
                         markeredgewidth=1.3, zorder=5)
        else:
            style = dict(color=colour, linewidth=0, marker=marker, markersize=4.8, markeredgewidth=0, zorder=5)
        styles[kind, label] = style
    return styles


def draw_curve(axes, curve, style):
    x, y = numbers(curve["x"]), numbers(curve["y"])
    style = dict(style)
    if curve.get("points"):
        style.update(linewidth=0, marker=style.get("marker") or "o")
        style.pop("dashes", None)
    elif len(x) > FEW and style["linewidth"] > 0:
        style.pop("marker", None)  # a long line needs no markers
    elif len(x) > FEW and style["linewidth"] == 0:
        style.update(marker=None, linewidth=1.2)  # many points, as digitised from a plot, are a line
    if curve.get("error") or curve.get("x_error"):
        axes.errorbar(x, y, yerr=numbers(curve.get("error") or []) or None,
                      xerr=numbers(curve.get("x_error") or []) or None, fmt="none", ecolor=style["color"],
                      elinewidth=0.9, capsize=2, zorder=style["zorder"] - 0.5)
    line, = axes.plot(x, y, **style)
    return line


def set_ticks(side, scale, most):
    """`most` is the largest number of intervals between ticks."""
    if scale == "log":
        low, high = side.get_view_interval()
        short = low > 0 and high / low < 50  # too few powers of ten to read the axis by
        side.set_major_locator(LogLocator(subs=(1, 2, 5) if short else (1,), numticks=8))
        side.set_major_formatter(FuncFormatter(short_number if short else power_of_ten))
        side.set_minor_formatter(NullFormatter())
    else:
        side.set_major_locator(MaxNLocator(nbins=most, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3))
        side.set_major_formatter(Numbers())


def draw_mark(axes, mark):
    across = mark["axis"] == "x"
    (axes.axvline if across else axes.axhline)(mark["value"], color=MUTED, linewidth=0.8, dashes=(1, 2), zorder=2)
    place = (mark["value"], 0.45) if across else (0.99, mark["value"])  # beside the line, away from the axes' corners
    axes.annotate(mark["label"], place, xycoords=("data", "axes fraction") if across else ("axes fraction", "data"),
                  xytext=(3, 0) if across else (0, 3), textcoords="offset points", rotation=90 if across else 0,
                  ha="left" if across else "right", va="center" if across else "bottom", color=MUTED, fontsize=8)


def draw_panel(axes, panel, styles, legend):
    for axis in "xy":
        if panel[axis + "_scale"] == "log":
            getattr(axes, f"set_{axis}scale")("log", nonpositive="mask")
    for curve in panel["curves"]:
        key = curve["kind"], curve["label"]
        line = draw_curve(axes, curve, styles[key])
        if curve["label"]:
            legend.setdefault(key, line)
    for mark in panel["marks"]:
        draw_mark(axes, mark)
    axes.grid(True)
    axes.margins(x=0.02, y=0.06)
    set_ticks(axes.xaxis, panel["x_scale"], 8)
    if panel.get("y_names"):
        axes.set_yticks([item["value"] for item in panel["y_names"]], [item["name"] for item in panel["y_names"]])
    else:
        set_ticks(axes.yaxis, panel["y_scale"], 6)
    axes.set_xlabel(panel["x_label"])
    axes.set_ylabel(panel["y_label"], rotation_mode="anchor")
    axes.set_title(panel["title"], fontweight="bold", pad=8)
    axes.yaxis.get_offset_text().set_color(MUTED)
    axes.xaxis.get_offset_text().set_color(MUTED)


def legend_shape(labels, width):
    """Columns and rows of a legend that is `width` inches wide, estimated from the lengths of the labels."""
    if not labels:
        return 1, 0
    widths = [0.067 * len(label) + 0.75 for label in labels]  # the line sample and the gaps included
    for columns in range(len(labels), 1, -1):
        rows, longer = divmod(len(labels), columns)  # matplotlib's first columns are the longer ones
        begins = [number * rows + min(number, longer) for number in range(columns + 1)]
        if sum(max(widths[begin:end]) for begin, end in zip(begins, begins[1:])) <= width:
            return columns, rows + (longer > 0)
    return 1, len(labels)


def draw(description):
    """The whole figure: one legend on top, the panels below it in rows. Lengths are in inches."""
    panels = description["panels"]
    columns = min(len(panels), description["columns"] or 2)
    rows = math.ceil(len(panels) / columns)
    column_width = 7.2 if columns == 1 else 4.8
    left, right, below = 0.72, 0.14, 0.5 if rows == 1 else 0.62  # around a panel's axes, for numbers and labels
    names = [item["name"] for panel in panels for item in panel.get("y_names", [])]
    column_width -= left
    left = max([left] + [0.5 + 0.067 * len(name) for name in names])
    column_width += left
    width = columns * column_width
    above = 0.3 if any(panel["title"] for panel in panels) else 0.2
    axes_height = 3.6 if columns == 1 else 3.0

    styles = styles_of(description)
    legend_columns, legend_rows = legend_shape([label for _, label in styles if label], width - left)
    legend_height = 0.166 * legend_rows + 0.11
    height = legend_height + rows * (above + axes_height + below)
    figure = Figure(figsize=(width, height), facecolor="none")
    legend = {}
    for number, panel in enumerate(panels):
        row, column = divmod(number, columns)
        bottom = height - legend_height - row * (above + axes_height + below) - above - axes_height
        axes = figure.add_axes(((column * column_width + left) / width, bottom / height,
                                (column_width - left - right) / width, axes_height / height))
        draw_panel(axes, panel, styles, legend)
    if legend:
        keys = [key for key in styles if key in legend]
        figure.legend([legend[key] for key in keys], [key[1] for key in keys], ncol=legend_columns, loc="upper left",
                      bbox_to_anchor=((left - 0.05) / width, 1.0), borderaxespad=0.5, borderpad=0.1, labelspacing=0.35)
    return figure


def write_png(figure, path):
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=144, facecolor=PAPER, metadata={"Software": None})


def write_svg(figure, name, title, path):
    # A salt of its own keeps the names of markers and clips apart when several figures stand in one page.
    matplotlib.rcParams["svg.hashsalt"] = name
    FigureCanvasSVG(figure)
    figure.savefig(path, facecolor="none", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    with open(path, encoding="utf-8") as file:
        text = file.read()
    text = text[text.index("<svg"):]
    text = re.sub(r'<g id="[^"]*">', "<g>", text)
    text = re.sub(r"<defs>\s*<style type=\"text/css\">.*?</style>\s*</defs>", "", text, count=1, flags=re.S)
    for variable, (light, _) in COLOURS.items():
        text = text.replace(light, f"var(--{variable})")
    text = re.sub(r'(font: (?:\w+ )*[\d.]+px )[^;"]+', r"\1var(--figure-font)", text)
    # Its own class, not :root, so that the same text works alone and inside a page.
    light = "".join(f"--{variable}:{pair[0]};" for variable, pair in COLOURS.items())
    dark = "".join(f"--{variable}:{pair[1]};" for variable, pair in COLOURS.items())
    style = (f"<title>{escape(title)}</title>\n<style>.sandglass-figure{{{light}--figure-font:{','.join(FONTS)};"
             "stroke-linejoin:round;stroke-linecap:butt}"
             f"@media screen and (prefers-color-scheme:dark){{.sandglass-figure{{{dark}}}}}</style>\n")
    end = text.index(">") + 1
    opening = re.sub(r' (width|height)="([\d.]+)pt"', lambda m: f' {m[1]}="{float(m[2]) * 100 / 72:g}"', text[:end - 1])
    text = f'{opening} class="sandglass-figure" role="img">\n{style}{text[end:]}'
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def printable(value):
    """The description without control characters, which no SVG may hold."""
    if isinstance(value, str):
        return re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]", "\ufffd", value)
    if isinstance(value, dict):
        return {key: printable(item) for key, item in value.items()}
    if isinstance(value, list) and not (value and isinstance(value[0], float)):
        return [printable(item) for item in value]
    return value


def main(source, folder):
    with open(source, encoding="utf-8") as file:
        figures = printable(json.load(file)["figures"])
    for description in figures:
        figure = draw(description)
        base = f"{folder}/{description['name']}"
        write_svg(figure, description["name"], description["title"], base + ".svg")
        write_png(figure, base + ".png")


if __name__ == "__main__":
    main(*sys.argv[1:])
