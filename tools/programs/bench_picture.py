# cpinn-bench: a script for gnuplot, and its picture. The build puts it there.

# Okabe & Ito's palette, which colour-blind readers can tell apart, without its yellow, which is
# too pale for a line: https://jfly.uni-koeln.de/color/.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
# Curves of others are grey; their points tell them apart.
GREYS = ["#333333", "#777777", "#999999"]
POINTS = [5, 7, 9, 11, 13, 4, 6, 8, 10, 12]
DASHES = ["solid", "(8,4)", "(2,3)", "(8,3,2,3)", "(16,4)"]


def quoted(text):
    return "'" + re.sub(r"[\x00-\x1f]", " ", text).replace("'", "''") + "'"


def script(cells, cells_of_all, curves, asked):
    """Error over time of one scene, for gnuplot."""
    kind, name, seeds = asked.error, cells[0].scene, max(len(c.runs) for c in cells)
    uneven = len({len(c.runs) for c in cells_of_all}) > 1
    threads = asked.threads or os.cpu_count()
    note = (f"median of {'up to ' * uneven}{seeds} seeds, shaded from the best to the worst"
            if seeds > 1 else "one seed") + f"; {threads} thread{'s' * (threads != 1)}"
    label = "rotation error (rad)" if kind == "rotation" else MEASURES[kind][0]
    methods = list(dict.fromkeys(c.method for c in cells))
    networks = list(dict.fromkeys(c.network for c in cells))
    bands = [(i, c, rows) for i, c in enumerate(cells) if (rows := band(c, cells_of_all, kind))]
    top = max((x for *_, rows in bands for row in rows for x in row[1:] if math.isfinite(x)),
              default=0)  # spreads without an upper end are drawn up to here
    data, shades, lines = [], [], []
    for i, cell, rows in bands:
        data += [f"$band{i} << END", *("%.6g %.6g %.6g %.6g" % (
            *row[:3], row[3] if math.isfinite(row[3]) else top) for row in rows), "END"]
        first = methods.index(cell.method) if len(methods) > 1 else networks.index(cell.network)
        colour = COLOURS[first % len(COLOURS)]
        dash = DASHES[networks.index(cell.network) % len(DASHES) if len(methods) > 1 else 0]
        many = len(networks) > 1 and cell.method != "solver"
        title = ", ".join([cell.method] * (len(methods) > 1 or len(networks) == 1) +
                          [cell.network] * many)
        shades.append(f"$band{i} using 1:3:4 with filledcurves fc rgb '{colour}' notitle")
        lines.append(f"$band{i} using 1:2 with {'lines' if len(rows) > 1 else 'points pt 7'} lw 2.2 "
                     f"dt {dash} lc rgb '{colour}' title {quoted(title)}")  # not veiled by shades
    for i, (title, rows) in enumerate(curves.items()):
        data += [f"$curve{i} << END", *("%.9g %.9g" % row for row in rows), "END"]
        lines.append(f"$curve{i} using 1:2 with linespoints lw 1.4 dt (6,4) pt "
                     f"{POINTS[i % len(POINTS)]} ps 0.9 lc rgb '{GREYS[i % len(GREYS)]}' title "
                     f"{quoted(title)}")
    plot = ", \\\n     ".join(shades + lines)
    return "\n".join(data) + f"""
set title {quoted(name)} noenhanced font ',15' offset 0,1
set label 1 {quoted(note)} at graph 0.5,1 center offset 0,0.8 noenhanced font ',10' tc rgb '#555555'
set tmargin 4.5
set key outside right top Left reverse noenhanced samplen 2.6 spacing 1.35
set style fill transparent solid 0.16 noborder

plot {plot}
""", f"""# Error against training time, by cpinn-bench.
# $band: seconds, median, smallest and largest over seeds; $curve: seconds, error.
# In this folder: gnuplot {name}.gp

set terminal svg size 860,520 dynamic font 'Helvetica,13' background rgb 'white'
set output {quoted(name + ".svg")}
set encoding utf8
set logscale xy
set format x '%h'
set format y '10^{{%T}}'
set xlabel 'run time (s)'
set ylabel {quoted(label)}
set border 3 lw 1 lc rgb '#444444'
set tics nomirror out scale 0.7
set grid xtics ytics lt 1 lw 0.6 lc rgb '#DDDDDD'

""", f"""
set terminal pngcairo size 1720,1040 fontscale 1.9 linewidth 1.9 pointscale 1.8
set output {quoted(name + ".png")}
replot
unset output
"""


def draw(folder, name):
    """Without gnuplot there is no picture, which is a remark and no failure; None: drawn."""
    by_hand = f"(cd {shlex.quote(folder)} && gnuplot {name}.gp)"
    try:
        done = subprocess.run(["gnuplot", f"./{name}.gp"], cwd=folder, stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                              errors="replace", check=False)
    except FileNotFoundError:
        return f"no picture, gnuplot is not installed; once it is: {by_hand}"
    lines = [line for line in done.stderr.splitlines() if line] or ["it says nothing"]
    line = next((line[line.index(" line ") + 1:] for line in lines if " line " in line), lines[0])
    return done.returncode and f"no picture, gnuplot failed: {line}; to see: {by_hand}" or None
