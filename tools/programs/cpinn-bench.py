#!/usr/bin/env python3
"""usage: cpinn-bench CONFIG.yaml... [options]

Train each CONFIG.yaml by several methods from several seeds, by cpinn-train. The result is the
error against the reference over training time: as a table, as CSV, and as a picture drawn by
gnuplot.

options:
  --methods LIST        names from the table below and definitions, separated by
                        commas, as in lbfgs,fast=adam:300+gauss_newton:60 (all of the
                        table but config and solver)
  --networks LIST       hidden layers x width, as in 2x16,3x32; random Fourier features
                        without hidden layers, as in f16,f64; or both, as in 2x16+f8
                        (that of the config)
  --seeds N             number of runs of each, from the config's seed upwards (3)
  --seconds S           time limit of each run, after which its error is that of the state
                        reached (10)
  --error KIND          position: relative L2 over the reference (default); tip:
                        largest at s = L, over L; rotation: root mean square angle, rad
  --curve [NAME=]FILE   a curve of another program to lay beside, as CSV; may be repeated
  --set KEY=VALUE       change one key, as in --set loads.tip.force[2]=-10;
                        may be repeated
  --threads N           default 0: one for each processor; results do not depend on it
  --out DIR             folder of the files; existing results are never overwritten
                        (bench/NAME, bench/NAME-2, ...)
  --quiet               print only errors
  --help                this text
  --version             the version

Examples
  cpinn-bench configs/elastica.yaml
  cpinn-bench configs/elastica.yaml --methods lbfgs,gauss_newton --networks 2x8,2x16,2x32
  cpinn-bench configs/elastica.yaml --methods gauss_newton:50 --networks f8,f16,f32
  cpinn-bench configs/elastica.yaml --methods config,slow=adam:1000+lbfgs:9000 --seconds 5
  cpinn-bench configs/elastica.yaml --methods config,solver        networks and cpinn-solve
  cpinn-bench configs/cantilever_dynamic.yaml --error tip \\
      --curve configs/reference/cantilever_ramp_solvers.csv

Seconds are those of cpinn-train and cpinn-solve: with recording and compiling the equations and
loading OpenBLAS, without evaluating the error. The rows are those of history.csv: --set
output.every=1 makes more of them. Runs go one after another: all methods with one seed, then the
next seed. Ctrl-C ends the current run and writes what there is.

DIR receives
  runs.csv               every row of every run: scene, method, network, seed, seconds, ...
  summary.csv            a row for each line of the table; inf: not reached
  curves.csv             best error so far over seconds: median, smallest, largest over seeds
  SCENE.gp, .svg, .png   the picture, and the gnuplot script to restyle it
  about.txt              what was run

--curve takes a table with the columns seconds and error, and name if it holds several curves.
Lines that begin with # are comments.

Exit status: 0 done; 1 a file cannot be written; 2 bad input; 130 or 143 stopped by a signal. A run
with a number that is not finite counts as failed. A run that ends with a warning counts as such.

Methods
"""
import csv
import shlex
import statistics
import tempfile

PROGRAM, VERSION = "cpinn-bench", "@PROJECT_VERSION@"
LIMITS = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
GRID = 240  # points of a curve
ENDLESS = 10 ** 9  # the most that training.stages[].steps allows
AT_REST = [2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 96, 128, 192, 256]  # nodes
MOVING = [5, 7, 9, 11, 13, 17, 21]
REPEATS = 5  # of a solution at rest
ROUNDING = 1e-14
# --error: its text, its column of history.csv, its field of --json
MEASURES = {"position": ("relative L2 error of position", "error", "position_relative_l2"),
            "tip": ("tip error / length", "tip_error", "tip_over_length"),
            "rotation": ("rotation error, rad", "rotation_error", "rotation_rms_rad")}

@RUNS@

@BENCH_STATISTICS@

@BENCH_PICTURE@

# ---- methods and networks ------------------------------------------------------------------------

