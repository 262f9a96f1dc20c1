#!/bin/bash
# Unknowns from data as users find them: by the solver, by a network, and what is refused.
#   test_identify.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"

scenes=$ROOT/configs/identify

# near A B PART: whether A is B to this part of it.
near() {
    awk -v a="$1" -v b="$2" -v part="$3" 'BEGIN { d = a - b; if (d < 0) d = -d; exit !(d <= part * b) }'
}

run 0 cpinn-solve "$scenes/stiffness.yaml"
said stdout.txt 'identified from 60 numbers of 20 experiments'
said stdout.txt 'bending .* \+- '

# A motion, from which 2e-2 was made; and of too few modes of the rod it is said that more change what is found.
run 0 cpinn-solve "$scenes/swinging.yaml"
check damping -- near "$(awk '$1 == "material_relaxation_time" { print $2 }' stdout.txt)" 0.02 0.05
run 3 cpinn-solve "$scenes/swinging.yaml" --method modes --modes 2,0,0,0
said stdout.txt 'warning \(estimate_above_tolerance\): more modes .* change what was measured by 1.[0-9] of its noise'

# What cameras write: names of pictures, lost markers, remarks; and millimetres. The stiffness found
# without a tenth of the numbers is off by less than its deviation, 3e-3.
awk -F, -v OFS=, 'NR == 1 { print "picture", $0, "remark"; next }
    NR == 4 { $4 = $5 = $6 = "" } NR == 9 { $4 = $5 = $6 = "nan" } { print "a" NR ".png", $0, "\"dim, far\"" }' \
    "$scenes/stiffness_tips.csv" >camera.csv
awk -F, -v OFS=, 'NR > 1 { $4 *= 1000; $5 *= 1000; $6 *= 1000 } { print }' "$scenes/stiffness_tips.csv" >millimetres.csv
run 0 cpinn-solve "$scenes/stiffness.yaml" --json all.json
run 0 cpinn-solve "$scenes/stiffness.yaml" --set "data[0].file=$PWD/camera.csv" --json lost.json
said stdout.txt 'identified from 54 numbers of 18 experiments: .*; 6 more are missing'
run 0 cpinn-solve "$scenes/stiffness.yaml" --json one.json --threads 1
alike() { grep -v seconds "$1"; }
same <(alike one.json) <(alike all.json)
first() { tr -d '\n ' <"$1" | sed 's/.*"unknowns":\[{"name":"bending","value":\([^,]*\).*/\1/'; }
check lost markers -- near "$(first lost.json)" "$(first all.json)" 3e-3
run 2 cpinn-solve "$scenes/stiffness.yaml" --set "data[0].file=$PWD/millimetres.csv"
said stderr.txt 'millimetres.csv: positions lie some 887 times the length, 0.2 m, from .*; they are in m, not in mm'

# The same numbers as others write them: in mm, without names, to be read from another folder; and rows that
# are held out, of which each is as far from what is found as those that it was found from.
mkdir records
awk -F, -v OFS=, 'NR > 1 { print $4 * 1000, $5 * 1000, -$6 * 1000, $1, $2 - 0.001 }' "$scenes/stiffness_tips.csv" >records/tips.csv
as_written='quantity: position, file: tips.csv, noise: 5.0e-4, columns: {x: c1/mm, y: c2/mm, z: -c3/mm, turned: c4, pull: c5 + 0.001, s: 0.2}'
written() { cpinn-solve "$scenes/stiffness.yaml" --data records --set parameters.mm=1000 --set "data=[$1]" "${@:2}"; }
run 0 written "{$as_written}" --json written.json
check same value from other units -- near "$(first written.json)" "$(first all.json)" 1e-5 # awk writes 6 digits
run 0 written "{$as_written, rows: {every: 2}}, {$as_written, rows: {from: 2, to: 20}, held_out: true}" --json half.json
said stdout.txt '^  tips.csv +10 .*[0-9]$'
said stdout.txt '^  tips.csv +19 .* held out$'
check held out -- near "$(grep -A5 held_out half.json | sed -n 's/.*"rms": \([^,]*\).*/\1/p')" "$(grep -A5 '"fitted"' half.json | sed -n 's/.*"rms": \([^,]*\).*/\1/p')" 0.5
# Row by row: as many as there are, of which the distances have that rms; every coordinate that is computed.
run 0 written "{$as_written}" --residuals rows.csv --json written.json
check rows -- test "$(wc -l <rows.csv)" -eq 21
check columns -- test "$(head -1 rows.csv)" = \
    file,data,judged,pose,marker,s,turned,pull,x,x_computed,y,y_computed,z,z_computed,distance,deviation
