#!/bin/bash
# Programs whose memory, files or disks fail: one line on stderr and the exit status of what failed,
# or the same answer; and whatever is left of a run can be resumed to the same bits.
#   test_faults.sh BIN ROOT SHIM          some of the calls, for the tests
#   test_faults.sh BIN ROOT SHIM all      every call that can fail; hours
#   test_faults.sh BIN ROOT SHIM kills N  a run that is killed N times at random moments
set -u
shim=$(realpath "$3")
. "$(dirname "$0")/programs.sh"
mode=${4:-some}

scene=(--set 'network.hidden=[4]' --set losses.interior.points=16 --set losses.held_out_points=8
    --set 'training.stages=[{optimizer: adam, steps: 40}, {optimizer: lbfgs, steps: 40}]'
    --set checkpoint.every=10 --set output.every=10 --threads 1)
train=(cpinn-train "$elastica" "${scene[@]}")
run 3 "${train[@]}" --out whole
run 0 cpinn-eval whole --grid 9 --out whole.csv
cat >scene.yaml <<'END'
rod: {model: kirchhoff, length: 0.3, stiffness: {bending: [0.02, 0.02], torsion: 0.02}}
boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}
loads: {units: EI, tip: {force: [0, 0, -1]}}
network: {hidden: [4]}
losses: {interior: {points: 16}, held_out_points: 8}
training: {stages: [{optimizer: adam, steps: 2}]}
reference: {analytic: elastica}
END
cat >fit.yaml <<'END'
equations: {coordinates: {x: {range: [0, 1]}}, fields: [u], inside: [u_x + u], conditions: [{at: {x: 0}, u: 1}]}
END
awk 'BEGIN { print "u1,m1"; for (i = 1; i <= 12; i++) printf "%g,%g\n", i / 100, i + i^3 / 40 }' >law.csv
arm=$ROOT/configs/robots/soft_arm_control.yaml
loop="$arm --set control.model=reduced --set control.plant.modes=[1,1,1,1] --set control.duration=1.1
    --set control.estimate=null --set control.plant.set=null --set surrogate.modes=[1,1,1,1]
    --set control.tolerance.rms=1 --set control.tolerance.worst=1 --quiet"
run 0 cpinn-control $loop --out loop.csv

# Of each program, what is quick.
programs=('cpinn-train scene.yaml --out new --threads 1'
    'cpinn-eval whole --grid 9 --out new.csv' 'cpinn-eval whole --json -'
    'cpinn-solve scene.yaml --nodes 20 --out new.h5' 'cpinn-solve scene.yaml --path new.csv'
    'cpinn-check scene.yaml --threads 1' 'cpinn-export whole --c new'
    'cpinn-show whole --out new.html'
    'cpinn-fit fit.yaml --out new.csv --save new.h5 --threads 1'
    'cpinn-law law.csv --out new.csv --steps 2 --starts 1 --units 2' "cpinn-control $loop --json new.json"
    "cpinn-residual $arm --measured loop.csv --steps 1 --units 2 --out new.h5")

# faulty KIND N COMMAND...: with the N-th call failing, it has to end as promised.
faulty() {
    local kind=$1 nth=$2 got=0 lines
    shift 2
    rm -rf new*
    timeout 60 env CPINN_FAULT="$kind $nth" LD_PRELOAD="$shim" "$@" >stdout.txt 2>stderr.txt \
        </dev/null || got=$?
    lines=$(grep -vc ': warning: ' stderr.txt)
    # While OpenBLAS is loaded it is libgfortran that ends the process, in two lines of its own.
    grep -q '^Memory allocation failed\|^Error allocating\|^Allocating cleared memory' stderr.txt && return
    case $kind in
    allocate | write | fsync | rename | ftruncate)
        [ "$got" -ne 2 ] || failed "exit 2 with $kind $nth failing: $*: $(head -c 200 stderr.txt)"
        ;;
    esac
    [ "$got" -le 3 ] || failed "exit $got with $kind $nth failing: $*: $(head -c 200 stderr.txt)"
    [ "$lines" -le 1 ] && [ -s stdout.txt -o "$lines" -eq 1 -o "$got" -eq 0 ] ||
        failed "$lines lines with $kind $nth failing: $*: $(head -c 200 stderr.txt)"
    [ -z "$(find . -name '*.partial')" ] || failed "partial files with $kind $nth failing: $*"
}