def usual_stages():
    """{optimiser: stages}, with the defaults of a stage, up to the end of a learning rate.

    Those without a rate get a start by Adam, from which they do not fall into a poor minimum."""
    text = subprocess.run([place_of("cpinn-train"), "--help"], stdout=subprocess.PIPE, text=True,
                          check=True).stdout
    def those(pattern):
        return re.search(r"training\.stages\[\]\." + pattern, text)[1].split(", ")
    gradients, squares = those("learning_rate: .*; (.*) only"), those("initial_damping: .*; (.*) only")
    return {name: f"{name}:5000" if name in gradients else
            f"adam:100+{name}" if name in squares else f"adam:300+{name}"
            for name in those("optimizer: one of (.*); required")}


def help_text():
    usual = usual_stages()
    lines = [f"  {name:14} {stages}\n" for name, stages in usual.items()]
    return __doc__ + "\n" + "".join(lines) + f"""\
  config         the stages that the config itself has
  solver         no network: cpinn-solve, with more and more nodes

  NAME=STAGES defines another: OPTIMIZER:STEPS joined by '+'. Without STEPS a stage lasts
  until it ends by itself or time is up. Optimisers: {", ".join(usual)}.
"""


def safe(name):
    """A name for columns of CSV and for files."""
    name = re.sub(r"""[\x00-\x1f,"'/#\x7f]""", "_", name)
    name = re.sub(" +$", lambda blanks: "_" * len(blanks[0]), name)
    return re.sub("^[ .]", "_", name) or "_"


def stages_of(definition, optimizers):
    stages = []
    for stage in definition.split("+"):
        name, colon, steps = stage.partition(":")
        if name not in optimizers:
            fail(f"--methods {definition}: '{name}' is not an optimiser; allowed: "
                 f"{', '.join(optimizers)}")
        if colon and not (re.fullmatch("[0-9]{1,10}", steps) and 1 <= int(steps) <= ENDLESS):
            fail(f"--methods {definition}: '{stage}' is not a stage; allowed: OPTIMIZER:STEPS with "
                 f"1 to {ENDLESS} steps, as in adam:300+lbfgs:2000")
        stages.append(f"{{optimizer: {name}, steps: {int(steps) if colon else ENDLESS}}}")
    return f"training.stages=[{', '.join(stages)}]"


def methods_of(text, usual):
    """{name: (stages as given, as for --set)} in order."""
    methods = {}
    for entry in (",".join(usual) if text is None else text).split(","):
        name, equals, definition = entry.partition("=")
        name = safe(name) if name else ""
        if not name or (equals and not definition):
            fail(f"--methods {entry}: allowed: names and stages, separated by commas")
        if not equals and re.search("[:+]", entry):
            definition = entry
        elif not equals:
            definition = usual.get(name, "")
            if not definition and name not in ("config", "solver"):
                fail(f"--methods {name}: there is no such method; allowed: config,solver,"
                     f"{','.join(usual)}, or a definition as in fast=adam:300+lbfgs:2000")
        if name in methods:
            fail(f"--methods: {name} is there twice")
        methods[name] = definition, definition and stages_of(definition, usual)
    return methods


def networks_of(text):
    """{name: as for --set} in order; the network of the config has no name."""
    networks = {}
    for entry in text.split(",") if text is not None else [None]:
        if entry is None:
            return {"": []}
        given = re.fullmatch(r"(?:([0-9]+)x([0-9]+))?(?(1)(?:\+f([0-9]+))?|f([0-9]+))", entry)
        layers, width, *features = map(int, (n or -1 for n in given.groups())) if given else (0,) * 4
        features = max(features)
        if (not given or 0 in (layers, width, features) or layers > 8 or width > 4096 or
                features > 1024):
            fail(f"--networks {entry}: allowed: LAYERSxWIDTH, 1 to 8 layers of 1 to 4096; fN, 1 to "
                 "1024 random features without hidden layers; or both, as in 2x16,f64,2x16+f8")
        if entry in networks:
            fail(f"--networks: {entry} is there twice")
        networks[entry] = [f"network.hidden={[width] * max(layers, 0)}"]
        if features > 0:
            networks[entry].append(f"network.fourier.features={features}")
    return networks


