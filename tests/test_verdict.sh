#!/bin/bash
# Every reason of a verdict, provoked by a scene; exit status, --quiet, --json, and the checkpoint.
#   test_verdict.sh BIN ROOT CHECK_JSON
set -u
check_json=$(realpath "$3")
. "$(dirname "$0")/programs.sh"

# json FILE OUTCOME REASON STATUS: valid, with this verdict.
json() {
    check valid JSON -- "$check_json" "$1"
    said "$1" "\"verdict\": \{\"outcome\": \"$2\", \"reason\": \"$3\", \"text\": \"[^\"]*\", \"exit_status\": $4, "
}

# judged STATUS OUTCOME REASON COMMAND...: the same three ways, the exit status, what is printed,
# and what scripts read.
judged() {
    local status=$1 outcome=$2 reason=$3
    shift 3
    rm -rf run # of a training
    run "$status" "$@" --json report.json
    case $status in # an error is a line of its own
    0) said stdout.txt "^solved$|^note \($reason\): " ;;
    3) said stdout.txt "^warning \($reason\): " ;;
    *) check one line says why -- test "$(wc -l <stderr.txt)" -eq 1 ;;
    esac
    json report.json "$outcome" "$reason" "$status"
    if watched && [ "$status" -eq 3 ]; then # the same twice, which others do
        return
    fi
    rm -rf run
    run "$status" "$@" --json -
    json stdout.txt "$outcome" "$reason" "$status"
    rm -rf run
    run "$status" "$@" --quiet
    check quiet leaves stdout alone -- test ! -s stdout.txt
    if [ "$status" -eq 0 ]; then
        check quiet says nothing -- test ! -s stderr.txt
    else
        check quiet says why -- test -s stderr.txt
    fi
}

check the checker takes no broken JSON -- test "$(for text in '{"a": nan}' '{"a": 1,}' '{"a" 1}' \
    '{"a": 01}' '{"a": "' '{} {}' '[1]'; do
        echo "$text" >broken.json
        "$check_json" broken.json && echo taken
    done)" = ''
printf '{"a": [-1.5e-3, null, {"b": "\\u00e9\\n"}], "c": {}}\n' >good.json
check the checker takes good JSON -- "$check_json" good.json

# ---- training ---------------------------------------------------------------------------------

small=(--set 'network.hidden=[8]' --set losses.interior.points=16 --set losses.held_out_points=16
    --threads 1 --out run)
short='training.stages=[{optimizer: adam, steps: 3}]'
elastica=$ROOT/configs/elastica.yaml # linear in its network: solved in a few steps

judged 0 solved none cpinn-train "$elastica" --out run
run 0 cpinn-train "$elastica" --out run --resume --json -
json stdout.txt solved none 0 # found anew
run 0 cpinn-eval run
said stdout.txt '^verdict on training: solved$'
rm -rf run
run 3 cpinn-train "$ROOT/configs/cantilever_deep.yaml" "${small[@]}" --set "$short" --json -
said stdout.txt '"reason": "energy_out_of_balance", "outcome": "warning"'
out_of_balance='"(energy|momentum)_out_of_balance": [0-9.e+-]+'
trained=$(grep -oE "$out_of_balance" stdout.txt)
run 0 cpinn-eval run --json -
check the same two numbers again -- test "$(grep -cE . <<<"$trained")" -eq 2 -a \
    "$trained" = "$(grep -oE "$out_of_balance" stdout.txt)"
judged 3 warning not_converged cpinn-train "$ROOT/configs/elastica_deep.yaml" "${small[@]}" \
    --set "$short"
run 3 cpinn-train "$ROOT/configs/elastica_deep.yaml" "${small[@]}" --set "$short" --resume --json -
json stdout.txt warning not_converged 3
run 0 cpinn-eval run --json - # the evaluation itself went well
json stdout.txt warning not_converged 3
run 0 cpinn-eval run
said stdout.txt '^verdict on training: warning \(not_converged\): residuals'
judged 3 warning interpolates cpinn-train "$ROOT/configs/elastica_deep.yaml" "${small[@]}" \
    --set losses.interior.points=4 --set 'training.stages=[{optimizer: gauss_newton, steps: 50}]'
