#!/usr/bin/env python3
"""usage: cpinn-cases FOLDER|CONFIG.yaml... [options]

Solve each CONFIG.yaml, and every one in each FOLDER, twice: by cpinn-train, and classically by
cpinn-solve. There is one row for each. It has the error against the reference of the scene and the
run time.

options:
  --out DIR             write the table as DIR/cases.csv; an existing one is never overwritten
  --seconds S           time limit of each run, after which its error is that of the state
                        reached (600)
  --threads N           default 0: one for each processor; results do not depend on it
                        (of a network; the solver has one)
  --jobs N              that many runs at a time (1)
  --help                this text
  --version             the version

Examples
  cpinn-cases configs/cases/buckled_1.yaml configs/elastica.yaml
  cpinn-cases configs/cases --out cases

Columns
  method      form of the equations and the functions in it: strain modes by polynomials of time,
              mixed form by random waves or by a network (with hidden layers), collocation,
              spectral elements. Where it is not known: network or solver
  position    relative L2 error over the points of the reference; of a beam, of its deflection
  rotation    root mean square of the angle, rad
  seconds     as cpinn-train and cpinn-solve measure them: with recording, compiling and loading
              OpenBLAS, but without comparing
  size        of a network, unknowns and equations at a point; of the solver, nodes along
              the rod and steps of Newton's method, in motion steps of time
Where the reference is the solver's own (reference: solve), the solver shows its estimated error.

A row that ends with a warning, is refused, stops, crashes or takes too long shows its reason, and
the next begins. Ctrl-C ends the table and writes what there is. cases.csv has more columns: form,
outcome, reason, unknowns, equations, points or nodes, steps.

Exit status: 0 every row has an error against its reference; 1 some do not, or a file cannot be
written; 2 bad arguments; 130 or 143 stopped by a signal.
"""
import argparse
import concurrent.futures
import csv
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time

PROGRAM, VERSION = "cpinn-cases", "@PROJECT_VERSION@"
COLUMNS = ["case", "method", "form", "outcome", "reason", "position_error", "rotation_error",
           "seconds", "unknowns", "equations", "points", "steps"]
GRACE = 20  # s beyond the limit, for a last step and what is written
PROCESSES = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"]  # of mpirun and srun

running, stopped = set(), []  # processes at work; signals


def fail(text, status=2):
    print(f"{PROGRAM}: {text}", file=sys.stderr)
    sys.exit(status)


class Parser(argparse.ArgumentParser):
    def error(self, message):
        fail(message.replace("argument ", "").replace("unrecognized arguments:", "unknown option"))


def number(of, least, words):
    def read(text):
        try:
            value = of(text)
        except ValueError:
            value = math.nan
        if not value >= least or value == math.inf:
            raise argparse.ArgumentTypeError(f"{text}; allowed: {words}")
        return value
    return read


def parse():
    parser = Parser(prog=PROGRAM, add_help=False, allow_abbrev=False)
    parser.add_argument("operands", nargs="+", metavar="FOLDER|CONFIG.yaml")
    parser.add_argument("--out")
    parser.add_argument("--seconds", type=number(float, 1e-9, "a number > 0"), default=600.0)
    parser.add_argument("--threads", type=number(int, 0, "an integer, 0 or more"), default=0)
    parser.add_argument("--jobs", type=number(int, 1, "an integer, 1 or more"), default=1)
    return parser.parse_args()


def find_cases(operands):
    paths = []
    for operand in operands:
        try:
            inside = sorted(os.listdir(operand)) if os.path.isdir(operand) else None
            os.stat(operand)
        except OSError as error:
            fail(f"{operand}: {error.strerror}")
        cases = [operand] if inside is None else [
            os.path.join(operand, name) for name in inside
            if name.endswith(".yaml") and name != ".yaml"]
        if not cases:
            fail(f"{operand}: holds no case, NAME.yaml")
        paths += cases
    return paths


