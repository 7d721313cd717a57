"""Energy made by the coupling, grids of material points, and extreme cases of the single impact: many short runs.

    /usr/bin/python3 reports/beam_single_impact/study.py [energy] [grids] [extreme]

Writes energy.csv, grids.csv, extreme.csv beside itself and draws energy.png. Runs go below runs/.
"""

import csv
import json
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
HOME = os.path.dirname(os.path.dirname(HERE))
SANDGLASS = os.environ.get("SANDGLASS_BINARY", os.path.join(HOME, "sandglass"))

LAGS = {"predicted": (0, dict(wall_prediction="true")), "last force": (0.5, dict(force_in_window="last")),
        "as published": (1, {}), "parallel": (2, dict(scheme="parallel-explicit"))}


def run(**parameters):
    """result.json of a run, its exit status, and its folder."""
    out = os.path.join(os.environ.get("SANDGLASS_RUNS", os.path.join(HOME, "runs")), "study")
    shutil.rmtree(out, ignore_errors=True)
    arguments = [SANDGLASS, "run", os.path.join(HOME, "workflows", "beam_single_impact.yaml"), "--out", out]
    for name, value in parameters.items():
        arguments += ["--set", "%s=%s" % (name, value)]
    status = subprocess.run(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                            env=dict(os.environ, SANDGLASS_HOME=HOME)).returncode
    with open(os.path.join(out, "result.json"), encoding="utf-8") as file:
        result = json.load(file)
    return result, status, out


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


GRIDS = {
    "32 x 7": dict(grid_along=30, grid_through=7),
    "62 x 13": {},
    "122 x 26": dict(grid_along=120, grid_through=26),
}


def grids():
    """Material points in three grids: the impact, and the beam's first two frequencies in the 2.8 ms behind it."""
    import h5py
    import numpy
    from scipy.optimize import least_squares

    rows = []
    for name, parameters in GRIDS.items():
        window = 2e-7
        result, _, out = run(continuum="mpm", time_step=window, end_time=3e-3, wall_prediction="true", **parameters)
        with h5py.File(os.path.join(out, "record.h5"), "r") as file:
            force, deflection = (file["fields"][field][:, 0] for field in ("contact_force", "beam_deflection"))
        free = slice(numpy.flatnonzero(force)[-1] + 5, None, 3)
        time, deflection = window * numpy.arange(len(force))[free], deflection[free]

        def difference(frequencies):
            waves = numpy.array([wave(2 * numpy.pi * f * time) for f in frequencies for wave in (numpy.cos, numpy.sin)]).T
            return waves @ numpy.linalg.lstsq(waves, deflection, rcond=None)[0] - deflection

        starts = [(first, second) for first in range(960, 1080, 20) for second in range(8300, 9100, 100)]
        start = min(starts, key=lambda pair: numpy.linalg.norm(difference(pair)))
        fitted = least_squares(difference, start, x_scale=100.0, ftol=1e-14, xtol=1e-12, gtol=1e-14).x
        value = {key: one["value"] for key, one in result["quantities"].items()}
        theory = (994.942, 8504.79)  # Hz, Timoshenko's beam (templates/analysis/modal_beam.py)
        rows.append(dict(grid=name, frequency_1_error=fitted[0] / theory[0] - 1, frequency_2_error=fitted[1] / theory[1] - 1,
                         peak_force_error=value["first_peak_force"] / value["timoshenko_peak_force"] - 1,
                         contact_length_error=value["first_contact_length"] / value["timoshenko_contact_length"] - 1,
                         rebound_error=(value["rebound_velocity"] - value["timoshenko_rebound_velocity"]) / 0.01))
        print(rows[-1], flush=True)
        write("grids.csv", rows)


EXTREME = {
    "as published": {},
    "sphere 1000 times stiffer": dict(sphere_young="2.157463e14"),
    "beam of rubber (5 MPa, 1100 kg/m3)": dict(beam_young="5e6", beam_density=1100, beam_poisson=0.45, end_time="60e-3",
                                               time_step="2e-5"),
    "the same, predicted, 40 us": dict(beam_young="5e6", beam_density=1100, beam_poisson=0.45, end_time="60e-3",
                                       time_step="4e-5", wall_prediction="true"),
    "sphere 1000 times denser": dict(sphere_density=7.96e6, end_time="20e-3", time_step="4e-6"),
    "the same, predicted": dict(sphere_density=7.96e6, end_time="20e-3", time_step="4e-6", wall_prediction="true"),
    "impact at 100 m/s": dict(impact_velocity=100, time_step="1e-8", end_time="40e-6"),
    "window of 4 us": dict(time_step="4e-6"),
    "window of 4 us, predicted": dict(time_step="4e-6", wall_prediction="true"),
    "window of 40 us": dict(time_step="40e-6"),
    "window of 40 us, iterated": dict(time_step="40e-6", scheme="serial-implicit", acceleration="iqn-ils"),
    "material points, window beyond the limit of a step": dict(continuum="mpm", time_step="1e-6"),
    "material points, the surface in an all but empty cell": dict(continuum="mpm", spread_load="false", time_step="2e-7",
                                                                  grid_height="25.48e-3", wall_prediction="true"),
    "material points, the surface in an empty cell": dict(continuum="mpm", spread_load="false", time_step="2e-7",
                                                          grid_height="25.948e-3", wall_prediction="true"),
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


if __name__ == "__main__":
    for part in sys.argv[1:] or ["energy", "grids", "extreme"]:
        {"energy": energy, "grids": grids, "extreme": extreme}[part]()
    draw()
