#!/bin/bash
# What cpinn-solve says, writes and refuses.
#   test_solve.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
heavy=$ROOT/configs/heavy_cantilever.yaml

# falls SCENE FEW MANY LARGE SMALL: the error is at least LARGE with few nodes, at most SMALL with many.
falls() {
    local nodes
    for nodes in "$2" "$3"; do
        cpinn-solve "$1" --nodes "$nodes" --tolerance 1e-12 2>&1 | sed -n 's/^ *position, relative L2 *//p'
    done >errors.txt
    check "the error of $1 falls to rounding" -- awk -v large="$4" -v small="$5" 'NR == 1 { first = $1 }
        { last = $1 } END { exit !(NR == 2 && first > large && last < small) }' errors.txt
}

# ---- a solution -------------------------------------------------------------------------------

run 0 cpinn-solve "$elastica"
said stdout.txt '^elastica_deep: static, .*tip force F L\^2/EI 1$'
said stdout.txt '^solved: [0-9]+ nodes, load in [0-9]+ steps?, [0-9]+ Newton steps, [0-9.]+ ms$'
said stdout.txt 'estimated error +[0-9.]+e-1[0-9] of the length'
said stdout.txt '^  loads out of balance +[0-9.]+e(-1[4-9]|-[2-9][0-9]|\+00)$'
said stdout.txt '^  tip +0\.28307002911498[0-9]* '
said stdout.txt '^  energy +strain 0\.0002347[0-9]*, potential of loads -0\.000493[0-9]* J$'
said stdout.txt '^difference from elastica \(101 points\)'
said stdout.txt 'position, largest +[0-9.]+e-1[2-9] of the length'
check nothing on stderr -- test ! -s stderr.txt
run 0 cpinn-solve "$heavy" --nodes 8 --quiet
check quiet says nothing -- test ! -s stdout.txt -a ! -s stderr.txt
run 0 cpinn-solve "$heavy" --nodes 8
said stdout.txt '^solved: 8 nodes'
run 0 cpinn-solve "$heavy" --set 'loads.gravity=[0, 0, -98.1]' --set reference.file=null
check no reference, no difference -- test "$(grep -c difference stdout.txt)" -eq 0

refused '^cpinn-solve: --method stress; allowed: collocation, modes' \
    cpinn-solve "$elastica" --method stress

# ---- rows of commands --------------------------------------------------------------------------

# The same tension again leaves the shape of the first time, and that of the way down is another one.
printf 'pull\n1\n2\n1\n2\n' >rows.csv
run 0 cpinn-solve "$ROOT/configs/hysteresis/tendon.yaml" --rows rows.csv --tolerance 1e-6 --grid 2 --out tips.csv --json rows.json
said stdout.txt '^tendon: 4 of 4 rows in their order, largest estimated error'
awk -F, 'NR > 1 && $2 > 0 { print $3 }' tips.csv >tips.txt
check a loop that is closed -- awk '{ x[NR] = $1 } END { d = x[4] - x[2]; if (d < 0) d = -d
    exit !(NR == 4 && d < 1e-6 && x[3] - x[1] > 5e-3) }' tips.txt
printf 'pull\n5\n' >far.csv
refused 'far.csv:2: pull = 5 is outside its range; allowed: 0.01 to 3' \
    cpinn-solve "$ROOT/configs/hysteresis/tendon.yaml" --rows far.csv
# A motor of backlash 2 mm turns back by 1.5 mm without a drum that follows, then by 3 mm with one: the same by the
# solver of members, to the errors of both.
printf 'wind1,wind2,play1,play2,loose,stiff\n0.006,0,1e-3,0,0,4000\n0.0045,0,1e-3,0,0,4000\n0.003,0,1e-3,0,0,4000\n' >winds.csv
for way in --members --rows; do
    run 0 cpinn-solve "$ROOT/configs/identify/backlash.yaml" $way winds.csv --grid 2 --out wound.csv
    awk -F, 'NR > 1 && $2 > 0 { print $3 }' wound.csv >"drums$way.txt"
done
check a drum that stays -- awk 'NR == 1 { first = $1 } NR == 2 { same = $1 == first }
    END { exit !(NR == 3 && same && first - $1 > 5e-3) }' drums--rows.txt
check members as rows -- awk 'NR == FNR { x[NR] = $1; next } { d = $1 - x[FNR]; if (d > 1e-7 || d < -1e-7) exit 1 }' \
    drums--rows.txt drums--members.txt
