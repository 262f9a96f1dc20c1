#!/usr/bin/env python3
"""What a scene does not need is not computed: the time of one value and gradient of each scene, all
with the same network (hidden layers of tanh) and the same number of points, and what was left out of
each. Without scenes: every model, at rest and in motion, in mixed and in strong form, under a load
along the rod. Medians of the steps of one training each; ratios are to the last scene."""
import argparse
import csv
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile

os.environ["PATH"] += os.pathsep + os.path.join(os.path.dirname(os.path.realpath(__file__)),
                                                  "../../build/tools")
STEPS = 15
INERTIA = "inertia: {mass_per_length: 1, rotary: [6.25e-4, 6.25e-4, 1.25e-3]}"
KIRCHHOFF = "stiffness: {bending: [1, 1], torsion: 0.77}, " + INERTIA
COSSERAT = ("stiffness: {shear: [545, 545], axial: 1600, bending: [1, 1], torsion: 0.77}, " + INERTIA)
# One rod for all of them; a model locks what it lacks. Strong form: second order in s, of
# euler_bernoulli fourth; a locked strain has no constitutive law, and so kirchhoff no strong form.
MODELS = [("euler_bernoulli", "stiffness: {bending: [1, 1]}, inertia: {mass_per_length: 1}",
           "beam: {force: 1}", True),
          ("timoshenko", "stiffness: {bending: [1, 1], shear: [545, 545]}, " + INERTIA,
           "beam: {force: 1}", True),
          ("kirchhoff_planar", KIRCHHOFF, "loads: {force: [1, 0, 0]}\nmotion: planar", False),
          ("kirchhoff_spatial", KIRCHHOFF, "loads: {force: [1, 1, 0]}", False),
          ("cosserat_planar", COSSERAT, "loads: {force: [1, 0, 0]}\nmotion: planar", True),
          ("cosserat_spatial", COSSERAT, "loads: {force: [1, 1, 0]}", True)]


def write_models(folder):
    for moving, prefix in enumerate(("static", "dynamic")):
        for name, rod, rest, has_strong_form in MODELS:
            for form in ["displacement"] * has_strong_form + ["mixed"]:
                strong = "strong" if form == "displacement" else form
                path = os.path.join(folder, f"{prefix}_{name}_{strong}.yaml")
                model = name.removesuffix("_planar").removesuffix("_spatial")
                with open(path, "w") as file:
                    file.write(f"rod: {{model: {model}, length: 1, {rod}}}\n{rest}\n"
                               f"time: {{duration: {moving}}}\nformulation: {form}\n")
                yield path


def run(*arguments):
    done = subprocess.run(["cpinn-train", *arguments], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 3):
        sys.exit(f"scenes: {done.stderr.strip()}")
    return done.stdout


def measure(path, asked, folder):
    sets = ["--set", f"network={{hidden: [{', '.join([str(asked.width)] * 3)}], activation: tanh}}",
            "--set", f"losses={{interior: {{points: {asked.points}, sampler: sobol}}, "
            "held_out_points: 1}", "--set", "output.every=1", "--set",
            f"training.stages=[{{optimizer: adam, steps: {STEPS + 1}, learning_rate: 1e-6}}]"]
    about = run(path, *sets, "--explain")
    out = os.path.join(folder, os.path.basename(path) + ".run")
    said = json.loads(run(path, *sets, "--threads", str(asked.threads), "--out", out, "--json", "-"))
    with open(os.path.join(out, "history.csv"), newline="") as file:
        seconds = [float(row["seconds"]) for row in csv.DictReader(file)]
    interior = re.findall(r"^  interior .*$", about, re.M)  # operations; products and their flops
    left_out = re.findall(r"^  left out +(.*(?:\n {18}.*)*)", about, re.M)
    return {"name": said["name"], "us": 1e6 / asked.points * statistics.median(
                b - a for a, b in zip(seconds, seconds[1:])),
            "instructions": int(interior[0].split()[-1]), "flops": int(interior[1].split()[4]),
            "unknowns": said["unknowns"], "equations": said["equations"],
            "left_out": [" ".join(text.split()) for text in left_out
                         if not text.endswith(("not given", "not loaded"))]}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", action="append", metavar="CONFIG.yaml")
    parser.add_argument("--points", type=int, default=4096)
    parser.add_argument("--width", type=int, default=64, help="of the 3 hidden layers")
    parser.add_argument("--threads", type=int, default=1)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = [measure(path, asked, folder) for path in asked.scene or write_models(folder)]
    print(f"{'scene':32} {'us/point':>9} {'ratio':>7} {'instructions':>13} {'flops/point':>12} "
          f"{'unknowns':>9} {'equations':>10}")
    for row in rows:
        print(f"{row['name']:32} {row['us']:9.3f} {row['us'] / rows[-1]['us']:7.3f} "
              f"{row['instructions']:13} {row['flops']:12} {row['unknowns']:9} {row['equations']:10}")
        if row["left_out"]:
            print("    without " + "; ".join(row["left_out"]))


main()
