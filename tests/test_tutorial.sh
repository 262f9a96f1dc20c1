#!/bin/bash
# The commands and programs of a page of the tutorial run in the order in which they stand there, and
# leave what it says.
#   test_tutorial.sh BIN ROOT robot|equations|fit|python
set -u
. "$(dirname "$0")/programs.sh"
mkdir home
export HOME=$work/home # where the pages install
ln -s "$ROOT/configs" "$ROOT/tests" .
ln -s "$BIN/.." build

# leaves PAGE FILE...
leaves() {
    local page=$1 file
    shift
    for file in "$@"; do
        check "$page leaves $file" -- test -s "$file"
    done
}

robot() {
    local page=configs/tutorial/README.md
    run_page $page 9
    leaves $page found.json bent.csv loop_rod.csv arm/checkpoint.h5 rollouts/rollouts.csv \
        loop.{csv,html} arm_loop.{c,h} selftest

    # the numbers of the robot in motion are those that were found at rest, within three deviations
    run 0 cpinn-solve configs/tutorial/measured.yaml
    awk '$1 == "modulus" || $1 == "pitch" { print $2, $4 }' stdout.txt >found.txt
    { sed -nE 's/.*youngs_modulus: ([^,]+),.*/\1/p; ' configs/tutorial/arm.yaml
      sed -nE 's/^  pitch: ([^ ]+) .*/\1/p' configs/tutorial/arm.yaml; } | paste -d ' ' found.txt - \
        >both.txt
    check arm.yaml has what was found -- awk 'NF == 3 && ($1 - $3) ^ 2 <= 9 * $2 ^ 2 { ok++ }
        END { exit ok != 2 }' both.txt
}

# Its programs compare with closed forms themselves.
equations() {
    local page=configs/tutorial/equations.md
    run_page $page 18
    leaves $page wire_run/checkpoint.h5 wire_exact/history.csv wire_network.c
    . ./page.env
    check a run goes on where it stopped -- awk -F, '$1 == "" { exit 1 } END { exit NR < 6 }' \
        wire_run/history.csv
    run 2 ./wire nonsense
    run 0 ./front
    said stdout.txt 'residuals are still large .*cpinn_fit_equations or patches_fit'
    run 1 ./wire train # over the run that is there
    said stderr.txt 'wire_run: there is a run already'
}

# Three forms of the same equation have the same solution.
fit() {
    local page=configs/tutorial/fit.md
    run_page $page 10
    leaves $page u.csv u.csv.svg u.h5 all.csv burgers.py burgers.c
    . ./page.env
    run 0 ./burgers
    sed 's/.* = //' stdout.txt >in_c.txt
    run 0 python3 burgers.py
    sed 's/].*//' stdout.txt | paste -d ' ' in_c.txt - >both.txt
    check C and Python have the same solution -- awk '{ off = $1 - $NF; exit !($1 < -0.1 && off ^ 2 < 1e-12) }' both.txt
}

python() {
    python3 -c 'import numpy' 2>/dev/null || exit 77
    local page=configs/tutorial/python.md
    run_page $page 5
    said stdout.txt '^modulus = 260208 '
    said stdout.txt '^1000 of 1000 solved'
    leaves $page arm_run/checkpoint.h5 family_run/history.csv
}

"$3"
finish
