#!/bin/bash
# cpinn-show: pages of all that it reads, and what it refuses; files for ParaView.
#   test_show.sh BIN ROOT pages|browser
# With "browser" the picture is looked at, in Chromium; exit status 77 where there is none.
set -u
part=$3
. "$(dirname "$0")/programs.sh"
arm=$ROOT/configs/soft_arm.yaml
run 0 cpinn-solve "$arm" --grid 21x11 --out arm.csv
run 0 cpinn-show arm.csv --scene "$arm" --reference arm.csv
robot=$ROOT/configs/robots/soft_arm_control.yaml
loop() {
    run 0 cpinn-control "$robot" --set control.model=reduced --set control.duration=1.2 \
        --out loop.csv --shapes shapes.csv
    run 0 cpinn-show loop.csv --scene "$robot"
}

# Three poses of a rod that a tendon bends to an arc, k = T d/EI, of two markers in the axes of cameras that stand
# beside, turned by 90 degrees about z; rows of the last pose are held out, and its second marker is 2 mm higher than it
# should be. One number is missing.
measured() {
    local seen='quantity: position, file: seen.csv, marker: [0.01, 0, 0],
    frame: {position: [0.1, 0.2, 0.3], rotation: [1, 0, 0, 1]}'
    cat >pulled.yaml <<Y
parameters: {pull: {range: [0, 2]}}
rod: {model: kirchhoff, length: 0.2, stiffness: {bending: [3.0e-3, 3.0e-3], torsion: 2.0e-3}}
tendons: [{offset: [8e-3, 0], tension: pull}]
data:
  - {$seen, rows: {to: 4}}
  - {$seen, rows: {from: 5}, held_out: true}
Y
    awk 'BEGIN { print "pull,s,x,y,z"
        for (pose = 1; pose <= 3; pose++) for (m = 1; m <= 2; m++) {
            s = 0.1 * m; k = 0.5 * pose * 8e-3 / 3e-3
            x = (1 - cos(k * s)) / k + 0.01 * cos(k * s) - 0.1; y = -0.2
            z = sin(k * s) / k - 0.01 * sin(k * s) - 0.3 + (pose == 3 && m == 2 ? 2e-3 : 0)
            printf "%.17g,%.17g,%.17g,%s,%.17g\n", 0.5 * pose, s, y, pose == 2 && m == 1 ? "" : sprintf("%.17g", -x), z } }' >seen.csv
    run 0 cpinn-solve pulled.yaml --residuals rows.csv --json judged.json
    said stdout.txt '^  seen.csv +3 .*[0-9]$'
    said stdout.txt '^  seen.csv +2 +0.001414 +0.001 +0.001 +0.002 .* held out$'
    said stdout.txt '^wrote rows.csv: 6 rows; rows_shapes.h5 has the shapes, cpinn-show makes a page of both$'
    run 0 cpinn-show rows.csv
}
if [ "$part" = browser ]; then # a page of every kind
    measured
    step=(--set surrogate.kind=linear --set surrogate.solved=500 --set surrogate.step=0.05
        --set 'surrogate.modes=[1,1,1,1]' --set control.period=0.05)
    "$BIN/cpinn-train" "$robot" --quiet "${step[@]}" --out step 2>stderr.txt # which may be off
    run 0 cpinn-show step --out step.html
    said step.html '"off the solver"'
    said step.html 'reduced rod in two steps'
    run 0 cpinn-train "$ROOT/configs/robots/bensch_2024.yaml" --quiet --threads 1 --out family
    run 0 cpinn-show family --out family.html
    run 0 env PATH="$BIN" cpinn-show family --out swept.html
    run 0 cpinn-show "$ROOT/configs/robots/tendon_pulled.yaml" --out rest.html
    run 0 cpinn-cases "$ROOT/configs/elastica.yaml" --out cases
    run 0 cpinn-show cases --out cases.html
    loop
    [ "$failures" -eq 0 ] || exit 1
    python3 "$ROOT/tests/test_show.py" browser arm.html arm.csv arm.html rest.html family.html \
        swept.html step.html loop.html cases.html rows.html
    exit
fi
said stdout.txt '^wrote arm.html$'
python=0
command -v python3 >/dev/null || python=77
test $python = 77 || check numbers of the page -- \
    python3 "$ROOT/tests/test_show.py" structure arm.html arm.csv

