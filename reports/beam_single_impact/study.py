"""Energy made by the coupling, error against processor time, and extreme cases of the single impact: many short runs.

    /usr/bin/python3 reports/beam_single_impact/study.py [energy] [error] [extreme]

Writes energy.csv, error.csv, extreme.csv beside itself and draws energy.png and error.png from them. Runs go below runs/.
Times are processor seconds of all processes of a run, start and analysis included: they repeat on a busy machine.
"""

import csv
import json
import os
import resource
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
HOME = os.path.dirname(os.path.dirname(HERE))
SANDGLASS = os.environ.get("SANDGLASS_BINARY", os.path.join(HOME, "sandglass"))
FORCE, REBOUND, SPEED = 4.92213, -2.98979e-3, 0.01  # Timoshenko's beam: N, m/s; velocity of the impact

LAGS = {"predicted": (0, dict(wall_prediction="true")), "last force": (0.5, dict(force_in_window="last")),
        "as published": (1, {}), "parallel": (2, dict(scheme="parallel-explicit"))}


def run(**parameters):
    """result.json of a run, its exit status, and the processor seconds it took."""
    out = os.path.join(os.environ.get("SANDGLASS_RUNS", os.path.join(HOME, "runs")), "study")
    shutil.rmtree(out, ignore_errors=True)
    arguments = [SANDGLASS, "run", os.path.join(HOME, "workflows", "beam_single_impact.yaml"), "--out", out]
    for name, value in parameters.items():
        arguments += ["--set", "%s=%s" % (name, value)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    status = subprocess.run(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                            env=dict(os.environ, SANDGLASS_HOME=HOME)).returncode
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(os.path.join(out, "result.json"), encoding="utf-8") as file:
        result = json.load(file)
    return result, status, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def write(name, rows):
    with open(os.path.join(HERE, name), "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def read(name):
    path = os.path.join(HERE, name)
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


def energy():
    rows = []
    for window in (5e-8, 1e-7, 2e-7, 4e-7, 8e-7):
        for name, (lag, parameters) in LAGS.items():
            quantities = run(time_step=window, end_time=2e-4, **parameters)[0]["quantities"]
            value = {key: quantities[key]["value"] for key in
                     ("coupling_energy_gain", "energy_gain_theory", "exchange_lag", "energy_gain_rate_theory")}
            rows.append(dict(scheme=name, window_s=window, lag_theory=lag, gain=value["coupling_energy_gain"],
                             gain_theory=value["energy_gain_theory"], lag=value["exchange_lag"]))
            print(rows[-1], flush=True)
            write("energy.csv", rows)


METHODS = {
    "FEM P1 60x4": dict(element="linear", elements_along=60, elements_through=4),
    "FEM P2 30x2": {},
    "FEM P2 60x4": dict(elements_along=60, elements_through=4),
    "FEM P2 solid": dict(dimension=3),
    "MPM 32x7": dict(continuum="mpm", grid_along=30, grid_through=7, points_along=240, points_through=16),
    "MPM 62x13": dict(continuum="mpm"),
    "MPM 122x26": dict(continuum="mpm", grid_along=120, grid_through=26),
}


def error():
    rows = []

    def point(method, label, **parameters):
        result, status, seconds = run(end_time=2e-4, **METHODS[method], **parameters)
        quantities = result["quantities"]
        row = dict(method=method, coupling=label, window_s=parameters["time_step"], exit=status,
                   processor_s=round(seconds, 2))
        force = quantities.get("first_peak_force", {}).get("value")
        rebound = quantities.get("rebound_velocity", {}).get("value")
        row["force_error"] = "" if force is None else force / FORCE - 1
        row["rebound_error"] = "" if rebound is None else (rebound - REBOUND) / SPEED
        rows.append(row)
        print(row, flush=True)
        write("error.csv", rows)

    for window in (1e-7, 4e-7, 1.6e-6):
        for method in METHODS:
            if method.startswith("MPM") and window > 1e-6:
                continue  # explicit: not stable
            point(method, "as published", time_step=window)
            point(method, "predicted", time_step=window, wall_prediction="true")
    for window in (4e-7, 1.6e-6, 6.4e-6):
        point("FEM P2 30x2", "iterated, IQN-ILS", time_step=window, scheme="serial-implicit", acceleration="iqn-ils")
        point("FEM P2 30x2", "predicted, 8 steps", time_step=window, wall_prediction="true", grain_steps=8, beam_steps=2)
    point("MPM 62x13", "predicted, 4 steps", time_step=1.6e-6, wall_prediction="true", grain_steps=4, beam_steps=4)


EXTREME = {
    "as published": {},
    "sphere 1000 times stiffer": dict(sphere_young="2.157463e14"),
    "beam of rubber (5 MPa, 1100 kg/m3)": dict(beam_young="5e6", beam_density=1100, beam_poisson=0.45, end_time="60e-3",
                                               time_step="2e-5"),
    "sphere 1000 times denser": dict(sphere_density=7.96e6, end_time="20e-3", time_step="4e-6"),
    "impact at 100 m/s": dict(impact_velocity=100, time_step="1e-8", end_time="40e-6"),
    "window of 4 us": dict(time_step="4e-6"),
    "window of 4 us, predicted": dict(time_step="4e-6", wall_prediction="true"),
    "window of 40 us": dict(time_step="40e-6"),
    "window of 40 us, iterated": dict(time_step="40e-6", scheme="serial-implicit", acceleration="iqn-ils"),
    "material points, step beyond the limit": dict(continuum="mpm", time_step="1e-6"),
}


def extreme():
    rows = []
    for name, parameters in EXTREME.items():
        result, status, _ = run(**{**dict(end_time=4e-4, time_step=4e-7), **parameters})
        value = {key: one["value"] for key, one in result["quantities"].items()}
        rows.append(dict(case=name, exit=status, windows=result["windows"],
                         contacts=value.get("contacts", ""), contacts_theory=value.get("timoshenko_contacts", ""),
                         peak_force_N=value.get("first_peak_force", ""),
                         peak_force_theory_N=value.get("timoshenko_peak_force", ""),
                         energy_gain=value.get("coupling_energy_gain", ""),
                         said=result.get("error", "").split("; ")[0].splitlines()[0] if result.get("error") else ""))
        print(rows[-1], flush=True)
        write("extreme.csv", rows)


def draw():
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plot

    rows = read("energy.csv")
    if rows:
        figure, axes = plot.subplots(figsize=(7, 4.5), constrained_layout=True)
        for index, name in enumerate(LAGS):
            mine = [row for row in rows if row["scheme"] == name]
            windows = [float(row["window_s"]) for row in mine]
            axes.loglog([w * 1e9 for w in windows], [abs(float(row["gain"])) for row in mine], "o", color="C%d" % index,
                        label="%s (lag %g)" % (name, LAGS[name][0]))
            if LAGS[name][0]:
                axes.loglog([w * 1e9 for w in windows], [float(row["gain_theory"]) for row in mine], "-", color="C%d" % index, lw=1)
        axes.set(xlabel="window [ns]", ylabel="energy made by the coupling, over that of the impact",
                 title="Energy that the exchange makes (points) and theory (lines)")
        axes.grid(True, which="both", alpha=0.2)
        axes.legend(frameon=False)
        figure.savefig(os.path.join(HERE, "energy.png"), dpi=130)
    rows = [row for row in read("error.csv") if row["force_error"] not in ("", None) and row["exit"] in ("0", "6")]
    if rows:
        figure, both = plot.subplots(1, 2, figsize=(11, 4.8), constrained_layout=True, sharex=True)
        marks = {"as published": "o", "predicted": "^", "iterated, IQN-ILS": "s", "predicted, 8 steps": "D", "predicted, 4 steps": "v"}
        for axes, key, title in zip(both, ("force_error", "rebound_error"), ("peak force", "rebound velocity, over the impact's")):
            for index, method in enumerate(METHODS):
                for coupling, mark in marks.items():
                    mine = [row for row in rows if row["method"] == method and row["coupling"] == coupling]
                    axes.loglog([float(row["processor_s"]) for row in mine], [abs(float(row[key])) for row in mine], mark,
                                color="C%d" % index, ms=6, mfc="none" if coupling == "as published" else None)
            axes.set(xlabel="processor time of the run [s]", ylabel="error", title=title)
            axes.grid(True, which="both", alpha=0.2)
        for index, method in enumerate(METHODS):
            both[0].plot([], [], "s", color="C%d" % index, label=method)
        for coupling, mark in marks.items():
            both[1].plot([], [], mark, color="0.3", mfc="none" if coupling == "as published" else None, label=coupling)
        for axes in both:
            axes.legend(frameon=False, fontsize=8)
        figure.suptitle("Error against processor time, to 0.2 ms: beside Timoshenko's beam")
        figure.savefig(os.path.join(HERE, "error.png"), dpi=130)


if __name__ == "__main__":
    for part in sys.argv[1:] or ["energy", "error", "extreme"]:
        {"energy": energy, "error": error, "extreme": extreme}[part]()
    draw()