refused '^--rows: allowed: of a scene at rest with parameters' cpinn-solve "$elastica" --rows rows.csv
refused '^cpinn-solve: --rows with --at' cpinn-solve "$elastica" --rows rows.csv --at pull=1

# ---- motions by strain modes ------------------------------------------------------------------

run 0 cpinn-solve "$ROOT/configs/soft_arm.yaml" --method modes --tolerance 1e-3
said stdout.txt 'modes \(bending [0-9, ]*, twist 0, stretch 0, shear 0, 0\), [0-9]* steps of time'
said stdout.txt 'times real time$'
said stdout.txt '^  tip +0\.2997[0-9]* 0 0\.002[89][0-9]* m$'
run 0 cpinn-solve "$ROOT/configs/soft_arm.yaml" --method modes --modes 3,1,0,0 --grid 5x3 --out m.csv
said stdout.txt '^solved: [0-9]+ nodes, 7 modes'
check no estimate -- test "$(grep -c estimate stdout.txt)" -eq 0
# Forces of locked strains: a rod that hangs carries its weight, 1100 pi 0.004^2 0.4 kg. Nodes do not know it.
cat > hanging.yaml <<'YAML'
rod:
  model: kirchhoff
  length: 0.4
  section: {shape: circle, radius: 0.004}
  material: {youngs_modulus: 5.0e6, poissons_ratio: 0.45, density: 1100, relaxation_time: 0.01}
boundary: {start: {type: clamped}}
loads: {gravity: [0, 0, 9.81 + t]}
initial: {state: equilibrium}
time: {duration: 0.5}
YAML
run 0 cpinn-solve hanging.yaml --grid 3x2 --out hanging.csv
said stdout.txt 'estimated error +1.000e-13 of the position'
check what hangs is carried -- awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i }
    NR > 1 { w = 1100 * 3.14159265358979 * 0.004^2 * (0.4 - $at["s"]) * (9.81 + $at["t"]); d = $at["n3"] - w
             if (d > 1e-9 || d < -1e-9) exit 1 } END { exit NR != 7 }' hanging.csv
run 0 cpinn-solve hanging.yaml --nodes 9 --set time.duration=0.1 --set "loads.gravity=[3, 0, 9.81]" --grid 3x2 --out hanging.csv
check no force of nodes -- awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i }
    NR > 1 && ($at["n3"] != "nan" || $at["m2"] == "nan") { exit 1 }' hanging.csv
# More windows than a network may have are nothing to the solver.
long=("$ROOT/configs/soft_arm.yaml" --set time.duration=100 --set rod.material.relaxation_time=0.1)
run 0 cpinn-solve "${long[@]}" --method modes --modes 2,0,0,0
refused 'time.duration: would take [0-9.e+]* windows' cpinn-train "${long[@]}"
for modes in 2147483647,1,1,1 99999999999,1,1,1 1,1,1 2,1,2,1x; do
    refused "^cpinn-solve: --modes $modes; allowed: with --method modes, four numbers from 0 to " \
        cpinn-solve "$ROOT/configs/soft_arm.yaml" --method modes --modes $modes
done
refused 'time.duration: method modes is of scenes in motion, and this one is at rest' \
    cpinn-solve "$elastica" --method modes
refused 'rod.model: method modes does not take a beam of small deflection' \
    cpinn-solve "$ROOT/configs/beam_vibration.yaml" --method modes
refused 'boundary.start.type: method modes does not take a free or loaded start' \
    cpinn-solve "$ROOT/configs/cases/spinning.yaml" --method modes
refused '^cpinn-solve: --modes 3,1; allowed: with --method modes, four numbers from 0 to 24' \
    cpinn-solve "$ROOT/configs/soft_arm.yaml" --method modes --modes 3,1
refused 'method modes are given; allowed: --modes' \
    cpinn-solve "$ROOT/configs/soft_arm.yaml" --method modes --nodes 9

# ---- as a reference of a network --------------------------------------------------------------

for ending in csv h5; do
    run 0 cpinn-solve "$elastica" --out "solved.$ending" --grid 41x1
    said stdout.txt "^wrote solved.$ending: 41 points"
    run 0 cpinn-solve "$elastica" --set reference.analytic=null --set reference.file="$PWD/solved.$ending"
    said stdout.txt "^difference from solved.$ending \(41 points\)"
    said stdout.txt 'position, largest +[0-9.]+e(-1[5-9]|-[2-9][0-9]|.00) of the length'
