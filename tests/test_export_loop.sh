#!/bin/bash
# Filter and controller as C: what cpinn-control --c writes compiles as C11 without a warning by gcc
# and clang, its header as C++, passes its self-test, allocates nothing, does what cpinn-control does
# on the same measurements, and is refused where it should be.
#   test_export_loop.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
cc --version >/dev/null 2>&1 || exit 77

tried= # "quickly", once gcc has been
warnings='-std=c11 -Wall -Wextra -Wpedantic -Werror'
watching

# written ARGUMENTS...: by cpinn-control, also where it warns of a model that is hardly trained, or linear.
written() {
    $tried cpinn-control "$@" >stdout.txt 2>stderr.txt
    case $? in 0 | 3) ;; *) failed "cpinn-control $*: $(cat stderr.txt)" ;; esac
    said stdout.txt '^wrote .* as C: difference from cpinn in 60 samples'
}

# exported NAME TRAINED ARGUMENTS...: a loop of the arm as C, with all checks.
exported() {
    local name=$1 trained=$2
    shift 2
    written arm.yaml --c "$name" --out "$name.csv" --set control.duration=1.5 "$@"
    check "$name by cc" -- cc $warnings -c "$name.c" -o loop.o
    check "$name allocates nothing" -- test -z "$(nm -u loop.o | grep -E 'alloc|free|printf|open')"
    check "$name has no other names" -- test -z "$(nm -g --defined-only loop.o | grep -v " ${name}_")"
    check "$name as cpinn-control" -- cc $warnings -DHEADER="\"$name.h\"" -DNAME="$name" -I. -o compare \
        "$ROOT/tests/export_loop_compare.c" loop.o -lm
    check "$name as cpinn-control" -- ./compare "$name.csv" 1e-9 >compare.txt
    check "$name with faults" -- $quick $warnings -DHEADER="\"$name.h\"" -DNAME="$name" -I. \
        -DTRAINED="$trained" -o faults "$ROOT/tests/export_loop_faults.c" "$name.c" -lm
    ./faults >faults.txt || failed "$name with faults: $(cat faults.txt)"
    check "$name for fuzzing" -- $quick $warnings $sanitizers -march=native -c "$name.c" -o watched.o
    check "$name for fuzzing" -- $quick $warnings $sanitizers -DHEADER="\"$name.h\"" -DNAME="$name" \
        -DTRAINED="$trained" -I. -o fuzz "$ROOT/tests/export_loop_fuzz.c" watched.o -lm
    ./fuzz >fuzz.txt 2>&1 || failed "$name with anything: $(head -20 fuzz.txt)"
}

cat >arm.yaml <<'YAML'
parameters: {p1: {range: [0, 8]}, p2: {range: [0, 8]}, stiffness: {range: [0.6, 1.4]}}
rod:
  model: cosserat
  length: 0.13
  section: {shape: circle, radius: 0.021}
  material: {youngs_modulus: 8.0e4*stiffness, poissons_ratio: 0.45, density: 1070, relaxation_time: 0.03}
time: {duration: 1, windows: 1}
boundary: {start: {type: clamped}}
chambers:
  - {offset: [0.013, 0], area: 1, pressure: p1}
  - {offset: [0, 0.013], area: 1, pressure: p2}
loads: {gravity: [0, 0, 9.81]}
control:
  model: linear
  task: {path: circle, radius: 0.005, frequency: 0.5, approach: 0.3}
  estimate: [stiffness]
  measurements: [{what: position, at: 0.13, noise: 2.0e-4}]
YAML

# ---- a linear model -------------------------------------------------------------------------------

exported arm 0
other='cc -O2'
tried=quickly
if clang --version >/dev/null 2>&1; then
    other='clang -O1'
    check "arm by clang" -- clang $warnings -c arm.c -o clang.o
    check "arm by clang" -- clang $warnings -o selftest clang.o arm_selftest.c -lm
    check "arm by clang" -- ./selftest >selftest.txt
fi
check "arm with sanitizers" -- $quick $warnings $sanitizers -o selftest watched.o arm_selftest.c -lm
check "arm with sanitizers" -- ./selftest >selftest.txt
if c++ --version >/dev/null 2>&1; then
    echo "#include \"arm.h\"" >header.cc
    check "arm.h in C++" -- c++ -Wall -Wextra -Wpedantic -Werror -c header.cc -o header.o
