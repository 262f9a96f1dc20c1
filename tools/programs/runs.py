# What programs in Python share that run other programs of this folder. The build puts it into each.
import argparse
import json
import math
import os
import re
import signal
import subprocess
import sys
import time

GRACE = 20  # s beyond the limit, for a last step and what is written
PROCESSES = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"]  # of mpirun and srun

running, stopped = set(), []  # processes at work; signals


def fail(text, status=2):
    print(f"{PROGRAM}: {text}", file=sys.stderr)
    sys.exit(status)


class Parser(argparse.ArgumentParser):
    def __init__(self):
        super().__init__(prog=PROGRAM, add_help=False, allow_abbrev=False)

    def error(self, message):
        for pattern, text in ((r"argument (--\w+): (.*: allowed)", r"\1 \2"), ("argument ", ""),
                              ("expected one argument", "a value is missing"),
                              (r"the following arguments are required: (.*)", r"\1 is missing"),
                              ("unrecognized arguments:", "unknown option")):
            message = re.sub(pattern, text, message)
        fail(message)


def number(of, least, words, most=math.inf):
    def read(text):
        try:
            value = of(text)
        except ValueError:
            value = math.nan
        if not least <= value <= most or value == math.inf:
            raise argparse.ArgumentTypeError(f"{text}: allowed: {words}")
        return value
    return read


SECONDS = number(float, 1e-9, "a number > 0")
THREADS = number(int, 0, "an integer, 0 to 4096", 4096)


def place_of(program):
    return os.path.join(os.path.dirname(os.path.realpath(__file__)), program)


def run(limit, program, *arguments):
    """What the program says by --json, {} if nothing; its exit status; s; whether its time was up.

    A training that is told to stop says how far it has come, and a solver says nothing."""
    began = time.monotonic()
    process = subprocess.Popen([place_of(program), *arguments, "--json", "-"],
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.DEVNULL)
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


def covers(said):
    """Whether all windows of time are there."""
    return said.get("window", 0) + 1 >= said.get("windows", 1)


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


def seconds_text(seconds):
    digits = next((d for most, d in ((0.00095, 4), (0.0995, 3), (9.995, 2), (99.95, 1))
                   if seconds < most), 0)
    return f"{seconds:.{digits}f}" if math.isfinite(seconds) else "-"


def error_text(value):
    return f"{value:.1e}" if value is not None and math.isfinite(value) else "-"


def stop(number_, _frame):
    stopped.append(number_)
    for process in list(running):
        process.terminate()


def alone(remedy):
    if any(os.environ.get(name, "1") not in ("", "1") for name in PROCESSES):
        fail(f"does not share its work among processes: start it without mpirun or srun{remedy}")


def start(main, help_text):
    try:
        for option, text in ("--help", help_text), ("--version", lambda: f"{PROGRAM} {VERSION}\n"):
            if option in sys.argv[1:]:  # argparse would not say that it cannot be written
                print(text(), end="", flush=True)
                return 0
        for number_ in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number_, stop)
        status = main()
        sys.stdout.flush()
        return status
    except OSError as error:
        print(f"{PROGRAM}: what it prints could not be written: {error.strerror}", file=sys.stderr)
        os._exit(1)  # or Python would try once more
