"""Makes the reference curves of the beam impacts anew, next to itself:  /usr/bin/python3 data/beam_impact/make.py [FOLDER]

Modal superposition by templates/analysis/modal_beam.py, which is independent of YADE and FreeFEM; parameters as in
workflows/beam_single_impact.yaml and beam_multiple_impacts.yaml. Prints contacts, peak forces and rebounds.
"""

import csv
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "templates", "analysis"))

import modal_beam  # noqa: E402

YOUNG, POISSON, DENSITY = 2.157463e11, 0.289, 7960.0  # Pa, 1, kg/m3: steel of Timoshenko's example
SECTION = 0.01  # m, width and height
VELOCITY = 0.01  # m/s
# name: length m, radius m, end s, step s
SCENES = {"single": (0.1535, 0.01, 1e-3, 2e-8), "multiple": (0.3070, 0.02, 4e-3, 4e-8)}
COLUMNS = {"force": ("force", "contact_force [N]"), "sphere": ("sphere", "sphere_displacement [m]"),
           "beam": ("deflection", "beam_displacement [m]")}
POINTS = 400  # intervals in a stored curve


def solve(scene, theory, modes=200):
    """The impact of a scene: what modal_beam.impact returns."""
    length, radius, end, step = SCENES[scene]
    beam = modal_beam.Beam(length, SECTION, SECTION, YOUNG, POISSON, DENSITY, length / 2, theory, modes)
    stiffness = modal_beam.hertz_stiffness(radius, YOUNG, POISSON, YOUNG, POISSON)
    return modal_beam.impact(beam, stiffness, 4 / 3 * math.pi * radius**3 * DENSITY, VELOCITY, end, step)


def main(folder):
    for scene in SCENES:
        for theory in ("timoshenko", "euler_bernoulli"):
            result = solve(scene, theory)
            periods, peaks = modal_beam.contacts(result["time"], result["force"])
            print(scene, theory)
            print("  contacts [ms]", ["%.6g to %.6g" % (1e3 * begin, 1e3 * end) for begin, end in periods])
            print("  peak forces [N]", ["%.6g" % peak for peak in peaks])
            print("  rebound [mm/s] %.6g" % (1e3 * result["sphere_velocity"][-1]))
            every = (len(result["time"]) - 1) // POINTS
            for name, (key, heading) in COLUMNS.items():
                path = os.path.join(folder, "%s_%s_%s.csv" % (scene, theory, name))
                with open(path, "w", encoding="utf-8", newline="") as file:
                    file.write("# Sphere on a simply supported beam, %s theory, by data/beam_impact/make.py; converged to 1e-5.\n"
                               % theory.replace("_", "-"))
                    rows = csv.writer(file, lineterminator="\n")
                    rows.writerow(["time [s]", heading])
                    for time, value in zip(result["time"][::every], result[key][::every]):
                        rows.writerow(["%.8g" % time, "%.7g" % value])


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else HERE)