def network_name(hidden, features, degree):
    name = (f"{len(hidden)}x{hidden[0]}" if len(set(hidden)) == 1 else "-".join(map(str, hidden)))
    if not name and degree > 0:
        return f"p{degree}"
    return "+".join(([name] if name else []) + ([f"f{features}"] if features or not name else []))


# ---- runs ----------------------------------------------------------------------------------------

def parse():
    parser = Parser()
    parser.add_argument("configs", nargs="+", metavar="CONFIG.yaml")
    for option in "--methods", "--networks", "--out":
        parser.add_argument(option)
    parser.add_argument("--error", default="position")
    parser.add_argument("--seeds", type=number(int, 1, "an integer, 1 to 100", 100), default=3)
    parser.add_argument("--seconds", type=SECONDS, default=10.0)
    parser.add_argument("--threads", type=THREADS, default=0)
    parser.add_argument("--curve", action="append", default=[])
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--quiet", action="store_true")
    return parser.parse_args()


class Cell:
    """A scene, by a method, with a network; its runs."""

    def __init__(self, asked, path, method, override, network, overrides):
        self.path, self.method, self.runs = path, method, []
        self.overrides = ([override] if override else []) + asked.set + overrides
        settings = subprocess.run([place_of("cpinn-train"), path, "--print-config", *self.sets()],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                  check=False)
        if settings.returncode != 0:
            fail(settings.stderr.strip().removeprefix("cpinn-train: "))
        keys, room = {}, []
        for line in settings.stdout.splitlines():
            key = re.match(r"( *)([a-z_0-9]+): *(null|.*)", line)
            if key:
                room[len(key[1]) // 2:] = [key[2]]
                keys[".".join(room)] = key[3]
        self.scene = safe(json.loads(keys["name"]))
        self.seed = int(keys["training.seed"])
        self.moves = keys["time.duration"] != "0"
        self.network = network or network_name(json.loads(keys["network.hidden"]),
                                               int(keys["network.fourier.features"]),
                                               int(keys["network.polynomial.degree"]))
        if method == "solver":
            self.network = "-"
        self.solved = keys["reference.solve"]
        if all(keys[f"reference.{key}"] in ("none", "null")
               for key in ("analytic", "solve", "file", "deflection")):
            fail(f"{path}: the scene names no reference, so there is no error to show; allowed: "
                 "reference.analytic, solve or file")
        self.form, self.parameters, self.estimate = "", 0, None

    def sets(self, *more):
        return [word for override in [*self.overrides, *more] for word in ("--set", override)]

    def rehearse(self, error):
        """Does the reference know this error?"""
        with tempfile.TemporaryDirectory() as folder:
            said, *_ = run(600, "cpinn-train", self.path, *self.sets(
                "training.stages=[{optimizer: adam, steps: 1}]"), "--out", folder + "/run")
        known = said.get("reference") or {}
        if known.get("position_relative_l2") is not None and known.get(MEASURES[error][2]) is None:
            fail(f"--error {error}: the reference {known['name']} of {self.path} does not know it; "
                 "allowed: position")

    def learn(self, said):
        """What is known of the cell once it has been run."""
        self.form, self.parameters = said.get("form") or self.form, said.get("parameters") or 0
        estimate = (said.get("reference") or {}).get("estimated_error_over_length")
        self.estimate = self.estimate if estimate is None else estimate


def plan(asked, methods, networks):
    cells = []
    for path in asked.configs:
        for method, (_, override) in methods.items():
            for network, overrides in networks.items():
                if method != "solver" or network == next(iter(networks)):
                    cells.append(Cell(asked, path, method, override, network, overrides))
                    if asked.error != "position":
                        cells[-1].rehearse(asked.error)
                    if any(c.scene == cells[-1].scene and c.path is not path for c in cells):
                        fail(f"{path}: a scene called {cells[-1].scene} is there already; give it "
                             "another name: in the file")
    return cells


def check(asked, methods, networks):
    """--set must not undo what tells the runs apart."""
    for text in asked.set:
        if text.startswith("training.stages=") and any(o for _, o in methods.values()):
            fail("--set training.stages: the stages are those of --methods; allowed: --methods "
                 "config, or a method such as fast=adam:300+lbfgs:2000")
        for key in "network.hidden", "network.fourier.features":
            if text.startswith(key) and any(key in o for n in networks.values() for o in n):
                fail(f"--set {key}: it is that of --networks; allowed: one of the two")
    if asked.error not in MEASURES:
        fail(f"--error {asked.error}: allowed: {', '.join(MEASURES)}")
    if asked.curve and len(asked.configs) > 1:
        fail("--curve: a curve belongs to one scene; allowed: one CONFIG.yaml at a time")


def value(text):
    return float(text) if text not in (None, "") else math.nan


def last_row(said):
    known = said.get("reference") or {}
    return {"seconds": value(said.get("training_seconds", said.get("seconds"))),
            "step": value(said.get("step", said.get("nodes"))), "loss": value(said.get("loss")),
            "held_out": value(said.get("held_out")),
            **{kind: value(known.get(field)) if covers(said) else math.nan
               for kind, (_, _, field) in MEASURES.items()}}


def history(path, said):
    """Rows in time. Errors count where they are those of the whole scene, not of its first windows."""
    rows, windows = [], said.get("windows", 1)
    try:
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                whole = windows == 1 or value(row["window"]) == windows
                rows.append({name: value(row[name])
                             for name in ("seconds", "step", "loss", "held_out")} |
                            {kind: value(row.get(column)) if whole else math.nan
                             for kind, (_, column, _) in MEASURES.items()})
    except OSError:
        pass
    if said.get("step", 0) > (rows[-1]["step"] if rows else 0):  # stopped
        rows.append(last_row(said))
    return rows


def train(asked, cell, seed):
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "run")
        said, status, _, late = run(
            asked.seconds, "cpinn-train", cell.path, *cell.sets(f"training.seed={seed}"),
            "--threads", str(asked.threads), "--out", out)
        rows = history(os.path.join(out, "history.csv"), said)
    cell.learn(said)
    outcome, reason, found = findings(said, status, late, asked.seconds)
    return {"seed": seed, "rows": rows, "seconds": value(said.get("training_seconds")),
            "steps": said.get("step", 0), "outcome": outcome, "reason": reason, "findings": found}


