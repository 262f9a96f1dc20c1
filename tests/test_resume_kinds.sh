#!/bin/bash
# Training of every kind is killed at its beginning, early and late, and goes on to the same bits:
# the checkpoint at the end, with the state of the optimiser and of every generator, and the history
# are those of the run that was never killed.
#   test_resume_kinds.sh BIN ROOT SHIM COMPARE        some of the kinds, for the tests
#   test_resume_kinds.sh BIN ROOT SHIM COMPARE all    all of them, at every step; twenty minutes
#   test_resume_kinds.sh BIN ROOT SHIM COMPARE NAME   those whose name begins so
set -u
shim=$(realpath "$3") compare=$(realpath "$4")
. "$(dirname "$0")/programs.sh"
mode=${5:-some}
kills=0 kinds=0

# Whether a kind is asked for: `quick` or `long` says whether it is one of some.
asked() {
    [ "$mode" = all ] || { [ "$mode" = some ] && [ "$1" = quick ]; } || [[ "$2" == "$mode"* ]]
}

# counted COMMAND...: runs it; leaves how often it has put a file in place.
counted() {
    got=0
    CPINN_FAULT_COUNTS=counts.txt LD_PRELOAD=$shim "$@" >stdout.txt 2>stderr.txt </dev/null || got=$?
    renames=$(awk '$1 == "rename" { print $2 }' counts.txt)
}

# killed NTH COMMAND...: killed when it is about to put the NTH file in place.
killed() {
    local nth=$1 status=0
    shift
    CPINN_FAULT="rename $nth!" LD_PRELOAD=$shim "$@" >stdout.txt 2>stderr.txt </dev/null &
    wait $! 2>/dev/null || status=$?
    [ "$status" -eq 137 ] || failed "exit $status, not killed at rename $nth: $*"
    kills=$((kills + 1))
}

# The histories of whole and part, but for the time.
same_rows() {
    local folder
    for folder in whole part; do
        awk -F, -v OFS=, 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == "seconds") s = i }
            { $s = ""; print }' $folder/history.csv >$folder.history
    done
    cmp -s whole.history part.history || failed "$name: other rows of history"
}

# kind WHEN NAME SCENE OPTIONS...: a new run puts three files in place (checkpoint of step 0,
# config, history) and then its checkpoints, one that is resumed two before them (config, history).
# Killed where the next would be put in place, it loses the steps since the last one. `some`: from
# the checkpoint of step 0, from that after, from the last but one; else from every step.
kind() {
    local when=$1 name=$2 left saved every=1
    shift 2
    asked "$when" "$name" || return
    kinds=$((kinds + 1))
    [ "$mode" != some ] || every=2
    local train=(cpinn-train "$@" --set checkpoint.every=$every --set checkpoint.keep=1
        --set checkpoint.seconds=1000 --set output.every=1 --threads 1)
    rm -rf whole part
    counted "${train[@]}" --out whole
    [ "$got" -eq 0 -o "$got" -eq 3 ] || { failed "$name: exit $got: $(head -1 stderr.txt)"; return; }
    left=$((renames - 3))
    [ "$mode" = some ] || killed 1 "${train[@]}" --out part # nothing is there yet
    killed $((left > 0 ? 4 : 2)) "${train[@]}" --out part
    while [ "$left" -gt 1 ]; do
        saved=1
        [ "$mode" != some ] || [ "$left" -eq $((renames - 3)) ] || saved=$((left - 1))
        killed $((3 + saved)) "${train[@]}" --out part --resume
        left=$((left - saved))
    done
    run "$got" "${train[@]}" --out part --resume
    said stdout.txt 'resumed at step'
    "$compare" whole/checkpoint.h5 part/checkpoint.h5 >difference.txt ||
        failed "$name: $(cat difference.txt)"
    same_rows
    [ "$mode" = some ] ||
        echo "$name: $((renames - 3)) checkpoints, the last $(grep -o 'resumed at step [0-9]*' stdout.txt)"
}

