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
import concurrent.futures
import csv
import tempfile

PROGRAM, VERSION = "cpinn-cases", "@PROJECT_VERSION@"
COLUMNS = ["case", "method", "form", "outcome", "reason", "position_error", "rotation_error",
           "seconds", "unknowns", "equations", "points", "steps"]

@RUNS@

def parse():
    parser = Parser()
    parser.add_argument("operands", nargs="+", metavar="FOLDER|CONFIG.yaml")
    parser.add_argument("--out")
    parser.add_argument("--seconds", type=SECONDS, default=600.0)
    parser.add_argument("--threads", type=THREADS, default=0)
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
    moves = said.get("load_factor") is None
    return {"case": os.path.splitext(os.path.basename(path))[0], "method": method,
            "form": said.get("form") or method, "outcome": outcome, "reason": reason,
            "position_error": known.get("position_relative_l2", said.get("estimated_error"))
            if covers(said) and outcome not in ("stopped", "refused") else None,
            "rotation_error": known.get("rotation_rms_rad") if covers(said) else None,
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


def main():
    asked = parse()
    alone("; --jobs N does N runs at a time")
    paths = find_cases(asked.operands)
    path = os.path.join(asked.out, "cases.csv") if asked.out is not None else None
    if path and os.path.exists(path):
        fail(f"{asked.out}: there is a table already; choose another folder with --out")
    try:
        if path:
            os.makedirs(asked.out, exist_ok=True)
    except OSError as error:
        fail(f"{error.filename}: the folder cannot be made: {error.strerror}")
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


sys.exit(start(main, lambda: __doc__))