fi
said arm.h '^#define arm_CONTROLLED +2 '
said arm.h '^#define arm_PARAMETERS +1 '
said arm.h 'the place was off the path'
written arm.yaml --c other --set control.duration=1.5 --set control.constraints=[] \
    --set 'control.measurements=[{what: position, at: 0.13, noise: 2.0e-4, dropouts: 0.2}, {what: rotation, at: 0.07, noise: 0.01, every: 2, delay: 1}]'

plate_at 40 >plate.obj
if cpinn-control arm.yaml --quiet --set control.duration=0.5 --set control.tolerance.rms=1 \
    --set "control={environment: {file: $PWD/plate.obj, unit: mm, side: outside}, radius: 0.021,
        constraints: [{what: clearance, low: 0.002}]}" --c walled >stdout.txt 2>stderr.txt; then
    check "walled by cc" -- cc $warnings -c walled.c -o loop.o
    grep -q 'loop_surface_corners\[\]' walled.c || failed 'the distances are not in the C'
else
    said stderr.txt 'need Embree'
fi

# ---- trained models, one with an inner model of shorter steps among them ---------------------------------

cat >>arm.yaml <<'YAML'
surrogate: {step: 0.02, modes: [2, 1, 2, 1], inputs: [p1, p2], parameters: [stiffness], solved: 500}
network: {hidden: [8]}
training: {stages: [{optimizer: adam, steps: 5}]}
YAML
trained() { # NAME KEY=VALUE
    "$BIN/cpinn-train" arm.yaml --set "$2" --out "$1" --quiet 2>train.txt # 3: after 5 steps
    check "$1 is trained" -- test $? -eq 3
}
trained flow surrogate.kind=flow
trained polynomial surrogate.kind=polynomial
trained short surrogate.step=0.01
exported flow 1 --run flow --set control.model=surrogate
said flow.h 'median / worst of 8 rollouts:$'
said flow.h '^ [*]   its modes leave out [0-9.e-]+ / [0-9.e-]+; diverged [0-9]+\.$'
exported nodes 1 --run polynomial --set surrogate.kind=polynomial --set control.model=surrogate
exported inner 1 --run flow --inner short --set control.period=0.01 --set control.horizon=6 --set control.model=surrogate
# More tendons than numbers of the place, whose shares hardly cost: other rounding moves them, and not the place.
sed '/^chambers:/,/^loads:/d; s/^parameters:.*/parameters:/' arm.yaml | sed '/^surrogate:/,$d' | awk '
    /^parameters:/ { print; for (i = 1; i <= 6; i++) print "  p" i ": {range: [0, 8]}"; next }
    /^control:/ { print "loads: {gravity: [9.81, 0, 0]}"; print "tendons:"
        for (i = 1; i <= 6; i++) print "  - {offset: [0.013*cos(pi*" i "/3), 0.013*sin(pi*" i "/3)], tension: p" i "}" }
    { sub(/\*stiffness/, ""); if ($0 !~ /estimate:/) print }' >six.yaml
written six.yaml --c six --set control.duration=0.5 --set control.weights.rate=0.03
check "six by other rounding" -- $other -std=c11 -march=native -ffp-contract=fast -o selftest six.c six_selftest.c -lm
check "six by other rounding" -- ./selftest >selftest.txt

# ---- a damaged number is noticed --------------------------------------------------------------------

awk '!done && last ~ /^static const double loop_planned_by_state/ { sub(/[0-9]\.[0-9]/, "7.7"); done = 1 }
     { print; last = $0 }' arm.c >damaged.c
$quick -std=c11 -o selftest damaged.c arm_selftest.c -lm
./selftest >selftest.txt
check a damaged number is noticed -- test $? -eq 1
said selftest.txt '^sample [0-9]+: .* not '

# ---- refusals --------------------------------------------------------------------------------------

short=(--quiet --set control.duration=0.5)
refused 'functions cannot be called 2nd; allowed: ' cpinn-control arm.yaml --c 2nd "${short[@]}"
refused 'Loop: the C has functions of its own called Loop_' cpinn-control arm.yaml --c Loop "${short[@]}"
refused 'arm.c: there is such a file already; --force' cpinn-control arm.yaml --c arm "${short[@]}"
refused 'no_such/x.c: no file can be written there' cpinn-control arm.yaml --c no_such/x "${short[@]}"
refused 'a loop with the reduced rod is not written as C; allowed: ' \
    cpinn-control arm.yaml --c x "${short[@]}" --set control.model=reduced

finish