rms=$(awk -F, 'NR > 1 { n++; sum += $15^2; own = ($9 - $10)^2 + ($11 - $12)^2 + ($13 - $14)^2; worst += (own - $15^2)^2 }
    END { printf "%.9g", worst < 1e-20 ? sqrt(sum / n) : 0 }' rows.csv)
check distances -- near "$rms" "$(sed -n 's/.*"rms": \([^,]*\).*/\1/p' written.json)" 1e-6
# With what was found given as numbers, the same rows; nothing is fitted, so that all may be held out.
given=$(tr -d '\n ' <written.json | grep -o '"name":"[^"]*","value":[^,]*' | sed -n 's/"name":"\([^"]*\)","value":\(.*\)/--set parameters.\1=\2/p')
run 0 written "{$as_written, held_out: true}" $given --residuals given.csv
said stdout.txt '^  tips.csv +20 .* held out$'
awk -F, 'NR == FNR { distance[FNR] = $15; next } FNR > 1 { off = $15 - distance[FNR]; if (off * off > worst) worst = off * off }
    END { exit !(FNR == 21 && worst < 1e-24) }' rows.csv given.csv || failed other distances from given numbers
run 2 cpinn-solve "$elastica" --residuals none.csv
said stderr.txt '^--residuals: allowed: of a scene with data, without --at of its unknowns$'
run 2 written "{$as_written}" $given --run kept
said stderr.txt '^--run: allowed: of a scene with unknowns to be found$'
refuse_written() {
    run 2 written "$2"
    said stderr.txt "$1"
    check one line -- test "$(wc -l <stderr.txt)" -eq 1
}
refuse_written "data\[0\].columns: 'w' is nothing that is needed; allowed: s, x, y, z, turned, pull" "{${as_written/s: 0.2/s: 0.2, w: c1}}"
refuse_written "data\[0\].columns: x: 'd1' is no column of the file, nor a number of the scene; columns are i1, i2, c1 to c5, c1, c2, c3, c4, c5" "{${as_written/c1/d1}}"
refuse_written "data\[0\].columns: y: 'c2/\(c2-c2\)' is not a finite number in row 1" "{${as_written/c2\/mm/c2/(c2-c2)}}"
refuse_written "data\[0\].rows.where: column 4 of 'c1-': the formula ends" "{$as_written, rows: {where: c1-}}"
refuse_written 'no row is chosen; at least one row is needed' "{$as_written, rows: {from: 21}}"
refuse_written 'data\[0\].held_out: all data are held out' "{$as_written, held_out: true}"
refuse_written 'data\[0\].columns: is 3; allowed: a section of names, each with a number or a formula' '{quantity: position, file: tips.csv, columns: 3}'
run 2 cpinn-solve "$scenes/stiffness.yaml" --data nowhere
said stderr.txt '^cpinn-solve: --data nowhere: allowed: a folder that is there$'

# A first step that goes beyond an end of a range ended there, at a chi squared of 29 for 13 by the way back.
cat >wound.yaml <<'END'
parameters:
  {pull: {range: [0, 0.022]}, way: {range: [0, 6.2]}, w1: {range: [0, 0.0018]}, k2: {identify: -0.95, range: [-15, 15]},
   m3: {identify: 4.4e-4, range: [-5.9e-3, 5.9e-3]}, stiff: {identify: 2307, range: [121, 12107], scale: log}}
rod:
  model: kirchhoff
  length: 0.2
  section: {shape: circle, radius: 0.00347982067}
  material: {youngs_modulus: 1899080.24, poissons_ratio: 0.203291998, density: 1200}
  rest: {curvature: [-2.65669039, k2, 0]}
loads: {gravity: [0, 0, 9.81], tip: {force: [pull*cos(way), pull*sin(way), -3.46688642e-4], moment: [0, 0, m3]}}
bodies: [{at: 0.12, mass: 0.000602723468, offset: [0.00364398332, 0, 0]}]
tendons: [{displacement: w1 - 5.84827875e-4, stiffness: stiff, offset: [0.00695964133, 0]}]
data: [{quantity: position, file: wound.csv, noise: 5.49e-5}]
END
cat >wound.csv <<'END'
pull,way,w1,s,x,y,z
0.00498564555,5.96622922,0.000219804436,0.1,0.0134268331,0.0009202312,0.0987115276
0.00498564555,5.96622922,0.000219804436,0.2,0.0644275083,0.0223730963,0.179736998
0.015500117,0.528148662,0.000430525127,0.1,0.0195582442,0.0101730092,0.0966953809
0.015500117,0.528148662,0.000430525127,0.2,0.0742512818,0.0497802663,0.168083207
0.0219725276,1.29826532,0.00111679352,0.1,0.0151339404,0.0214130294,0.0952303627
0.0219725276,1.29826532,0.00111679352,0.2,0.053551886,0.0895799294,0.152971907
END
run 0 cpinn-solve wound.yaml
check way back from an end -- near "$(awk '$1 == "stiff" { print $2 }' stdout.txt)" 1685 0.3

# What a foundation is measured from goes with a rest shape that is to be found. It stayed at the middle of the range.
cat >bedded.yaml <<'END'
rod: {model: kirchhoff, length: 0.3, stiffness: {bending: [0.05, 0.05], torsion: 0.04}, rest: {curvature: [0, -6, 0]}}
loads: {foundation: [9, 9, 9], tip: {force: [0.3, 0, -0.2]}}
END
run 0 cpinn-solve bedded.yaml --grid 4 --out bedded.csv
run 0 cpinn-solve bedded.yaml --set 'rod.rest.curvature[1]={identify: 2, range: [-30, 30]}' \
    --set "data=[{quantity: position, file: $PWD/bedded.csv, noise: 1.0e-4}]"
check rest shape on a foundation -- near "$(awk '$1 == "rest_curvature_1" { print -$2 }' stdout.txt)" 6 1e-4

# How a tube is turned, from where the rod is; what the solver wrote is found to its own error.
cat >tubes.yaml <<'END'
rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}, rest: {curvature: [0.5, 0, 0]}}
tubes: [{stiffness: {bending: [2, 2], torsion: 1.6}, rest: {curvature: [0.4, 0, 0]}, end: 0.6, turned: 1.1, transmission: 0.3}]
END
run 0 cpinn-solve tubes.yaml --grid 3 --out tubes.csv
run 0 cpinn-solve tubes.yaml --set 'tubes[0].turned={identify: 0.5, range: [0, 3]}' --json tubes.json \
    --set "data=[{quantity: position, file: $PWD/tubes.csv, noise: 1e-3}]"