def solver_sets(cell, folder):
    """cpinn-solve does not compare with a reference of its own, which is made a file."""
    if cell.solved == "null":
        return cell.sets()
    path = os.path.abspath(os.path.join(folder, "reference.h5"))
    said, *_ = run(600, "cpinn-solve", cell.path, *cell.sets(), "--tolerance", cell.solved, "--out",
                   path)
    cell.estimate = said.get("estimated_error")
    return cell.sets("reference.solve=null", f"reference.file={path}")


def sweep(asked, cell, seed):
    with tempfile.TemporaryDirectory() as folder:
        return sweep_nodes(asked, cell, seed, solver_sets(cell, folder))


def sweep_nodes(asked, cell, seed, sets):
    """By more and more nodes. Rows are in time, as those of training: more nodes are no quicker."""
    rows, spent, tolerance = [], 0.0, 0.1
    outcome, reason, found, last = "solved", "none", [], 0.0
    for nodes in MOVING if cell.moves else AT_REST:
        tolerance /= 10
        seconds = []
        for _ in range(1 if cell.moves else REPEATS):
            said, status, _, late = run(
                max(asked.seconds - spent, 1e-3), "cpinn-solve", cell.path, *sets,
                "--nodes", str(nodes), "--tolerance", f"{max(tolerance, 1e-13):g}")
            if late or stopped or "seconds" not in said:
                break
            seconds.append(said["seconds"])
            spent += said["seconds"]
        if late:
            outcome, reason, found = "out of time", "time_limit", []
        elif "seconds" not in said and not stopped:
            outcome, reason, found = findings(said, status, False, 0)
        if late or stopped or "seconds" not in said:
            break
        cell.learn(said)
        if said.get("load_factor") in (None, 1):
            last = max(last, statistics.median(seconds))
            rows.append(last_row(said) | {"seconds": last})
            if not rows[-1][asked.error] >= ROUNDING:
                break
    if not rows and outcome == "solved":
        outcome, reason = "warning", "load_not_reached"
    return {"seed": seed, "rows": rows, "seconds": last if rows else math.nan, "steps": 0,
            "outcome": outcome, "reason": reason, "findings": found}