def run(limit, program, *arguments):
    """What the program says by --json, {} if nothing; its exit status; s; whether its time was up.

    A training that is told to stop says how far it has come, and a solver says nothing."""
    path = os.path.join(os.path.dirname(os.path.realpath(__file__)), program)
    began = time.monotonic()
    process = subprocess.Popen([path, *arguments, "--json", "-"], stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    running.add(process)
    if stopped:  # meanwhile
        process.terminate()
    late = False
    while True:
        try:
            text, _ = process.communicate(timeout=GRACE if late else limit)
            break
        except subprocess.TimeoutExpired:
            (process.kill if late else process.terminate)()
            late = True
    running.discard(process)
    try:
        said = json.loads(text)
    except ValueError:
        said = {}
    return said, process.returncode, time.monotonic() - began, late


def findings(said, status, late, limit):
    """The worst outcome with its reason, and a line for all that was found."""
    verdict = said.get("verdict", {})
    found = [f for f in verdict.get("findings", []) if not (late and f["reason"] == "signal")]
    if late:
        found.insert(0, {"outcome": "out of time", "reason": "time_limit" if said else "killed",
                         "text": f"stopped after {limit:g} s"})
    elif not said:
        found.insert(0, {"outcome": "crashed", "reason": "died", "text":
                         f"signal {-status}" if status < 0 else f"exit status {status}"})
    else:
        return verdict["outcome"], verdict["reason"], found
    return found[0]["outcome"], found[0]["reason"], found


def do(asked, path, method):
    """One row; None: a signal has cut it short."""
    if stopped:
        return None
    with tempfile.TemporaryDirectory() as folder:
        arguments = (["cpinn-train", path, "--threads", str(asked.threads), "--out",
                      os.path.join(folder, "run")] if method == "network" else
                     ["cpinn-solve", path, "--set", "reference.solve=null"])
        said, status, seconds, late = run(asked.seconds, *arguments)
    if stopped:
        return None
    outcome, reason, found = findings(said, status, late, asked.seconds)
    known = said.get("reference") or {}
    covers = said.get("window", 0) + 1 >= said.get("windows", 1)  # all windows of time
    moves = said.get("load_factor") is None
    return {"case": os.path.splitext(os.path.basename(path))[0], "method": method,
            "form": said.get("form") or method, "outcome": outcome, "reason": reason,
            "position_error": known.get("position_relative_l2", said.get("estimated_error"))
            if covers and outcome not in ("stopped", "refused") else None,
            "rotation_error": known.get("rotation_rms_rad") if covers else None,
            "seconds": said.get("training_seconds", said.get("seconds", seconds)),
            "unknowns": said.get("unknowns"), "equations": said.get("equations"),
            "points": said.get("points", said.get("nodes")),
            "steps": said.get("step", said.get("steps" if moves else "newton_steps")),
            "findings": found}


# ---- the table -----------------------------------------------------------------------------------

def counted(count, what):
    return [] if count is None else [f"{count:.0f} {what}{'' if count == 1 else 's'}"]


def size_of(row):
    parts = (counted(row["unknowns"], "unknown") + counted(row["equations"], "equation")
             if row["method"] == "network" else
             counted(row["points"], "node") + counted(row["steps"] or None, "step"))
    return ", ".join(parts) or "-"


def seconds_text(seconds):
    digits = next((d for most, d in ((0.00095, 4), (0.0995, 3), (9.995, 2), (99.95, 1))
                   if seconds < most), 0)
    return f"{seconds:.{digits}f}"


def error_text(value):
    return "-" if value is None else f"{value:.1e}"


def print_row(row, width, is_named):
    print(f"{row['case'] if is_named else '':{width}}  {row['form']:27}  "
          f"{error_text(row['position_error']):>8}  {error_text(row['rotation_error']):>8}  "
          f"{seconds_text(row['seconds']):>7}  {size_of(row)}")
    for found in row["findings"] if row["outcome"] != "solved" else []:
        word = "note" if found["outcome"] == "solved" else found["outcome"]
        print(f"{'':{width}}  {word} ({found['reason']}): {found['text']}")
    sys.stdout.flush()


def write(path, rows):
    with open(path, "x", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(COLUMNS)
        for row in rows:
            table.writerow("nan" if row[name] is None else row[name] for name in COLUMNS)


def stop(number, _frame):
    stopped.append(number)
    for process in list(running):
        process.terminate()


def main():
    for option, text in ("--help", __doc__), ("--version", f"{PROGRAM} {VERSION}\n"):
        if option in sys.argv[1:]:  # argparse would not say that it cannot be written
            print(text, end="")
            return 0
    asked = parse()
    if any(os.environ.get(name, "1") not in ("", "1") for name in PROCESSES):
        fail("does not share its work among processes: start it without mpirun or srun; --jobs N "
             "does N runs at a time")
    paths = find_cases(asked.operands)
    path = os.path.join(asked.out, "cases.csv") if asked.out is not None else None
    if path and os.path.exists(path):
        fail(f"{asked.out}: there is a table already; choose another folder with --out")
    try:
        if path:
            os.makedirs(asked.out, exist_ok=True)
    except OSError as error:
        fail(f"{error.filename}: the folder cannot be made: {error.strerror}")
    for number_ in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number_, stop)
    width = max(map(len, ["case"] + [os.path.basename(p)[:-5] for p in paths]))
    print(f"{'case':{width}}  {'method':27}  {'position':>8}  {'rotation':>8}  {'seconds':>7}  size")
    rows = []
    with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        todo = [pool.submit(do, asked, p, method) for p in paths for method in
                ("network", "solver")]
        for i, job in enumerate(todo):
            row = job.result()
            if row:
                print_row(row, width, i % 2 == 0 or not rows or rows[-1]["case"] != row["case"])
                rows.append(row)
    try:
        if path and rows:
            write(path, rows)
    except OSError as error:
        fail(f"{path}: {error.strerror}", 1)
    if stopped:
        return 128 + stopped[0]
    return int(any(row["position_error"] is None for row in rows))


try:
    status = main()
    sys.stdout.flush()
except SystemExit as end:
    status = end.code
except OSError as error:
    print(f"{PROGRAM}: what it prints could not be written: {error.strerror}", file=sys.stderr)
    os._exit(1)  # or Python would try once more
sys.exit(status)