done
head -1 solved.csv >columns.txt
run 0 cpinn-solve "$elastica" --out again.csv --points solved.csv # also the points of a file
check the same at the same points -- cmp solved.csv again.csv
refused '^cpinn-solve: --points and --grid are given' \
    cpinn-solve "$elastica" --points solved.csv --grid 3 --out none.csv
refused 'nothing would be written' cpinn-solve "$elastica" --points solved.csv
run 3 cpinn-train "$elastica" --set 'network.hidden=[4]' --set losses.interior.points=8 \
    --set losses.held_out_points=8 --set 'training.stages=[{optimizer: adam, steps: 2}]' \
    --set reference.analytic=null --set reference.file="$PWD/solved.csv" --out run --quiet
run 0 cpinn-eval run --out network.csv --grid 41x1
said stdout.txt '^error against solved.csv \(41 points\)'
head -1 network.csv >stdout.txt
same stdout.txt columns.txt

# ---- solved on the way ------------------------------------------------------------------------

one='{optimizer: adam, steps: 40, learning_rate: 1e-3}'
two='{optimizer: lbfgs, steps: 30}'
small=(cpinn-train "$heavy" --set 'network.hidden=[6]' --set losses.interior.points=16
    --set losses.held_out_points=8 --threads 1)
run 3 "${small[@]}" --set "training.stages=[$one, $two]" --out whole
said stdout.txt '^reference: solved classically, estimated error [0-9.]+e-1[2-9] of the length, [0-9.]+ s$'
check one file is kept -- test "$(ls cache/cpinn | wc -l)" -eq 1
kept=cache/cpinn/$(ls cache/cpinn)
without_seconds whole/history.csv >whole.history

# A run that goes on, with the reference from the cache, from a new cache, and from a damaged one.
for cache in "$work/cache" "$work/other" damaged; do
    rm -rf parts
    run 3 "${small[@]}" --set "training.stages=[$one]" --out parts
    said stdout.txt '^reference: solved classically, .*, from .*/cpinn/[0-9a-f]{16}\.h5$'
    if [ "$cache" = damaged ]; then
        cache=$work/cache
        head -c 3000 "$kept" >short && mv short "$kept"
    fi
    run 3 env XDG_CACHE_HOME="$cache" "${small[@]}" --set "training.stages=[$one, $two]" --out parts --resume
    without_seconds parts/history.csv >parts.history
    same parts.history whole.history
done
said stdout.txt '^reference: .*\.h5: is damaged or of another scene; solved anew$'
check nothing on stderr -- test ! -s stderr.txt

run 0 cpinn-eval parts
said stdout.txt '^reference: solved classically, .*, from '
said stdout.txt '^error against classical solution \(101 points\)$'
check no remark -- test "$(grep -c 'reference itself' stdout.txt)" -eq 0
run 0 env -u HOME XDG_CACHE_HOME= cpinn-eval parts
said stdout.txt '^reference: solved classically, .* s$'
touch taken
run 0 env XDG_CACHE_HOME="$PWD/taken" cpinn-eval parts
said stderr.txt '^cpinn-eval: warning: reference: .*/taken/cpinn/.*not kept for the next run$'
run 0 cpinn-train "$heavy" --set reference.solve=1e-4 --out coarse
said stdout.txt '^note \(reference_too_coarse\): the reference itself is off by an estimated [0-9.]+e-[0-9]+ of the length'
run 3 "${small[@]}" --set "training.stages=[$one]" --out missed \
    --set reference.solve=1e-13 --set 'boundary.start.rotation=[1, 0, 0, 0]' \
    --set 'loads.force=[1e-6, 0, -2.09865]' # so near to buckling that rounding grows
said stdout.txt 'solved classically, estimated error .* of the length, not the 1e-13 asked for, '
run 0 cpinn-train "$heavy" --explain
said stdout.txt 'reference +classical solution, 101 points, estimated error [0-9.]+e-1[2-9] of the length$'
run 0 cpinn-bench "$heavy" --set 'network.hidden=[4]' --set losses.interior.points=8 \
    --methods adam:2 --seeds 1 --threads 1 --out solved_bench