def failed(run_):
    return run_["outcome"] in ("stopped", "crashed", "refused") and run_["reason"] != "signal"


def report(run_, cell, asked, number_, total):
    error = f"error {run_['rows'][-1][asked.error]:.2e}, " if run_["rows"] else ""
    how = (f"failed: {run_['findings'][0]['text']}" if failed(run_) else
           "stopped" if run_["reason"] == "signal" else
           "time is up" if run_["outcome"] == "out of time" else "every stage ended")
    warned = f"; warning: {run_['reason']}" if run_["outcome"] == "warning" else ""
    print(f"[{number_}/{total}] {cell.scene} {cell.method} {cell.network} seed {run_['seed']}: "
          f"{error}{run_['seconds']:.2f} s, {run_['steps']} steps, {how}{warned}", flush=True)


def do_all(asked, cells):
    """Seeds outermost, so that what else the machine does is spread over the methods, and what there
    is after Ctrl-C compares."""
    total = asked.seeds * len(cells)
    for i in range(total):
        cell = cells[i % len(cells)]
        if stopped:
            return i
        do = sweep if cell.method == "solver" else train
        cell.runs.append(do(asked, cell, cell.seed + i // len(cells)))
        if not asked.quiet:
            report(cell.runs[-1], cell, asked, i + 1, total)
    return total


# ---- what is written -----------------------------------------------------------------------------

def print_tables(cells, asked):
    widths = [max(len(word), *(len(getattr(c, word)) for c in cells))
              for word in ("method", "network", "form")]
    for i, cell in enumerate(cells):
        if i == 0 or cells[i - 1].scene != cell.scene:
            print(f"\n{cell.scene}: {MEASURES[asked.error][0]}, medians over seeds (smallest .. "
                  f"largest)\n\n  {'':{sum(widths) + 18}}  seconds to an error of")
            words = " ".join(f"{word:{w}}" for word, w in
                             zip(("method", "network", "form"), widths))
            print(f"  {words} params steps/s " + " ".join(f"{limit:6.0e}" for limit in LIMITS) +
                  "  error at the end")
        print_cell(cell, asked, widths)


def print_cell(cell, asked, widths):
    of = summarize(cell, asked.error)
    words = " ".join(f"{word:{w}}" for word, w in zip((cell.method, cell.network, cell.form), widths))
    steps = of["steps_per_second"]
    times = [seconds_text(seconds) for name, seconds in of.items() if name.startswith("seconds_to")]
    end = error_text(of["error_median"]) if cell.runs else "not run"
    if of["seeds"] > 1:
        end += f" ({error_text(of['error_low'])} .. {error_text(of['error_high'])})"
    for count, what in (of["failed"], "failed"), (of["warnings"], "with a warning"):
        end += f", {count} of {of['seeds']} {what}" if count else ""
    print(f"  {words} {cell.parameters or '-':>6} {'-' if math.isnan(steps) else f'{steps:.0f}':>7} "
          + " ".join(f"{text:>6}" for text in times) + f"  {end}")
    if cell.estimate is not None and of["error_low"] <= cell.estimate:
        print(f"    the reference itself is off by an estimated {cell.estimate:.1e}; true errors may "
              "be as large")


def write_table(folder, name, columns, rows):
    with open(os.path.join(folder, name + ".csv"), "x", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["scene", "method", "network", *columns])
        table.writerows(rows)


def write_tables(folder, cells, kind):
    def named(cell, numbers):
        return [cell.scene, cell.method, cell.network, *numbers]
    columns = ["seconds", "step", kind, "held_out", "loss", *MEASURES]
    runs = sorted(((k, i) for i, c in enumerate(cells) for k in range(len(c.runs))))
    write_table(folder, "runs",
                ["seed", "seconds", "step", "error", "held_out", "loss", "position_error",
                 "tip_error", "rotation_error"],
                [named(cells[i], [cells[i].runs[k]["seed"], *(row[c] for c in columns)])
                 for k, i in runs for row in cells[i].runs[k]["rows"]])
    write_table(folder, "summary", summarize(cells[0], kind),
                [named(c, summarize(c, kind).values()) for c in cells])
    write_table(folder, "curves", ["seconds", "median", "low", "high"],
                [named(c, row) for c in cells for row in band(c, cells, kind)])


def about(asked, methods, done, total):
    how = {"config": "the stages of the config", "solver": "classical, with more and more nodes"}
    lines = ["scenes:", *(f"  {path}" for path in asked.configs), "methods:",
             *(f"  {name} = {stages or how[name]}" for name, (stages, _) in methods.items()),
             f"networks: {asked.networks or 'of the configs'}",
             *(["set:"] + [f"  {text}" for text in asked.set] if asked.set else []),
             *(["curves:"] + [f"  {text}" for text in asked.curve] if asked.curve else []),
             f"seeds: {asked.seeds}",
             f"threads: {asked.threads or '0 (one for each processor)'}",
             f"limit: {asked.seconds:g} s for each run", f"error: {MEASURES[asked.error][0]}",
             f"runs: {done} of {total}"]
    return f"{PROGRAM} {VERSION}\n\n" + "\n".join(lines) + "\n"


# ---- all of it -----------------------------------------------------------------------------------

def taken(folder):
    return any(os.path.exists(os.path.join(folder, name))
               for name in ("about.txt", "runs.csv", "summary.csv"))


def choose_folder(asked, cells):
    """Results are never overwritten: a folder of the user's choice must be new to them."""
    folder = asked.out
    if folder is not None and taken(folder):
        fail(f"{folder}: there are results already; choose another folder with --out")
    if folder is None:
        first = folder = "bench/" + "+".join(dict.fromkeys(c.scene for c in cells))[:200]
        i = 1
        while taken(folder):
            i += 1
            folder = f"{first}-{i}"
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        fail(f"{error.filename or folder}: the folder cannot be made: {error.strerror}")
    return folder


def finish(folder, cells, curves, asked, text):
    """What there is, also after a signal or a run that went wrong."""
    if not asked.quiet:
        print_tables(cells, asked)
    write_tables(folder, cells, asked.error)
    scenes, remark = list(dict.fromkeys(c.scene for c in cells)), None
    for name in scenes:
        body, head, tail = script([c for c in cells if c.scene == name], cells, curves, asked)
        with open(os.path.join(folder, name + ".gp"), "w") as file:
            file.write(head + body + tail)
        remark = remark or draw(folder, name)
    with open(os.path.join(folder, "about.txt"), "w") as file:
        file.write(text)
    if remark:
        print(f"{PROGRAM}: {remark}", file=sys.stderr)
    if not asked.quiet:
        print(f"\n  {folder}/\n  {folder}/summary.csv, runs.csv, curves.csv")
        for name in scenes if not remark else []:
            print(f"  {folder}/{name}.png, {name}.svg, {name}.gp")


def main():
    asked = parse()
    alone("")
    methods, networks = methods_of(asked.methods, usual_stages()), networks_of(asked.networks)
    check(asked, methods, networks)
    curves = {}
    for text in asked.curve:
        read_curves(curves, text)
    cells = plan(asked, methods, networks)
    total = asked.seeds * len(cells)
    folder = choose_folder(asked, cells)
    if not asked.quiet:
        print(f"{total} runs of at most {asked.seconds:.3g} s each -> {folder}", flush=True)
    done = do_all(asked, cells)
    try:
        finish(folder, cells, curves, asked, about(asked, methods, done, total))
    except OSError as error:
        if not error.filename:
            raise
        fail(f"{error.filename}: {error.strerror}", 1)
    return 128 + stopped[0] if stopped else 0


if __name__ == "__main__":
    sys.exit(start(main, help_text))