check angle of a tube -- near "$(sed -n 's/.*"tubes_0_turned", "value": \([^,]*\).*/\1/p' tubes.json)" 1.1 1e-6

# How long a rod is, from its tip and from markers on a part of it that stays; and by how much more has come out of a
# port than is said. What the solver wrote of others is found to its own error.
cat >length.yaml <<'END'
parameters: {pull: {range: [0, 2]}, more: {range: [0.05, 0.2]}, out: 0.15, off: 0}
rod: {model: kirchhoff, section: {shape: circle, radius: 0.001},
      material: {youngs_modulus: 5e9, poissons_ratio: 0.3, density: 2000}}
segments: [{length: 0.1}, {length: more, section: {radius: 0.0008}}]
loads: {gravity: [4, 0, 0]}
tendons: [{offset: [0, 0.006], tension: pull}]
END
printf 's\n0.05\n0.1\n0.18\n' >places.csv
printf 'pull,s,x,y,z\n' | tee markers.csv >tips.csv
printf 'pull,x,y,z\n' >short.csv
for pull in 0.5 1.5; do
    run 0 cpinn-solve length.yaml --at "pull=$pull,more=0.08" --points places.csv --out shape.csv
    awk -F, -v OFS=, -v pull=$pull 'NR > 1 { print pull, $1, $3, $4, $5 >>(NR < 4 ? "markers.csv" : "tips.csv") }' shape.csv
    run 0 cpinn-solve length.yaml --set parameters.more=0.08 --set rod.inserted=0.14 --at "pull=$pull" --grid 2 --out shape.csv
    awk -F, -v OFS=, -v pull=$pull 'NR == 3 { print pull, $3, $4, $5 }' shape.csv >>short.csv