# fit NAME FILE COMMAND...: a program that keeps nothing before its end: killed, it leaves nothing
# or what was there, and makes the same when it is begun anew.
fit() {
    local name=$1 file=$2
    shift 2
    asked long "$name" || return
    kinds=$((kinds + 1))
    rm -f "$file"
    counted "$@"
    [ "$got" -eq 0 ] || { failed "$name: exit $got: $(head -1 stderr.txt)"; return; }
    mv "$file" whole.fit
    killed "$renames" "$@"
    check nothing half written -- test ! -e "$file"
    echo before >"$file"
    killed "$renames" "$@"
    check what was there -- grep -q before "$file"
    run 0 "$@"
    same "$file" whole.fit
}

# descents WHEN NAME FILE COMMAND...: a fit by least squares that keeps its run, killed where its
# first checkpoints would be put in place, with the next, and before its result; one that asks for
# something else is refused.
descents() {
    local when=$1 name=$2 file=$3
    shift 3
    asked "$when" "$name" || return
    kinds=$((kinds + 1))
    rm -rf whole part "$file"
    counted "$@" --run whole
    [ "$got" -eq 0 ] || { failed "$name: exit $got: $(head -1 stderr.txt)"; return; }
    check "$name saves on the way" -- test "$renames" -gt 4
    [ ! -e "$file" ] || mv "$file" whole.fit
    killed 4 "$@" --run part
    killed 4 "$@" --run part --resume
    run 0 "$@" --run part --resume
    [ ! -e whole.fit ] || same "$file" whole.fit
    "$compare" whole/checkpoint.h5 part/checkpoint.h5 >difference.txt ||
        failed "$name: $(cat difference.txt)"
    same_rows
    run 0 "$@" --run part --resume # it is over
    run 2 "$@" --run part
    said stderr.txt 'there is a run already'
    rm -f whole.fit
}

# stages METHOD [MORE]: of a few steps.
stages() {
    echo "training.stages=[{optimizer: $1, steps: ${3:-9}${2:+, $2}}]"
}

small=(--set losses.interior.points=40 --set losses.held_out_points=16)
deep=("${small[@]}" --set 'network.hidden=[6, 6]')
methods=$(optimizers)

# ---- one scene at rest --------------------------------------------------------------------------

cat >rest.yaml <<'END'
rod: {model: kirchhoff, length: 0.3, stiffness: {bending: [0.02, 0.03], torsion: 0.02}}
boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}
loads: {units: EI, tip: {force: [0, 0.5, -1]}}
END
for method in $methods; do
    kind long rest_$method rest.yaml "${deep[@]}" --set "$(stages $method)"
done
for algebra in normal_equations kernel matrix_free; do
    kind long rest_$algebra rest.yaml "${deep[@]}" \
        --set "$(stages gauss_newton "linear_algebra: $algebra")"
done
kind long rest_linear rest.yaml "${small[@]}"
kind long rest_in_parts rest.yaml --set 'loads.tip.force=[0, 3, -12]'
for formulation in displacement pose_strain; do
    kind long rest_$formulation rest.yaml "${deep[@]}" --set formulation=$formulation \
        --set rod.model=cosserat --set 'rod.stiffness.shear=[20, 20]' --set rod.stiffness.axial=50 \
        --set "$(stages adam)"
done
for adaptive in rad rar_g gaussian; do
    kind long rest_$adaptive rest.yaml "${deep[@]}" --set "$(stages adam)" \
        --set "losses.interior.adaptive={kind: $adaptive, every: 3}"
done
kind quick rest_resampled rest.yaml "${deep[@]}" --set enforcement.boundary=soft \
    --set losses.interior.resample_every=3 --set losses.interior.sampler=uniform \
    --set "training.stages=[{optimizer: adam, steps: 5}, {optimizer: lbfgs, steps: 5}]"
kind long rest_balanced rest.yaml "${deep[@]}" --set losses.balance=gradient_norm \
    --set losses.balance_every=3 --set "$(stages soap)"
kind long rest_tubes "$ROOT/configs/robots/concentric.yaml" --set reference=null "${small[@]}"
kind long rest_tendons "$ROOT/configs/robots/tendon_two_segments.yaml" --set reference=null \
    "${deep[@]}" --set "$(stages ssbroyden)"
kind long beam "$ROOT/configs/beam_cantilever.yaml" --set reference=null "${deep[@]}" \
    --set "$(stages lbfgs)"
