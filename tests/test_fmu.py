"""FMUs as FMPy sees them: valid, of the standard's headers, and the same by both kinds of simulation
and from their sources.

    test_fmu.py FMU TABLE.csv [FMU TABLE.csv]...

A table is what cpinn-eval says at the FMU's places and at equal steps of time from 0 on, in
columns of the FMU's names. Exit status 77: there is no FMPy.
"""
import csv
import os
import shutil
import subprocess
import sys

try:
    import fmpy
    import numpy
    from fmpy.util import compile_platform_binary
    from fmpy.validation import validate_fmu
except ImportError as error:
    print("skipped:", error)
    sys.exit(77)

# Of the largest number of a column: the C sums in another order than cpinn-eval, and FMPy adds up
# the time of steps, so that what moves fast is off by roundings of it.
TOLERANCE = 1e-12


def read_table(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    return {name: numpy.array([float(row[k]) for row in rows[1:]]) for k, name in enumerate(rows[0])}


def compare(what, result, table):
    worst = 0
    assert (abs(result["time"] - table["t"]) <= 1e-12 * (1 + table["t"])).all(), "other times"
    for name in result.dtype.names:
        if name not in ("time", "out_of_range"):
            scale = abs(table[name]).max() or 1
            worst = max(worst, abs(result[name] - table[name]).max() / scale)
    print(f"  {what}: off by {worst:.1e}")
    assert worst <= TOLERANCE, what
    assert (result["out_of_range"] == 0).all(), "out of range"


def check(path, table):
    print(path)
    problems = validate_fmu(path)
    assert not problems, problems
    times = table["t"]
    settings = {"start_time": times[0], "stop_time": times[-1] or 1, "validate": True,
                "output_interval": times[1] - times[0] if times[-1] else 1}
    if not times[-1]:  # at rest all times are the same
        table = {name: numpy.repeat(column, 2) for name, column in table.items()}
        table["t"] = numpy.array([0, 1])
    for kind, solver in (("CoSimulation", None), ("ModelExchange", "CVode"),
                         ("ModelExchange", "Euler")):
        more = {"solver": solver} if solver else {}
        result = fmpy.simulate_fmu(path, fmi_type=kind, **settings, **more)
        compare(f"{kind} {solver or ''}", result, table)

    folder = os.path.abspath(path) + ".unpacked"
    fmpy.extract(path, folder)
    shutil.rmtree(os.path.join(folder, "binaries"))
    # by the standard's own headers, which declare every function as well
    headers = os.path.join(os.path.dirname(fmpy.__file__), "c-code")
    subprocess.run("cc -std=c99 -Wall -Wextra -Werror -fPIC -shared -DFMU_STANDARD_HEADERS "
                   f"-I'{headers}' -o standard.so sources/*.c -lm", shell=True, check=True,
                   cwd=folder)
    os.remove(os.path.join(folder, "standard.so"))
    sources_only = os.path.abspath(path) + ".sources.fmu"
    shutil.make_archive(sources_only, "zip", folder)
    os.replace(sources_only + ".zip", sources_only)
    compile_platform_binary(sources_only)
    compare("from sources", fmpy.simulate_fmu(sources_only, fmi_type="CoSimulation", **settings),
            table)


for fmu, csv_file in zip(sys.argv[1::2], sys.argv[2::2]):
    check(fmu, read_table(csv_file))
