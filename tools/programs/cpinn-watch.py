#!/usr/bin/env python3
"""usage: cpinn-watch DIR [options]

Draw the curves of a run on the terminal while it goes on: loss, loss on held-out points and error
over seconds, from history.csv in DIR. Programs that keep a run in a folder: cpinn-train --out, and
cpinn-law, cpinn-residual and cpinn-solve --run. gnuplot draws them. It ends when the run ends.

options:
  --once                draw once, now
  --help                this text
  --version             the version

  cpinn-train configs/elastica_deep.yaml --quiet --out runs/deep &
  cpinn-watch runs/deep

The shape as it is so far, in a browser: cpinn-show DIR. Colours are left out where NO_COLOR is set or
what is printed goes into a pipe, where only the last picture is drawn.

Exit status: 0 the run has ended, or --once; 1 gnuplot is missing or fails; 2 bad arguments; 130 or
143 stopped by a signal.
"""
import csv
import fcntl
import shutil

PROGRAM, VERSION = "cpinn-watch", "@PROJECT_VERSION@"
CURVES = [("loss", "loss", "cyan"), ("held_out", "held-out", "magenta"), ("error", "error", "yellow")]
WAIT = 10  # s, for a run that is about to begin
APART = 0.5  # s between pictures, at least

@RUNS@

def parse():
    parser = Parser()
    parser.add_argument("folder", metavar="DIR")
    parser.add_argument("--once", action="store_true")
    return parser.parse_args()


def goes_on(folder):
    """A run locks its folder."""
    try:
        with open(os.path.join(folder, "lock")) as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        pass
    return False


def read(path):
    """{column: text} of the last row, and {column: numbers} that can be drawn."""
    with open(path, newline="") as file:
        rows = [row for row in csv.DictReader(file) if None not in row.values()]
    columns = {}
    for name, *_ in CURVES:
        points = [(row["seconds"], row[name]) for row in rows if row.get(name)]
        columns[name] = [(t, y) for t, y in points if 0 < float(y) < math.inf]
    return rows[-1] if rows else {}, columns


def draw(columns, room, colours):
    """The picture as lines, and as wide and high as there is room."""
    drawn = [(name, title, colour) for name, title, colour in CURVES if columns[name]]
    if not drawn:
        return []
    blocks = "".join(f"${name} << END\n" + "".join(f"{t} {y}\n" for t, y in columns[name]) + "END\n"
                     for name, *_ in drawn)
    plots = ", ".join(f"${name} using 1:2 with lines lc rgb '{colour}' title '{title}'"
                      for name, title, colour in drawn)
    size = f"{min(room[0] - 1, 160)},{min(room[1] - 3, 40)}"
    done = subprocess.run(
        ["gnuplot"], input=f"{blocks}set terminal dumb {'ansi' if colours else 'mono'} size {size}\n"
        "set logscale y\nset format y '1e%T'\nset xlabel 's'\nset key top right\n"
        f"plot {plots}\n", stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        fail(f"gnuplot failed: {(done.stderr.strip().splitlines() or ['it says nothing'])[-1]}", 1)
    return [line.rstrip() for line in done.stdout.replace("\f", "").splitlines()]


def show(folder, shown, terminal):
    """Over the picture before, which had `shown` lines; returns how many this one has."""
    last, columns = read(os.path.join(folder, "history.csv"))
    lines = draw(columns, shutil.get_terminal_size(), terminal and "NO_COLOR" not in os.environ)
    lines.insert(0, f"{folder}: step {last.get('step', 0)} in {float(last.get('seconds') or 0):.2f} s" +
                 "".join(f", {title} {float(last[name]):.2e}" for name, title, _ in CURVES
                         if last.get(name)))
    back = f"\033[{shown}A\033[J" if shown else ""
    print(back + "\n".join(lines), flush=True)
    return len(lines)


def main():
    asked = parse()
    path = os.path.join(asked.folder, "history.csv")
    if not shutil.which("gnuplot"):
        fail("gnuplot is not installed, and draws the picture", 1)
    began = time.monotonic()
    while not os.path.exists(path):
        if asked.once or stopped or time.monotonic() - began > WAIT:
            fail(f"{asked.folder}: there is no run; allowed: a folder with history.csv")
        time.sleep(0.1)
    terminal = sys.stdout.isatty() and os.environ.get("TERM", "dumb") != "dumb"
    shown, size = 0, -1
    while not (over := asked.once or stopped or not goes_on(asked.folder)):
        now = os.stat(path).st_size
        if terminal and now != size:
            shown, size = show(asked.folder, shown, terminal), now
        time.sleep(APART)
    if over and not stopped:
        show(asked.folder, shown, terminal)
    return 128 + stopped[0] if stopped else 0


if __name__ == "__main__":
    sys.exit(start(main, lambda: __doc__))
