"""Trains a scene file, and compares it with a classical solution: from_file.py CONFIG.yaml"""
import sys
import cpinn

model = cpinn.train(sys.argv[1])
values = model.evaluate("x z", s=1, t=[0.5, 1])
solved = cpinn.solve(sys.argv[1], s=1, t=[0.5, 1])
error = abs(values["z"] - solved.values["z"]).max()
print("from Python:", model.verdict, "and", solved.verdict, "agree to", error)
sys.exit(0 if model.verdict.outcome == "solved" and error < 1e-5 else 1)
