#!/bin/bash
# The commands of the tutorial run in the order in which they stand there, and leave what it says.
#   test_tutorial.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
ln -s "$ROOT/configs" .
page=configs/tutorial/README.md

run_page $page 9
for file in found.json bent.csv loop_rod.csv arm/checkpoint.h5 rollouts/rollouts.csv loop.{csv,html} \
    arm_loop.{c,h} selftest; do
    check "$page leaves $file" -- test -s "$file"
done

# the numbers of the robot in motion are those that were found at rest, within three deviations
run 0 cpinn-solve configs/tutorial/measured.yaml
awk '$1 == "modulus" || $1 == "pitch" { print $2, $4 }' stdout.txt >found.txt
{ sed -nE 's/.*youngs_modulus: ([^,]+),.*/\1/p; ' configs/tutorial/arm.yaml
  sed -nE 's/^  pitch: ([^ ]+) .*/\1/p' configs/tutorial/arm.yaml; } | paste -d ' ' found.txt - >both.txt
check arm.yaml has what was found -- awk 'NF == 3 && ($1 - $3) ^ 2 <= 9 * $2 ^ 2 { ok++ }
    END { exit ok != 2 }' both.txt

finish