done
cut -d, -f1,3- tips.csv >ends.csv
measured() { echo "{quantity: position, file: $PWD/$1, noise: 1e-4}"; }
longer() { cpinn-solve length.yaml --set 'parameters.more={identify: 0.15, range: [0.05, 0.2]}' --json length.json --set "data=[$1]"; }
value_of() { sed -n "s/.*\"$1\", \"value\": \([^,]*\).*/\1/p" length.json; }
run 0 longer "$(measured ends.csv), $(measured markers.csv)"
check length -- near "$(value_of more)" 0.08 1e-6
run 2 longer "$(measured tips.csv)"
said stderr.txt 'tips.csv: s = 0.18 m is not on the rod, or goes with what is to be found'
run 0 cpinn-solve length.yaml --set parameters.more=0.08 --set rod.inserted=out-off --json length.json \
    --set 'parameters.off={identify: 0.02, range: [0, 0.05]}' --set "data=[$(measured short.csv)]"
check inserted -- near "$(value_of off)" 0.01 1e-5
sed 2d short.csv | cut -d, -f2- >one.csv
run 0 cpinn-solve length.yaml --set parameters.more=0.08 --set parameters.pull=1.5 --set rod.inserted=out-off --json length.json \
    --set 'parameters.off={identify: 0.02, range: [0, 0.05]}' --set "data=[$(measured one.csv)]"
check inserted of one rod, which is solved then -- near "$(value_of off)" 0.01 1e-5

# The network finds what the solver does, as well known.
run 0 cpinn-solve "$scenes/bent.yaml" --json solved.json
run 0 cpinn-train "$scenes/bent.yaml" --out whole --threads 1 --json trained.json
pick() { tr -d '\n ' <"$1" | sed 's/.*"unknowns":\[{\([^}]*\)}.*/\1/' | tr ',' '\n' | grep "\"$2\"" | cut -d: -f2; }
check same value -- near "$(pick trained.json value)" "$(pick solved.json value)" 1e-4
check same deviation -- near "$(pick trained.json standard_deviation)" "$(pick solved.json standard_deviation)" 0.02

# Backlash, from rows in their order: by less than four deviations of 2.5e-6 off what backlash.yaml says. The other
# way round, the same rows do not fit.
run 0 cpinn-solve "$scenes/backlash.yaml" --json backlash.json
check backlash -- near "$(pick backlash.json value)" 4e-4 0.025
(head -1 "$scenes/backlash_tips.csv"; tail -n +2 "$scenes/backlash_tips.csv" | tac) >turned_round.csv
run 3 cpinn-solve "$scenes/backlash.yaml" --set "data[0].file=$PWD/turned_round.csv"
said stdout.txt 'warning \(misfit\)'