cat >column.yaml <<'END'
rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}
boundary: {start: {type: clamped}}
loads: {tip: {force: [0, 0, -5]}}
END
judged 3 warning unstable cpinn-train column.yaml --out run
judged 1 stopped not_finite cpinn-train "$ROOT/configs/elastica_deep.yaml" "${small[@]}" \
    --set 'training.stages=[{optimizer: adam, steps: 30, learning_rate: 1e200}]'
run 0 cpinn-eval run --json -
json stdout.txt stopped unfinished 1
judged 2 refused bad_input cpinn-train "$elastica" --set rod.length=-1
judged 2 refused bad_input cpinn-train no_such.yaml
refused 'no/report.json: no file can be written there' cpinn-train "$elastica" --json no/report.json

rm -rf run
cpinn-train "$ROOT/configs/cantilever_deep.yaml" --out run --json report.json >stdout.txt 2>&1 &
pid=$!
for _ in $(seq 2400); do # until it is in its steps, for two minutes on a busy machine
    test "$(cat run/history.csv 2>/dev/null | wc -l)" -ge 2 && break
    sleep 0.05
done
kill -TERM "$pid"
wait "$pid"
check the signal is the exit status -- test $? -eq 143
pid=
json report.json stopped signal 143
said report.json '"reason": "signal".*"reason": "unfinished"'
run 0 cpinn-eval run
said stdout.txt '^verdict on training: stopped \(unfinished\): '

# ---- solving ----------------------------------------------------------------------------------

judged 0 solved none cpinn-solve "$elastica"
judged 3 warning unstable cpinn-solve column.yaml
judged 0 solved several_equilibria cpinn-solve column.yaml --perturb 10 # buckled, and stable
judged 3 warning estimate_above_tolerance cpinn-solve column.yaml --perturb 10 --tolerance 1e-13 \
    --set 'loads.tip.force=[0, 0, -2.46741]' # so near to buckling that rounding grows
judged 3 warning unresolved cpinn-solve "$ROOT/configs/heavy_cantilever.yaml" \
    --set 'loads.force=[0, 0, "-3*step(sin(1000*s))"]'
judged 0 solved none cpinn-solve "$ROOT/configs/heavy_cantilever.yaml" \
    --tolerance 1e-13 --set 'loads.force=[0, 0, "-3*step(s-0.3333)"]'
# A hundred turns of a screw while the wave passes: steps to 1e-2 lose a quarter of the energy.
judged 3 warning energy_out_of_balance cpinn-solve "$ROOT/configs/cases/travelling_helix.yaml" \
    --tolerance 1e-2 --nodes 29
judged 1 stopped load_not_reached cpinn-solve column.yaml --out no.csv --set loads.tip=null \
    --set 'boundary.end={type: clamped, position: [0, 0, 0.6], rotation: [1, 0, 0, 0]}'
check no result -- test ! -e no.csv
judged 2 refused no_method cpinn-solve column.yaml --method collocation --set time.duration=1 \
    --set 'rod.inertia={mass_per_length: 1, rotary: [0, 0, 0]}'
judged 2 refused bad_input cpinn-solve "$elastica" --set rod.lenth=1

# The remark that a reference is too coarse leaves the status alone.
run 0 cpinn-train "$ROOT/configs/heavy_cantilever.yaml" --set reference.solve=1e-4 --out coarse \
    --json report.json
said stdout.txt '^note \(reference_too_coarse\): '
json report.json solved reference_too_coarse 0

for program in cpinn-train cpinn-solve; do
    run 0 "$program" --help
    for word in unstable energy_out_of_balance estimate_above_tolerance unresolved not_converged \
        interpolates; do
        said stdout.txt "^  $word "
    done
    said stdout.txt '^  3   warning '
done

finish
