# cpinn-bench: medians and spreads over seeds, and curves of other programs. The build puts it there.

def spread(values):
    """Median, smallest, largest."""
    if not values:
        return (math.nan,) * 3
    return statistics.median(values), min(values), max(values)


def best(run_, kind, seconds):
    return min((row[kind] for row in run_["rows"]
                if row["seconds"] <= seconds and not math.isnan(row[kind])), default=math.inf)


def reached(run_, kind, limit):
    return next((row["seconds"] for row in run_["rows"] if row[kind] <= limit), math.inf)


def last_error(run_, kind):
    """The error that a run leaves behind."""
    error = run_["rows"][-1][kind] if run_["rows"] and not failed(run_) else math.inf
    return math.inf if math.isnan(error) else error


def rate(run_):
    """Steps a second after the first row, which is made once equations are recorded and compiled."""
    rows = run_["rows"]
    if not run_["steps"] or len(rows) < 2 or rows[-1]["seconds"] <= rows[0]["seconds"]:
        return []
    return [(rows[-1]["step"] - rows[0]["step"]) / (rows[-1]["seconds"] - rows[0]["seconds"])]


def summarize(cell, kind):
    runs = cell.runs
    error = spread([last_error(r, kind) for r in runs])
    return {"parameters": cell.parameters, "seeds": len(runs),
            "failed": sum(map(failed, runs)),
            "seconds": spread([r["seconds"] for r in runs])[0],
            "steps_per_second": spread([x for r in runs for x in rate(r)])[0],
            "error_median": error[0], "error_low": error[1], "error_high": error[2]} | {
                f"seconds_to_{limit:.0e}".replace("e-0", "e-"):
                spread([reached(r, kind, limit) for r in runs])[0] for limit in LIMITS} | {
                    "warnings": sum(r["outcome"] == "warning" for r in runs)}


def band(cell, cells, kind):
    """[(seconds, median, smallest, largest)]: the best errors so far, on a grid of the scene."""
    def ends(of):
        rows = [r["rows"] for c in of for r in c.runs if r["rows"]]
        return min((r[0]["seconds"] for r in rows), default=math.inf), max(
            (r[-1]["seconds"] for r in rows), default=-math.inf)
    begin, end = ends([cell])
    first, last = ends([c for c in cells if c.scene == cell.scene])
    if begin > end:
        return []
    grid = [first * (last / first) ** (i / (GRID - 1)) for i in range(GRID)]
    rows = [(t, *spread([best(r, kind, t) for r in cell.runs]))
            for t in [t for t in grid if begin <= t < end] + [end]]
    return [row for row in rows if math.isfinite(row[1])]


# ---- curves of others ----------------------------------------------------------------------------

def read_curves(curves, text):
    """Adds {name: [(seconds, error)]} of --curve."""
    given, equals, path = text.rpartition("=")
    if not path or (equals and not given):
        fail(f"--curve {text}: allowed: FILE.csv or NAME=FILE.csv")
    fresh = {}
    try:
        with open(path, newline="") as file:
            lines = [(i, line.strip()) for i, line in enumerate(file, 1)]
    except (OSError, UnicodeDecodeError) as error:
        fail(f"{path}: {getattr(error, 'strerror', None) or 'this is no text'}")
    lines = [(i, line) for i, line in lines if line and not line.startswith("#")]
    names = [name.strip() for name in lines[0][1].split(",")] if lines else []
    for name in "seconds", "error":
        if name not in names:
            fail(f"{path}: column '{name}' is missing; a curve has columns seconds, error, and name "
                 "if there are several")
    if given and "name" in names:
        fail(f"--curve: {path} names its curves in a column; allowed: --curve {path}")
    if len(lines) < 2:
        fail(f"{path}: there are no rows; at least one is needed")
    for i, line in lines[1:]:
        row = dict(zip(names, (field.strip() for field in line.split(","))))
        point = []
        for name in "seconds", "error":
            try:
                point.append(float(row.get(name, "")))
            except ValueError:
                fail(f"{path}:{i}: {name}: '{row.get(name, '')}': the field is not a number")
            if not 0 < point[-1] < math.inf:
                fail(f"{path}:{i}: {name} is {point[-1]:g}; allowed: > 0 and finite, since both axes "
                     "are logarithmic")
        name = row.get("name", safe(given or os.path.splitext(os.path.basename(path))[0]))
        fresh.setdefault(name, []).append(tuple(point))
    for name in fresh:
        if name in curves:
            fail(f"--curve: two curves are called {name}")
    curves.update(fresh)