kind long law "$ROOT/configs/law/stretched.yaml" --set reference=null "${small[@]}"
kind quick identified "$ROOT/configs/identify/bent.yaml"
kind long identified_deep "$ROOT/configs/identify/bent.yaml" "${deep[@]}" \
    --set "training.stages=[{optimizer: adam, steps: 6}, {optimizer: gauss_newton, steps: 6}]"

# ---- one scene in motion ------------------------------------------------------------------------

cat >motion.yaml <<'END'
rod:
  model: cosserat
  length: 1
  stiffness: {shear: [545, 545], axial: 1600, bending: [1, 1], torsion: 0.77}
  inertia: {mass_per_length: 1, rotary: [0.000625, 0.000625, 0.00125]}
time: {duration: 0.3}
boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}
loads: {tip: {force: [0, 0, "-where(0.25-t, sin(2*pi*t)^2, 1)"]}}
END
kind long motion_modes motion.yaml --set 'network.modes=[3, 0, 2, 2]'
kind long motion_modes_windows motion.yaml --set 'network.modes=[2, 0, 1, 1]' --set time.windows=3
kind long motion_modes_grown motion.yaml --set network.tolerance=0.01
mixed=(--set formulation=mixed --set time.windows=1)
kind long motion_mixed motion.yaml "${mixed[@]}" "${small[@]}"
for method in $methods; do
    kind long motion_$method motion.yaml "${mixed[@]}" "${deep[@]}" --set "$(stages $method '' 7)"
done
kind long motion_causal motion.yaml "${mixed[@]}" "${deep[@]}" --set losses.causal.slices=3 \
    --set losses.causal.update_every=2 --set enforcement.initial=soft \
    --set losses.initial.resample_every=2 --set "$(stages adam)"
windows=(--set formulation=mixed --set time.windows=3)
kind long windows_linear motion.yaml "${windows[@]}" "${small[@]}"
kind quick windows_deep motion.yaml "${windows[@]}" "${deep[@]}" \
    --set "training.stages=[{optimizer: adam, steps: 3}, {optimizer: lbfgs, steps: 3}]"
kind long windows_beam "$ROOT/configs/beam_vibration.yaml" --set reference=null "${small[@]}"

# ---- families -----------------------------------------------------------------------------------

cat >family.yaml <<'END'
parameters:
  pull: {range: [0, 2]}
  push: {range: [-0.06, 0.06]}
  stiff: {range: [0.7, 1.4], scale: log}
rod: {model: kirchhoff, length: 0.3, stiffness: {bending: [0.05*stiff, 0.05*stiff], torsion: 0.04}}
loads: {gravity: null, tip: {force: [push, 0, -pull/10]}}
tendons: [{offset: [0.006, 0], tension: pull}]
END
awk 'BEGIN { print "pull,push,stiff"
    for (i = 0; i < 60; i++) printf "%g,%g,%g\n", i % 7 / 3.5, (i % 11 - 5) / 100, 0.8 + i % 5 / 10 }' \
    >members.csv
drawn=(--set members.solved=256)
batch=(--set losses.interior.points=32 --set losses.held_out_points=16)
for method in $methods; do
    for targets in solved physics both; do
        when=long
        case $method-$targets in
        lbfgs-solved | soap-both) when=quick ;;
        *-solved) ;;
        *) # refused: others need the same members in every step
            optimizers learning_rate | grep -qx "$method" || continue ;;
        esac
        kind $when family_${method}_$targets family.yaml "${drawn[@]}" "${batch[@]}" \
            --set 'network.hidden=[8, 8]' --set "$(stages $method "targets: $targets")"
    done
done
kind long family_stages family.yaml "${drawn[@]}" "${batch[@]}" --set 'network.hidden=[8, 8]' \
    --set losses.interior.sampler=uniform --set losses.interior.resample_every=3 \
    --set 'training.stages=[{optimizer: soap, steps: 5}, {optimizer: adam, steps: 5, targets: physics}]'
kind quick family_polynomial family.yaml "${drawn[@]}" "${batch[@]}" \
    --set network.polynomial.degree=2 --set network.hidden=[]
for algebra in normal_equations separate; do
    kind long family_polynomial_$algebra family.yaml "${drawn[@]}" \
        --set network.polynomial.degree=2 --set network.hidden=[] \
        --set "$(stages gauss_newton "linear_algebra: $algebra, function_tolerance: 0" 5)"
