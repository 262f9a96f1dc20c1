#!/bin/bash
# FMUs of trained networks: the same as cpinn-eval, what is refused, and FMPy on them.
#   test_fmu.sh BIN ROOT DRIVE alone|fmpy
# CPINN_PYTHON: the Python that has FMPy, else python3.
set -u
. "$(dirname "$0")/programs.sh"
drive=$3
python=${CPINN_PYTHON:-python3}
if [ "$4" = fmpy ] && ! "$python" -c 'import fmpy' 2>/dev/null; then
    echo "skipped: $python has no FMPy"
    exit 77
fi

small=(--set 'network.hidden=[8]' --set losses.interior.points=16 --set losses.held_out_points=16
    --set 'training.stages=[{optimizer: adam, steps: 30}, {optimizer: lbfgs, steps: 20}]' --quiet)
run 3 cpinn-train "$elastica" "${small[@]}" --out rest
run 3 cpinn-train "$dynamic" "${small[@]}" --out motion
run 0 cpinn-export rest --fmu resting.fmu
run 0 cpinn-export motion --fmu moving # with the ending or without
said stdout.txt '^wrote moving.fmu: 2 inputs, 25 outputs, '
if ! command -v cc >/dev/null; then
    echo "skipped: no compiler"
    exit 77
fi

if [ "$4" = fmpy ]; then
    run 0 cpinn-export motion --fmu three --places 0.25,0.5,1 --columns 'r q m2 x_t'
    # x, y, ... at one place and times from 0 on: as the FMU has them
    awk 'BEGIN { print "s,t"; for (i = 0; i <= 20; i++) print "1," i / 20 }' >tip.csv
    run 0 cpinn-eval motion --points tip.csv --out moving.csv
    echo 's
0.3' >end.csv
    run 0 cpinn-eval rest --points end.csv --out at_end.csv
    awk -F, -v OFS=, 'NR == 1 || NR == 2' at_end.csv >resting.csv
    "$python" "$ROOT/tests/test_fmu.py" moving.fmu moving.csv resting.fmu resting.csv || exit 1
    "$python" -c 'from fmpy.validation import validate_fmu as v; assert not v("three.fmu")' ||
        failed "three places are not valid"
    finish
    exit
fi

# ---- as cpinn-eval ------------------------------------------------------------------------------

for case in rest:resting:11 motion:moving:5x4; do
    IFS=: read -r folder name grid <<<"$case"
    run 0 cpinn-eval "$folder" --grid "$grid" --out "$folder.csv"
    mkdir "$name.folder"
    (cd "$name.folder" && cmake -E tar xf "../$name.fmu") || failed "$name.fmu cannot be unpacked"
    run 0 "$drive" "$name.folder"/binaries/*/"$name.so" "$name.folder/modelDescription.xml" \
        "$folder.csv"
    grep 'points,' stdout.txt
done

run 0 env PATH="$BIN" cpinn-export motion --fmu bare --columns x
said stderr.txt '^cpinn-export: warning: bare.fmu has sources only: there is no compiler, cc$'
check no library is in it -- test "$(cmake -E tar tf bare.fmu | grep -c binaries)" = 0

# ---- refusals -----------------------------------------------------------------------------------

before=$(cksum <moving.fmu)
refused 'moving.fmu: there is such a file already; --force' cpinn-export motion --fmu moving.fmu
refused '--fmu 2.fmu: functions cannot be called 2;' cpinn-export motion --fmu 2.fmu
refused 'give --c OUT or --fmu OUT' cpinn-export motion
refused '--c and --fmu are given' cpinn-export motion --fmu a --c a
refused '--single is for --c alone' cpinn-export motion --fmu a --single
refused '--places is for --fmu and for families' cpinn-export motion --c a --places 1
refused 'place 1.5 m is outside the model; allowed: 0 to 1 m' \
    cpinn-export motion --fmu a --places 0.5,1.5
for wrong in '' , 0.5, a 0.5:1 nan; do
    refused '--places .*: allowed: 1 to 64 arc lengths' cpinn-export motion --fmu a "--places=$wrong"
done
refused 'nowhere/a.fmu: no file can be written there' cpinn-export motion --fmu nowhere/a
check a refusal changes nothing -- test "$before" = "$(cksum <moving.fmu)"
run 0 cpinn-export motion --fmu moving --columns x --force
check another file is there now -- test "$before" != "$(cksum <moving.fmu)"
finish
