"""Makes the measurements of this folder: solutions at known values with noise.

    PATH=build/tools:$PATH python3 configs/identify/measure.py
"""

import csv
import math
import os
import random
import subprocess
import tempfile

folder = os.path.dirname(os.path.abspath(__file__))


def solve(scene, at, grid, given=()):
    with tempfile.TemporaryDirectory() as place:
        out = os.path.join(place, "solved.csv")
        subprocess.run(["cpinn-solve", os.path.join(folder, scene), "--at", at, "--quiet", "--grid",
                        grid, "--out", out, *(part for text in given for part in ("--set", text))],
                       check=True)
        with open(out, newline="") as file:
            return [{name: float(value) for name, value in row.items()}
                    for row in csv.DictReader(file)]


def write(name, columns, rows):
    with open(os.path.join(folder, name), "w", newline="") as file:
        file.write(",".join(columns) + "\n")
        for row in rows:
            file.write(",".join(f"{row[column]:.9g}" for column in columns) + "\n")


def noisy(row, deviation, draw):
    return {**row, **{name: row[name] + draw.gauss(0, deviation) for name in "xyz"}}


draw = random.Random(1)
tips = []
for i in range(20):
    known = {"turned": round(2 * math.pi * i / 20, 3), "pull": 0.05 + 0.05 * (i % 3)}
    at = f"turned={known['turned']},pull={known['pull']},bending=3.1e-3,torsion=1.9e-3,weight=0.03"
    tips.append({**noisy(solve("stiffness.yaml", at, "2")[-1], 5e-4, draw), **known})
write("stiffness_tips.csv", ["turned", "pull", "s", "x", "y", "z"], tips)

at = "material_youngs_modulus=1.2e7,material_relaxation_time=0.02,bodies_0_mass=0.004"
tips = [noisy(row, 1e-3, draw) for row in solve("swinging.yaml", at, "2x61")
        if row["s"] > 0 and row["t"] > 0]
write("swinging_tips.csv", ["s", "t", "x", "y", "z"], tips)

shape = [noisy(row, 5e-4, draw) for row in solve("bent.yaml", "stiffness_bending_0=3.1e-3", "21")
         if row["s"] > 0]
write("bent_shape.csv", ["s", "x", "y", "z"], shape)

rows = []
for i in range(16):
    known = {f"tension{k + 1}": round(draw.uniform(0, 3), 2) for k in range(3)}
    at = ",".join(f"{name}={value}" for name, value in known.items()) + ",modulus=2.6e5,pitch=9.2e-3"
    rows.append({**noisy(solve("../tutorial/measured.yaml", at, "2")[-1], 5e-4, draw), **known})
write("../tutorial/tips.csv", ["tension1", "tension2", "tension3", "s", "x", "y", "z"], rows)

# Motors go to and fro at random; what their drums do is computed here, and solved without a play.
rows, drums = [], [0.0, 0.0]
for i in range(40):
    winds = [round(draw.uniform(0, 6), 2) * 1e-3 for k in range(2)]
    drums = [max(wind - r, min(wind + r, drum)) for wind, drum, r in zip(winds, drums, (4e-4, 7e-4))]
    at = (f"wind1={drums[0]},wind2={drums[1]},play1=0,play2=0,loose=3e-4,stiff=4000")
    rows.append({**noisy(solve("backlash.yaml", at, "2")[-1], 2e-4, draw),
                 "wind1": winds[0], "wind2": winds[1]})
write("backlash_tips.csv", ["wind1", "wind2", "s", "x", "y", "z"], rows)

draw = random.Random(2)
poses = []
for i in range(60):
    known = {"pull": round(draw.uniform(0, 3), 3), "load": round(draw.uniform(0, 1), 3)}
    hidden = {"m0": 0.012 * math.sin(known["pull"]) + 0.01 * known["load"], "m1": 0.01 * known["load"]}
    at = ",".join(f"{name}={value}" for name, value in known.items()) + ",modulus=1e6"
    given = [f"parameters.{name}={value}" for name, value in hidden.items()]
    poses += [{**noisy(row, 1e-4, draw), **known} for row in solve("residual.yaml", at, "4", given)[1:]]
write("residual_poses.csv", ["s", "pull", "load", "x", "y", "z"], poses)