# An end of a range that chance alone leads to: what the value may be is in the deviations, as of a load that goes with it.
# A foundation of 3 N/m^2 is known to 3.2; numbers that ask for -1.3, and for -15, of which the latter is not chance.
cat >weak.yaml <<'END'
rod: {model: kirchhoff, length: 0.3, stiffness: {bending: [0.05, 0.05], torsion: 0.04}}
loads: {foundation: [3, 0, 0], tip: {force: [0.1, 0, 0]}}
END
run 0 cpinn-solve weak.yaml --grid 4 --out weak.csv
weak() { # OFF: by so many m at the tip
    awk -F, -v OFS=, -v CONVFMT=%.12g -v off="$1" 'NR > 1 { $3 += off * ($1 / 0.3)^6 } { print }' weak.csv >weak_seen.csv
    run 3 cpinn-solve weak.yaml --set 'loads.tip.force[0]={identify: 0.2, range: [0, 1]}' \
        --set 'loads.foundation[0]={identify: 5, range: [0, 50]}' --set "data=[{quantity: position, file: $PWD/weak_seen.csv, noise: 2.0e-5}]"
}
weak -7e-5
said stdout.txt 'loads_foundation_0 +0 \+- 3.2, an end of its range'
said stdout.txt 'warning \(at_bound\): .* values within its deviation suit nearly as well: loads_foundation_0 = 0'
check deviation of the load -- near "$(awk '$1 == "loads_tip_force_0" { print $4 }' stdout.txt)" 0.0039 0.1
weak -3e-4
said stdout.txt 'loads_foundation_0 +0, an end of its range'
said stdout.txt 'warning \(at_bound\): .* deviations of the others hold for this value: loads_foundation_0 = 0'

# A value at an end of its range, and noise that is not known, are said in the same way.
range='rod.stiffness.bending[0]={identify: 0.002, range: [0.001, 0.0025]}'
run 3 cpinn-solve "$scenes/bent.yaml" --set "$range"
said stdout.txt 'warning \(at_bound\)'
said stdout.txt 'deviations are those of the stated one'
run 3 cpinn-train "$scenes/bent.yaml" --set "$range" --out bound
said stdout.txt 'warning \(at_bound\)'
run 3 cpinn-train "$scenes/bent.yaml" --set 'training.stages=[{optimizer: gauss_newton, steps: 6}]' --out short # half a deviation off
said stdout.txt 'search for the unknowns has not ended after 6 steps'
run 0 cpinn-solve "$scenes/bent.yaml" --set 'data[0].noise=0' --json solved.json
cpinn-train "$scenes/bent.yaml" --set 'data[0].noise=0' --set 'data[0].weight=1' --out noise --json noise.json >/dev/null
number() { grep -o "\"$2\": [^,}]*" "$1" | cut -d: -f2; }
check same noise -- near "$(number noise.json noise_factor)" "$(number solved.json noise_factor)" 0.02

# Over powers of ten; two values that suit as well, and what is hardly told.
run 0 cpinn-solve "$scenes/bent.yaml" --set 'rod.stiffness.bending[0]={identify: 1, range: [1e-5, 10]}' --json wide.json
check far off -- near "$(pick wide.json value)" 0.00310284 1e-4
run 0 cpinn-train "$scenes/bent.yaml" --set 'rod.stiffness.bending[0]={identify: 1, range: [1e-5, 10]}' --explain
said stdout.txt 'to be found: stiffness_bending_0 from 1 on, within 1e-05 to 10 by its logarithm'
run 3 cpinn-solve "$scenes/bent.yaml" --set 'rod.stiffness.bending=[3.1e-3, 3.1e-3]' --set 'parameters={pull: {identify: 0.05, range: [-0.2, 0.2]}, turned: {identify: 1, range: [0, 6.2]}}' --set 'loads.tip.force=[pull*cos(turned), pull*sin(turned), -0.03]'
said stdout.txt 'warning \(several_solutions\): other values suit the measurements as well: pull = -0.0999, turned = 4.7'