# A run, with its verdict, history, reference and text; names cannot end the script.
sed 's/^rod:/name: "<script>\&"\nrod:/' "$arm" >named.yaml
run 0 cpinn-train named.yaml --quiet --threads 1 --out trained
run 0 cpinn-show trained --grid 21x11 --quiet
run 0 cpinn-eval trained --grid 21x11 --out trained.csv
check its own scripts alone -- test "$(grep -c '<script' trained/report.html)" -eq 2
check escaped -- grep -q '<title>&lt;script>&amp;</title>' trained/report.html
test $python = 77 || check numbers of a run -- \
    python3 "$ROOT/tests/test_show.py" structure trained/report.html trained.csv
said trained/report.html '"verdict": .*"outcome": "solved"'
said trained/report.html '"name": "classical solution'
said trained/report.html 'Training: loss and error'

# A body has the size that it has in a picture, by its place: 8 mm on a rod of 5 mm.
run 0 cpinn-show "$arm" --set 'bodies=[{at: 0.3, mass: 0.01}]' --set time=null --out body.html
bodies=$(tr -d '\n ' <body.html | grep -o '"bodies":.[^]]*')
check "size of a body: $bodies" -- grep -qE '"radius":0\.008(0+[0-9])?,' <<<"$bodies"

# A family: all of it, and one member.
run 0 cpinn-train "$ROOT/configs/robots/bensch_2024.yaml" --quiet --threads 1 --out family
run 0 env PATH="$BIN" cpinn-show family
said family/report.html '"labels": \["force = 0"'
said family/report.html 'Predicted error of the shape'
said family/report.html '"advice": "Shapes were computed beforehand. .*apt-get install clang lld'

# The workspace of two tendons, whose rod is an arc of curvature k = T d/EI: tips, singular values of
# their Jacobian by tensions over ranges of 1.9 and 0.9 N, curvature. An arc is a strain without
# modes, so that only rounding is left, which 0.01 N of tension may make a hundred times larger.
cat >arc.yaml <<'Y'
parameters:
  pull_x: {range: [0.1, 2]}
  pull_y: {range: [0.1, 1]}
rod:
  model: kirchhoff
  length: 0.2
  stiffness: {bending: [3.0e-3, 3.0e-3], torsion: 2.0e-3}
  section: {shape: circle, radius: 1.0e-3}
tendons:
  - {offset: [8e-3, 0], tension: pull_x}
  - {offset: [0, 8e-3], tension: pull_y}
Y
run 0 cpinn-show arc.yaml --workspace tips.csv --out arc_tips.html
said arc_tips.html '"says": "2000 of 2000 members all over the ranges; 0 are not trusted"'
said arc_tips.html '"largest curvature"'
awk -F, 'function abs(x) { return x < 0 ? -x : x }
    NR > 1 { L = 0.2; gain = 8e-3 / 3e-3; kx = gain * $1; ky = gain * $2; k = sqrt(kx^2 + ky^2)
        c = kx / k; s = ky / k; r = (1 - cos(k * L)) / k; over = r / k
        out = (k * L * sin(k * L) - (1 - cos(k * L))) / k^2
        up = (k * L * cos(k * L) - sin(k * L)) / k^2
        wide = 1.9 * gain; high = 0.9 * gain
        ax = (out * c^2 + over * s^2) * wide; ay = (out - over) * c * s * wide; az = up * c * wide
        bx = (out - over) * c * s * high; by = (out * s^2 + over * c^2) * high; bz = up * s * high
        aa = ax^2 + ay^2 + az^2; bb = bx^2 + by^2 + bz^2; ab = ax * bx + ay * by + az * bz
        most = sqrt((aa + bb) / 2 + sqrt((aa - bb)^2 / 4 + ab^2)); least = sqrt(aa * bb - ab^2) / most
        off = abs(r * c - $3) + abs(r * s - $4) + abs(sin(k * L) / k - $5) + abs(least - $6) \
            + abs(least / most - $7) + abs(k - $8) / k + abs(1e-3 * k - $9) / k
        if (off > worst) worst = off }
    END { printf "%d %g %d\n", NR, worst, worst < 1e-12 }' tips.csv >arc.txt
said arc.txt '^2001 .* 1$'