done
kind long family_polynomial_lbfgs family.yaml "${drawn[@]}" "${batch[@]}" \
    --set network.polynomial.degree=2 --set network.hidden=[] --set "$(stages lbfgs)"
kind long family_file family.yaml --set 'members={solved: 0, file: members.csv}' \
    --set network.polynomial.degree=2 --set network.hidden=[]
kind long family_file_deep family.yaml --set 'members={solved: 0, file: members.csv}' "${batch[@]}" \
    --set 'network.hidden=[8]' --set "$(stages soap)"
kind long family_parameters family.yaml "${drawn[@]}" "${batch[@]}" --set network.inputs=parameters \
    --set 'network.hidden=[8]' --set "$(stages lbfgs)"
family=("$ROOT/configs/families/cantilever.yaml" --set reference=null)
kind long family_mixed "${family[@]}" "${small[@]}"
for method in $methods; do
    kind long family_mixed_$method "${family[@]}" "${deep[@]}" --set "$(stages $method)"
done
kind long family_mixed_adaptive "${family[@]}" "${deep[@]}" --set "$(stages adam)" \
    --set 'losses.interior.adaptive={kind: rad, every: 3}'
ramp=("$ROOT/configs/families/ramp.yaml" --set reference=null --set time.duration=0.1
    --set time.windows=2)
kind long family_motion "${ramp[@]}" --set losses.interior.points=300 \
    --set network.fourier.features=40 --set "$(stages gauss_newton '' 5)"
kind long family_motion_deep "${ramp[@]}" "${deep[@]}" --set "$(stages adam '' 4)" \
    --set time.windows=1

# ---- one-step models ----------------------------------------------------------------------------

arm=("$ROOT/configs/robots/soft_arm_control.yaml" --set 'surrogate.modes=[1, 0, 1, 0]'
    --set surrogate.solved=500 --set 'network.hidden=[6]')
for step in flow linear polynomial; do
    methods=$(optimizers | grep -vxF "$(optimizers initial_damping)")
    [ $step != linear ] || methods=lbfgs
    for method in $methods; do
        kind long step_${step}_$method "${arm[@]}" --set surrogate.kind=$step \
            --set "$(stages $method)"
    done
done
kind long step_stages "${arm[@]}" --set surrogate.kind=polynomial \
    --set "training.stages=[{optimizer: adam, steps: 5}, {optimizer: lbfgs, steps: 5}]"
kind long step_ramp "${arm[@]}" --set surrogate.hold=linear --set "$(stages ssbroyden)"

# ---- laws and residuals -------------------------------------------------------------------------

fit fit_law fit_law.csv cpinn-law "$ROOT/configs/law/neo_hooke_data.csv" --steps 3 --starts 1 \
    --units 3 --out fit_law.csv
if asked long fit_residual || asked long fit_residual_run; then
    loop="$ROOT/configs/robots/soft_arm_control.yaml --set control.model=reduced
        --set control.plant.modes=[1,1,1,1] --set control.duration=1.1 --set control.estimate=null
        --set control.tolerance.rms=1 --set control.tolerance.worst=1 --quiet"
    run 3 cpinn-control $loop --out loop.csv # the model is off, and that is said
fi
descents quick fit_law_run law_run.csv cpinn-law "$ROOT/configs/law/neo_hooke_data.csv" --steps 80 \
    --starts 2 --units 3 --out law_run.csv
for known in stiffness:quick swinging:long; do
    descents ${known#*:} fit_unknowns_${known%:*} none cpinn-solve \
        "$ROOT/configs/identify/${known%:*}.yaml" --threads 1
done
descents long fit_residual_rest rest_run.h5 cpinn-residual "$ROOT/configs/identify/residual.yaml" \
    --set 'residual.hidden=[4]' --threads 1 --out rest_run.h5
fit fit_residual fit_residual.h5 cpinn-residual "$ROOT/configs/robots/soft_arm_control.yaml" \
    --measured loop.csv --steps 2 --units 2 --out fit_residual.h5
descents long fit_residual_run residual_run.h5 cpinn-residual \
    "$ROOT/configs/robots/soft_arm_control.yaml" --measured loop.csv --steps 60 --units 2 \
    --out residual_run.h5

echo "$kinds kinds, $kills kills"
[ "$mode" != all ] || check kills -- test "$kills" -ge 60
finish