# Stopped in the midst and resumed, and by two threads: the same numbers.
cpinn-train "$scenes/bent.yaml" --out parts --threads 1 --set checkpoint.every=1 >/dev/null 2>&1 &
pid=$!
while kill -0 "$pid" 2>/dev/null && [ "$(cat parts/history.csv 2>/dev/null | wc -l)" -lt 13 ]; do
    sleep 0.005
done
kill -INT "$pid" 2>/dev/null
wait "$pid"
run 0 cpinn-train "$scenes/bent.yaml" --out parts --threads 1 --set checkpoint.every=1 --resume --json parts.json
check same bits after a stop -- test "$(pick parts.json value)" = "$(pick trained.json value)"
run 0 cpinn-train "$scenes/bent.yaml" --out two --threads 2 --json two.json
check same bits by two threads -- test "$(pick two.json value)" = "$(pick trained.json value)"
run 0 cpinn-eval whole --grid 11 --out whole.csv
run 0 cpinn-eval two --grid 11 --out two.csv
same whole.csv two.csv

# A run keeps its measurements.
cp "$scenes/bent.yaml" "$scenes/bent_shape.csv" .
run 3 cpinn-train bent.yaml --out kept --set training.stages[0].steps=3
sed 's/^0.1,/0.1001,/' "$scenes/bent_shape.csv" >bent_shape.csv
run 2 cpinn-train bent.yaml --out kept --set training.stages[0].steps=3 --resume
said stderr.txt 'data0: the file of these measurements has other rows now'
rm bent_shape.csv

# ---- refusals ---------------------------------------------------------------------------------

# refuse TEXT OPTIONS: by the solver and by training, in the same line but for their names.
refuse() {
    local text=$1 program
    shift
    for program in 'cpinn-solve bent.yaml' 'cpinn-train bent.yaml --out refused'; do
        run 2 $program "$@"
        said stderr.txt "$text"
        check one line -- test "$(wc -l <stderr.txt)" -eq 1
    done
}
refuse 'bent.yaml:18:32: data\[0\].file: .*bent_shape.csv: cannot be opened'
printf 's,x,y\n0.1,0,0\n' >bent_shape.csv
refuse "column 'z'"
printf 's,x,y,z\n0.3,0,0,0\n' >bent_shape.csv
refuse 'bent_shape.csv:2: s is 0.3; allowed: 0 to 0.2'
printf 's,x,y,z\n0.1,0,0,inf\n' >bent_shape.csv
refuse 'bent_shape.csv:2'
printf 's,x,y,z\n' >bent_shape.csv
refuse 'no rows'
printf 's,x,y,z\n0.1,0,0,0.1\n' >bent_shape.csv
refuse '3 measured numbers for 4 unknowns' --set 'rod.rest.curvature=[{identify: 0, range: [-1, 1]}, {identify: 0, range: [-1, 1]}, {identify: 0, range: [-1, 1]}]'
refuse 'are no measurements|give measurements' --set data=null
refuse 'outside its range' --set 'rod.stiffness.torsion={identify: 1, range: [2, 3]}'
refuse 'data\[0\].weight: is 0' --set 'data[0].weight=0'
cp "$scenes/bent_shape.csv" .
refuse 'data\[1\].noise: is needed' --set 'data=[{quantity: position, file: bent_shape.csv, noise: 1}, {quantity: position, file: bent_shape.csv}]'
refuse 'data\[1\].weight: is 2, of the first entry 1' --set 'data=[{quantity: position, file: bent_shape.csv, weight: 1}, {quantity: position, file: bent_shape.csv, weight: 2}]'

run 2 cpinn-solve "$scenes/stiffness.yaml" --at pull=9
said stderr.txt 'pull = 9 is outside its range'
run 2 cpinn-train "$scenes/bent.yaml" --set 'springs=[{at: {identify: 0.1, range: [0.05, 0.2]}, stiffness: [0, 0, 5]}]' --out refused
said stderr.txt 'springs\[0\].at: is to be identified, but has to be a number for a network'

finish