# A straight column loses its stability margin by its load, 1 - P/P_cr with pi^2/4 of EI/L^2; loads that follow
# the rod have none.
cat >column.yaml <<'Y'
parameters: {push: {range: [0, 2]}}
rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}}
loads: {tip: {force: [0, 0, -push]}}
Y
run 0 cpinn-show column.yaml --workspace column.csv --by stability --out column.html
said column.html '"by": "stability"'
said column.html '; strain needs rod.section'
check no column of strain -- sh -c '! grep -q strain column.csv'
refused 'allowed for this robot: dexterity, conditioning, curvature, stability, error' \
    cpinn-show column.yaml --by strain
said column.html '"least stability"'
awk -F, 'NR == 1 { for (k = 1; k <= NF; k++) at[$k] = k }
    NR > 1 { off = $(at["stability"]) - 1 + $1 / 2.4674011002723395; off = off < 0 ? -off : off
        if (off > worst) worst = off }
    END { printf "%d %g %d\n", NR, worst, worst < 1e-8 }' column.csv >column.txt
said column.txt '^2001 .* 1$'

# The colours of a picture are those from 1 % to 99 % of loads that are evenly spread: 1 - P/P_cr of 0.01 and 0.99
# times 2 N, to three digits.
run 0 cpinn-show column.yaml --by stability --out column.svg
for text in 'tips: stability' 0.198 0.992; do
    said column.svg ">$text<"
done
sed 's/-push]/-push], frame: follower/' column.yaml >follower.yaml
run 0 cpinn-show follower.yaml --workspace follower.csv --out follower.html
said follower.html 'not trusted; stability has no margin where loads have no energy'
check no column of it -- sh -c '! grep -q stability follower.csv'

# That of a network is the solver's: 1e-6 is what exported derivatives are tested to.
run 0 cpinn-show family --workspace network.csv --out network.png
run 0 cpinn-show "$ROOT/configs/robots/bensch_2024.yaml" --workspace solver.csv --out solver.svg
said solver.svg '>tips: dexterity<'
paste -d, network.csv solver.csv | awk -F, 'function abs(x) { return x < 0 ? -x : x }
    NR > 1 { n = NF / 2; for (k = 1; k <= n - 4; k++) {
        off = abs($k - $(k + n)) / (abs($(k + n)) + (k > 5 ? 0 : 0.2)); if (off > worst) worst = off } }
    END { printf "%d %g %d\n", NR, worst, worst < 1e-6 }' >both.txt
said both.txt '^2001 .* 1$'
refused 'workspace is of families at rest' cpinn-show arm.csv --workspace none.csv
refused 'workspace is of families at rest' cpinn-show family --at force=1,direction=0 --workspace none.csv
refused 'by is of families at rest' cpinn-show arm.csv --by strain
refused 'allowed: .csv' cpinn-show family --workspace none.txt

# What has come out of a port, whose place on the rod is another of each member.
run 0 cpinn-show "$ROOT/configs/families/insertion.yaml" --out inserted.html
said inserted.html '"moves": \["tension_1", "tension_2", "tension_3", "inserted", "turn"\]'

# Shapes that the page computes are those of exported C, whatever compiles it.
if command -v wasm-ld >node.txt && command -v node >node.txt; then
    run 0 cpinn-show family --out live.html
    run 0 cpinn-export family --c family --places "$(awk 'BEGIN {
        for (i = 0; i <= 60; i++) printf "%s%.17g", i ? "," : "", 0.2 * i / 60 }')"
    check shapes of C -- cc -std=c99 -O1 -DHEADER='"family.h"' -DNAME=family -I. -o shapes \
        "$ROOT/tests/export_shapes.c" family.c -lm
    check shapes without subnormal numbers -- ./shapes >shapes.json
    check shapes of the page -- node "$ROOT/tests/page_compare.js" live.html shapes.json
    check "size of the page: $(wc -c <live.html)" -- test "$(wc -c <live.html)" -lt 500000
else
    echo "skipped: shapes that a page computes, which need clang, wasm-ld and node"
fi
run 0 cpinn-show family --at force=2,direction=30 --out member.html
said member.html '"direction", "30"'

