#!/bin/bash
# The table of measured robots, from a folder with made-up data in the format of one set, and without.
#   test_measured.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
table=$ROOT/tools/measured.sh
export PATH

# ---- nothing there ------------------------------------------------------------------------------

mkdir empty
run 2 "$table" --out none empty
sets=$(ls "$ROOT"/tools/measured/*.sh | wc -l)
check a line for each set that is missing -- test "$(grep -c ': not there: .*https://github.com/' stderr.txt)" -eq "$sets"
said stderr.txt '^measured.sh: .*/empty: no set is there$'
check nothing else -- test "$(wc -l <stderr.txt)" -eq $((sets + 1))
refused '^measured.sh: nowhere: is no folder' "$table" nowhere
refused '^measured.sh: magic: is no set; allowed: .*sorosim' "$table" empty magic

# ---- equilibria of our own in SoRoSim's format ----------------------------------------------------

# Two members: gravity, and all loads at once. What is written has all digits, so that all is equal.
scene=$ROOT/configs/measured/sorosim.yaml
cat >members.csv <<'END'
gx,gy,gz,mid_mx,mid_my,mid_mz,mid_fx,mid_fy,mid_fz,tip_mx,tip_my,tip_mz,tip_fx,tip_fy,tip_fz
1,2,-9,0,0,0,0,0,0,0,0,0,0,0,0
-2,5,7,0.01,-0.02,0.03,0.1,-0.05,0.1,0.03,-0.01,0.02,-0.1,0.1,0.05
END
halves='0 0.0469 0.2308 0.5 0.7692 0.9531 1'
rod() { # name, length, keys
    local name=$1 length=$2
    shift 2
    for half in 0 1; do for s in $halves; do echo "$half $s"; done; done |
        awk -v l="$length" 'BEGIN { print "s" } NR != 8 { printf "%.10g\n", l / 2 * ($1 + $2) }' >stations.csv
    run 0 cpinn-solve "$scene" "$@" --members members.csv --points stations.csv --out shapes.csv
    awk -F, -v s="$halves" 'NR == FNR { if (FNR > 1) for (c = 1; c <= NF; c++) load[FNR - 1, c] = $c; next }
        FNR == 1 { for (c = 1; c <= NF; c++) at[$c] = c
            gsub(/ /, ",", s); print "rowLabel,gravity,mid_wrench,tip_wrench"; print "arclength,0,0,0," s "," s; next }
        { m = $at["member"]; i = ++count[m]; r[m, 1, i] = $at["x"]; r[m, 2, i] = $at["y"]; r[m, 3, i] = $at["z"] }
        END { for (m = 1; m <= 2; m++) for (k = 0; k < 6; k++) {
            line = "row," (k > 2 ? load[m, k - 2] : 0) "," load[m, 4 + k] "," load[m, 10 + k]
            for (i = 1; i <= 13; i++) for (n = 1; n <= 1 + (i == 7); n++)
                line = line "," (k > 2 ? r[m, k - 2, i] : 0)
            print line } }' members.csv shapes.csv >"$folder/${name}_dataStatics.csv"
}
folder=made/opencr-mujoco/data/reference/sorosim/sorosim_statics
mkdir -p $folder
rod SpringSteelRodMuJoCo 0.6
rod TPURodMuJoCo 0.4 --set rod.length=0.4 --set parameters.radius=0.005 --set loads.points[0].at=0.2 \
    --set rod.material.youngs_modulus=70e6 --set rod.material.poissons_ratio=0.4 --set rod.material.density=1200

column() { # of the row that begins so
    awk -F, -v row="$1" -v name="$2" 'NR == 1 { for (c = 1; c <= NF; c++) if ($c == name) at = c }
        index($2, row) == 1 { print $at }' out/table.csv
}
for kind in plain git; do
    run 0 "$table" --out out made sorosim
    check nothing on stderr -- test ! -s stderr.txt
    same stdout.txt out/table.md
    for rod in 'spring steel' TPU; do
        # Numbers are written with nine digits: off by less than 1e-9 m.
        check the $rod is the same -- test "$(column "$rod: positions worst" physics)" = 0.000
        check all coordinates of the $rod -- test "$(column "$rod: coordinates" physics)" = 100.00
        check two members of the $rod -- test "$(column "$rod: positions rms" rows)" = 2
    done
    if [ $kind = plain ]; then # the same as a bare git directory
        (cd made/opencr-mujoco && git init -q . && git add . &&
            git -c user.name=x -c user.email=x commit -q -m data && cd .. &&
            git clone -q --bare opencr-mujoco ContinuumRoboticsLab+opencr-mujoco && rm -rf opencr-mujoco)
    fi
done

# A member that is moved by a millimetre is seen.
cp -r out/sorosim/data made/opencr-mujoco && rm -rf made/Continuum*
sed -i '6s/,[^,]*$/,0.001/' "$folder/TPURodMuJoCo_dataStatics.csv"
run 0 "$table" --out out made sorosim
check it is seen -- test "$(column 'TPU: coordinates' physics)" != 100.00
rm "$folder/TPURodMuJoCo_dataStatics.csv"
run 1 "$table" --out out made sorosim
said stderr.txt '^sorosim: failed; see .*/out/sorosim$'

# ---- one coordinate is measured -------------------------------------------------------------------

# Heights of our own, of known numbers, with nine digits: what is found is these, and rows count though x and y
# are missing.
pazy=$ROOT/configs/measured/pazy.yaml
for mass in 0 1 2 3 0.5 1.5 2.5 3.5; do echo $mass; done | sed '1i mass' >masses.csv
run 0 cpinn-solve "$pazy" --members masses.csv --grid 2 --set parameters.factor=0.9 --set parameters.offset=0.01 \
    --set parameters.pan=0.05 --out heights.csv
awk -F, 'BEGIN { print "mass,s,x,y,z" } NR == FNR { mass[FNR - 1] = $1; next }
    FNR == 1 { for (c = 1; c <= NF; c++) if ($c == "z") at = c; next }
    FNR % 2 { print mass[(FNR - 1) / 2] ",0.54984,,," $at }' masses.csv heights.csv >bending.csv
run 0 cpinn-solve "$pazy" --data . --threads 1
said stdout.txt '^  factor +0\.9(0000|$| )'
said stdout.txt '^  bending.csv +4 +[0-9.]+e-(09|10|11|12) .* held out$'

# ---- cpinn-solve --members ------------------------------------------------------------------------

refused 'no family' cpinn-solve "$elastica" --members members.csv --out z.csv
printf 'force\n0.5\n' >forces.csv
run 0 cpinn-solve "$ROOT/configs/families/ramp.yaml" --members forces.csv --derivatives --grid 3x2 --out motions.csv
check derivatives of members in motion -- grep -q '^member,s,t,x,.*,w3_by_force$' motions.csv
# Of places that move points of rows are the same material: what is at p goes with it, the tip with l.
printf '%s\n' 'parameters: {l: {range: [0.2, 0.4]}, p: {range: [0.1, 0.19]}}' 'rod:' '  model: kirchhoff' '  length: l' \
    '  stiffness: {bending: [1, 1], torsion: 1}' '  inertia: {mass_per_length: 1, rotary: [0, 0, 0.1]}' \
    'boundary: {start: {type: clamped}}' 'bodies: [{at: p, mass: 1}]' 'time: {duration: 0.1}' >placed.yaml
printf 's,t\n0.17,0\n0.24,0\n0.31,0\n' >places.csv
run 0 cpinn-solve placed.yaml --at l=0.31,p=0.17 --method modes --derivatives --points places.csv --out placed.csv
check derivatives at places that move -- awk -F, 'NR == 1 { for (c = 1; c <= NF; c++) at[$c] = c; next }
    function off(a, b) { return a - b > 1e-9 || b - a > 1e-9 }
    { l = (NR - 2) / 2; bad += off($at["s"], 0.17 + 0.07 * (NR - 2)) + off($at["z"], $at["s"])
      bad += off($at["z_by_l"], l) + off($at["z_by_p"], 1 - l) }
    END { exit NR != 4 || bad > 0 }' placed.csv
refused '^cpinn-solve: --members: allowed beside it' cpinn-solve "$scene" --members members.csv --at gx=1 --out z.csv
refused 'nothing would be written' cpinn-solve "$scene" --members members.csv
refused '^cpinn-solve: --derivatives: allowed: of --members' cpinn-solve "$elastica" --derivatives
finish