run 0 cpinn-solve "$heavy"
check it is not compared with itself -- test "$(grep -c difference stdout.txt)" -eq 0
cat >squeezed.yaml <<'END'
rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}
boundary: {end: {type: clamped, position: [0, 0, 0.6], rotation: [1, 0, 0, 0]}}
reference: solve
END
refused '^squeezed.yaml:3:12: reference.solve: solving stops at 0\.9[0-9]* of the load, ' \
    cpinn-train squeezed.yaml

# ---- a motion ---------------------------------------------------------------------------------

run 0 cpinn-solve "$dynamic" --nodes 9 --tolerance 1e-3 --out motion.csv --grid 3x5
said stdout.txt '^[a-z_]+: dynamic, .*duration 1$'
said stdout.txt '^solved: 9 nodes, [0-9]+ steps of time, '
said stdout.txt '^  energy +kinetic 0\.59[0-9]*, strain 2\.4[0-9]*, work of loads 3\.0[0-9]*, dissipated 0 J$'
said stdout.txt '^  energy out of balance +[0-9.]+e-0[4-9] of the largest$'
said stdout.txt '^difference from cantilever_ramp.csv'
said motion.csv '^s,t,x,.*,vx,vy,vz,w1,w2,w3$'
run 0 cpinn-solve "$dynamic" --nodes 9 --tolerance 1e-3 --out again.csv --points motion.csv
check the same at the same points -- cmp motion.csv again.csv
check the tip falls as far -- awk -F, 'END { exit !(NR == 16 && $5 < -0.85 && $5 > -0.86) }' motion.csv

# ---- beams of small deflection ----------------------------------------------------------------

run 0 cpinn-solve "$ROOT/configs/beam_cantilever.yaml" --out beam.csv --grid 3x1
said stdout.txt '^beam_cantilever: static, shear kGA L\^2/EI locked$'
said stdout.txt '^solved: [0-9]+ nodes, [0-9.]+ ms$'
said stdout.txt 'estimated error +[0-9.]+e(-1[4-9]|\+00) of the deflection'
said stdout.txt '^  loads out of balance +[0-9.]+e(-1[4-9]|-[2-9][0-9]|\+00)$'
said stdout.txt 'position, relative L2 +[0-9.]+e(-1[4-9]|\+00)$'
said beam.csv '^s,t,w,slope,V,M$'
run 0 cpinn-solve "$ROOT/configs/timoshenko_vibration.yaml" --out beam.csv --grid 3x3
said stdout.txt '^solved: [0-9]+ nodes, [0-9]+ steps of time, [0-9.]+ ms$'
said stdout.txt 'position, relative L2 +[0-9.]+e-1[0-9]$'
said beam.csv '^s,t,w,slope,V,M,w_t,slope_t$'
falls "$ROOT/configs/beam_vibration.yaml" 5 21 1e-6 1e-11
refused 'beams of small deflection do not buckle' \
    cpinn-solve "$ROOT/configs/beam_cantilever.yaml" --perturb 10
run 1 cpinn-solve "$ROOT/configs/beam_cantilever.yaml" --set 'beam.force=log(s - 0.01)' \
    --set reference=null
said stderr.txt 'the deflection is not finite'
run 1 cpinn-solve "$elastica" --set 'loads.force=[0, 0, sqrt(0.2999 - s)]' --set reference=null
said stderr.txt 'what loads, holds or shapes the rod is not finite at s = 0.2999[0-9]* m$'

# ---- work and precision -----------------------------------------------------------------------

falls "$elastica" 2 64 1e-3 1e-13
run 0 cpinn-solve "$ROOT/configs/tapered_arm.yaml" --tolerance 1e-7 --grid 21x11 --out elements.csv
for modes in 2,1,2,1 20,12,20,20; do
    run 0 cpinn-solve "$ROOT/configs/tapered_arm.yaml" --method modes --tolerance 1e-6 --modes $modes \
        --grid 21x11 --out modes.csv
    awk -F, 'NR == FNR { for (i = 3; i < 6; i++) exact[FNR, i] = $i; next }
        FNR > 1 { for (i = 3; i < 6; i++) { off += ($i - exact[FNR, i]) ^ 2; size += exact[FNR, i] ^ 2 } }
        END { print sqrt(off / size) }' elements.csv modes.csv
done >apart.txt
check rods of more modes agree with spectral elements -- awk 'NR == 1 { first = $1 } { last = $1 }
    END { exit !(first > 1e-3 && last < 1e-6) }' apart.txt

# ---- several equilibria -----------------------------------------------------------------------