# all_faults COMMAND...: each kind of call; `some`: the first, and then ever fewer.
all_faults() {
    local kind count nth got=0
    rm -rf new*
    rm -f counts.txt
    CPINN_FAULT_COUNTS=counts.txt LD_PRELOAD=$shim "$@" >stdout.txt 2>stderr.txt </dev/null || got=$?
    [ "$got" -eq 0 -o "$got" -eq 3 ] || failed "exit $got without a fault: $*: $(cat stderr.txt)"
    while read -r kind count; do
        nth=1
        while [ "$nth" -le "$count" ]; do
            faulty "$kind" "$nth" "$@"
            if [ "$mode" = all ]; then
                nth=$((nth + 1))
            elif [ "$kind" = allocate ]; then
                nth=$((nth * 3 + 2))
            else
                nth=$((nth * 2))
            fi
        done
    done <counts.txt
}

# A run that a failing disk has ended is continued, or begun if nothing was saved yet.
continued() {
    local option=
    test -e broken/checkpoint.h5 && option=--resume
    run 3 "${train[@]}" --out broken $option
    run 0 cpinn-eval broken --grid 9 --out broken.csv
    same broken.csv whole.csv
}

if [ "$mode" = kills ]; then
    for ((kill = 1; kill <= ${5:-100}; kill++)); do
        option=
        test -e broken/checkpoint.h5 && option=--resume
        "${train[@]}" --out broken $option >/dev/null 2>&1 </dev/null &
        pid=$!
        sleep "0.0$((RANDOM % 9))$((RANDOM % 10))"
        kill -9 $pid 2>/dev/null
        wait $pid 2>/dev/null
        pid=
        if ((kill % 10 == 0)); then
            continued
            rm -rf broken
        fi
    done
    finish
fi

for program in "${programs[@]}"; do
    all_faults $program
done
for nth in 1444 2110 2517 2961 3257 3294 3331; do # while the scene is read, and that of the plant
    faulty allocate $nth cpinn-control $loop --json new.json
done
for fault in 'write 3' 'write 7' 'fsync 2' 'fsync 5' 'rename 1' 'rename 4' 'mkdir 1' 'open 9' \
    'ftruncate 3' 'allocate 9000'; do
    rm -rf broken
    CPINN_FAULT=$fault LD_PRELOAD=$shim "${train[@]}" --out broken >stdout.txt 2>stderr.txt </dev/null
    continued
done

# A disk that is full, and one that cannot be written, where this user may mount one.
mkdir disk
if mount -t tmpfs -o size=64k none disk 2>/dev/null; then
    trap 'umount "$work/disk" 2>/dev/null; rm -rf "$work"' EXIT
    run 1 "${train[@]}" --out disk/run --set checkpoint.every=1
    check one line of a full disk -- test "$(wc -l <stderr.txt)" -eq 1
    said stderr.txt 'No space left on device'
    run 1 cpinn-eval whole --grid 4001 --out disk/new.csv
    said stderr.txt 'No space left on device'
    [ -z "$(find disk -name '*.partial')" ] || failed "partial files on a full disk"
    mount -o remount,ro disk
    refused 'Read-only file system' cpinn-eval whole --grid 9 --out disk/new.csv
    refused 'Read-only file system' "${train[@]}" --out disk/other
    umount disk
else
    echo "skipped: a full disk and one that cannot be written, for want of the right to mount"
fi
finish