# What was measured beside what is computed: no unknowns, so that it is compared.
measured
said judged.json '"identified": null'
said judged.json '"judged": "held_out"'
sed -e 's/, 2\]/, 2.0e+5]/' pulled.yaml >huge.yaml # far beyond where a rod has ends
mkdir huge
sed '6,7s/^[^,]*/1.0e+5/' seen.csv >huge/seen.csv
run 3 cpinn-solve huge.yaml --data huge --residuals huge.csv
said stdout.txt '^warning \(misfit\): data\[1\]: there is no solution for 2 rows of seen.csv'
run 0 cpinn-show huge.csv
said huge.html '"worst": null'
test $python = 77 || check numbers of rows -- python3 "$ROOT/tests/test_show.py" residuals rows.html rows.csv
rm rows_shapes.h5
run 0 cpinn-show rows.csv --out without.html
check no shapes -- sh -c '! grep -q "\"motion\": {" without.html'
refused 'has no shapes for a picture' cpinn-show rows.csv --out rows.png
refused 'residuals: allowed: of a scene with data' cpinn-solve arc.yaml --at pull_x=1,pull_y=1 --residuals none.csv

# Other sources: a scene with tendons, a beam, a closed loop, a folder of tables and pictures.
run 0 cpinn-show "$ROOT/configs/robots/tendon_pulled.yaml" --out tendon.html
said tendon.html '"kind": "tendon"'
run 0 cpinn-show "$ROOT/configs/beam_cantilever.yaml" --out beam.html
printf 't,reference_x,reference_y,reference_z,true_x,true_y,true_z,input_p,input_q\n0,0,0,0,0,0,3e-3,1,2\n1,1,0,0,1,0,-4e-3,1,2\n' >place.csv
run 0 cpinn-show place.csv
said place.html '"at most", "4 mm"'
loop
# the ends of the shapes are the place that follows the path, true and as it is believed
awk -F, 'FNR == 1 { file++; for (i = 1; i <= NF; i++) at[file, $i] = i; next }
    file == 1 { for (k = 1; k <= 6; k++) place[FNR, k] = $(4 + k) }
    file == 2 && (FNR - 1) % 31 == 0 { tips++
        for (k = 1; k <= 6; k++) {
            of = $(at[2, k > 3 ? "estimated_" substr("xyz", k - 3, 1) : substr("xyz", k, 1)])
            wrong += (of - place[tips + 1, k]) ^ 2 > 1e-24 } }
    END { print tips, wrong + 0 }' loop.csv shapes.csv >tips.txt
said tips.txt '^61 0$'
run 0 cpinn-control "$robot" --set control.model=reduced --set control.duration=1.2 --shapes loop.vtkhdf
check shapes for ParaView -- test -s loop.vtkhdf
said loop.html '"verdict": .*"outcome": "solved"'
said loop.html '"as the filter believes"'
said loop.html '"name": "estimate_stiffness"'
run 0 cpinn-show "$robot" --at force1=1,force2=2,force3=3,stiffness=1 --grid 11x5 --out member.html
mkdir folder
printf 'case,seconds\na,1\n' >folder/cases.csv
printf '<svg xmlns="http://www.w3.org/2000/svg"/>' >folder/cases.svg
run 0 cpinn-show folder/
run 0 cpinn-show folder/cases.csv --out words.html
printf 'step,loss\n1,0.5\n2,0.25\n' >losses.csv
run 0 cpinn-show losses.csv
said losses.html '"title": "loss"'
said folder/report.html '"rows": \[\["case", "seconds"\], \["a", "1"\]\]'

# Pictures of shapes over time, in a plane and in space.
run 0 cpinn-show arm.csv --out still.svg
said still.svg '>tip \(' # with the place of the tip
run 0 cpinn-show "$ROOT/configs/helix.yaml" --out helix.png
check a picture -- test "$(head -c 8 helix.png | od -An -tx1 | tr -d ' ')" = 89504e470d0a1a0a

# What cannot be shown.
mkdir empty
refused 'there is nothing to show' cpinn-show empty
refused 'does not exist' cpinn-show nowhere
printf 's,x,y,z\n0,nan,nan,nan\n1,nan,nan,nan\n' >nowhere.csv
refused 'nowhere.csv: no place is a finite number' cpinn-show nowhere.csv
printf 's,t,x,y,z\n0,0,0,0,0\n1,0,0,0,1\n0,1,0,0,0\n' >uneven.csv
refused 'uneven.csv: rows 3 to 3 .* the first 2 are' cpinn-show uneven.csv

# ParaView.
run 0 cpinn-eval trained --grid 21x11 --out trained.vtkhdf
refused 'allowed: .csv, .h5, .hdf5, .npz, and for ParaView .vtkhdf' \
    cpinn-solve "$arm" --out arm.vtk
exit $((failures > 0))