cat >column.yaml <<'END'
rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}
boundary: {start: {type: clamped}}
loads: {tip: {force: [0, 0, -5]}}
END
run 3 cpinn-solve column.yaml
said stdout.txt '^warning \(unstable\): .* the energy falls in [12] directions?;'
said stdout.txt '^  tip +0 0 1 m|^  tip .* (0.9999999999999|1) m'
said stdout.txt 'unstressed'
said stdout.txt 'perturb 10'
run 0 cpinn-solve column.yaml --perturb 10
said stdout.txt '^  tip +-?0.79'
for case in '0 buckled_2' '3 constant_strain'; do # to the branch that the imperfection names
    run "${case% *}" cpinn-solve "$ROOT/configs/cases/${case#* }.yaml" # a moment in space makes it flutter
    said stdout.txt 'position, largest +[0-9.]+e-1[2-9] of the length'
done
run 1 cpinn-solve column.yaml --out no.csv --set \
    'boundary.end={type: clamped, position: [0, 0, 0.6], rotation: [1, 0, 0, 0]}' --set loads.tip=null
said stderr.txt '^cpinn-solve: .*stopped at 0\.9[0-9]* of the load.*perturb'
check one line, no file, no result -- test "$(wc -l <stderr.txt)" -eq 1 -a ! -e no.csv -a ! -s stdout.txt

# ---- paths ------------------------------------------------------------------------------------

run 3 cpinn-solve "$ROOT/configs/arch.yaml" --path arch.csv --json arch.json
said stdout.txt '^path: [0-9]+ points, deflection at s = 0\.5 m along '
said stdout.txt '^  limit point +at 0\.7730884138[0-9]* of the load, deflection 0\.01878'
said stdout.txt '^  bifurcation +at 0\.391004073[0-9]* of the load'
said stdout.txt '^warning \(snapped\): a rod that is loaded slowly leaves this path at 0\.391004073'
said arch.csv '^load_factor,arclength,deflection,x,y,z,unstable,mark$'
said arch.csv '^0\.7730884138[0-9]*,.*,limit$'
said arch.json '"limit_load": *0\.7730884138'
said arch.json '"limit_points": *\[0\.7730884138[0-9]*, *-0\.354102437'
gnuplot -e "path='arch'" "$ROOT/configs/path.gp" || failed the script does not draw
check a picture -- test -s arch.svg
run 0 cpinn-solve column.yaml --branch 1
said stdout.txt '^  tip +0\.79'
said stdout.txt '^note \(several_equilibria\): of several equilibria this one lies on branch 1'
run 0 cpinn-solve "$ROOT/configs/ring.yaml"
run 0 cpinn-train "$ROOT/configs/ring.yaml" --out ring
refused 'branch 2: the path to the full load has 1 bifurcation$' cpinn-solve column.yaml --branch 2
refused 'time.duration: a path of equilibria is of scenes at rest, and this one moves' cpinn-solve "$dynamic" --nodes 9 --tolerance 1e-2 --path no.csv
refused 'time.duration: a path of equilibria is of scenes at rest, and this one moves' cpinn-solve "$dynamic" --branch 1
refused 'path: a perturbation is given' cpinn-solve column.yaml --perturb 10 --path no.csv

# ---- what is refused --------------------------------------------------------------------------

run 0 cpinn-solve --help
said stdout.txt '^usage: cpinn-solve CONFIG.yaml'
said stdout.txt '--perturb X'
run 0 cpinn-solve --version
said stdout.txt '^cpinn-solve [0-9]'
refused '^cpinn-solve: CONFIG.yaml is missing' cpinn-solve
refused 'no_such.yaml: cannot be read' cpinn-solve no_such.yaml
refused '^cpinn-solve: --tolerance 2: allowed' cpinn-solve "$elastica" --tolerance 2
refused '^cpinn-solve: --tolerance small: allowed' cpinn-solve "$elastica" --tolerance small
refused '^cpinn-solve: --nodes 0: allowed' cpinn-solve "$elastica" --nodes 0
refused '^cpinn-solve: --grid 5x5: allowed' cpinn-solve "$elastica" --grid 5x5 --out grid.csv
refused 'x.txt: .*allowed: .csv' cpinn-solve "$elastica" --out x.txt
refused 'none/y.csv: no file can be written there' cpinn-solve "$elastica" --out none/y.csv
refused 'override rod.length=-1: rod.length' cpinn-solve "$elastica" --set rod.length=-1

finish
