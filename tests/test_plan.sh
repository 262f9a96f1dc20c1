#!/bin/bash
# What cpinn-plan says, writes and refuses.
#   test_plan.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
cp "$ROOT/configs/plan/lumen.yaml" .
sh "$ROOT/configs/plan/lumen.sh" >lumen.obj

run 0 cpinn-plan --help
said stdout.txt '^  not_certified '
said stdout.txt '^  none_found '
got=0
cpinn-plan lumen.yaml >stdout.txt 2>stderr.txt || got=$?
if grep -q '^cpinn-plan: this build has no ' stderr.txt; then
    check "exit 2 without its libraries" -- test "$got" -eq 2
    check "one line" -- test "$(wc -l <stderr.txt)" -eq 1
    exit 77
fi

# ---- a way --------------------------------------------------------------------------------------

check "exit 0: $(cat stderr.txt)" -- test "$got" -eq 0
said stdout.txt '^lumen: 5 variables: pull_1 0 to 4, .*, slide -0\.15 to 0\.05, turn '
said stdout.txt '^surface of 4896 triangles; grid of .* mm, made$'
said stdout.txt '^search by the solver'
said stdout.txt '^solved$'
check "the grid is kept" -- test -s lumen.distances.h5
# Each part is told, and what is left follows.
awk '/^  (distance|radius|rounding|shape|unknown|between|left) / {
    left = $NF; sum += $1 == "distance" ? $NF : $1 == "left" ? -$NF : -$NF
    rows++
} END { exit !(rows == 8 && left >= 2 && sum * sum < 1e-6) }' stdout.txt ||
    failed "parts do not add up: $(cat stdout.txt)"

harder=(lumen.yaml --set plan.clearance=0.008)
run 0 cpinn-plan "${harder[@]}" --out way.csv
said stdout.txt 'grid of .* mm, from its file$'
run 0 cpinn-plan "${harder[@]}" --out again.csv --quiet
check "nothing is printed" -- test ! -s stdout.txt
check "the same seed finds the same way" -- cmp way.csv again.csv
run 0 cpinn-plan "${harder[@]}" --seed 9 --json -
said stdout.txt '"outcome": "solved"'
said stdout.txt '"certificate": {"holds": "yes", '
check "columns" -- test "$(head -1 way.csv)" = \
    pull_1,pull_2,pull_3,slide,turn,left,left_on_way,s,distance,radius,rounding,shape,unknown,between_points,tip_x,tip_y,tip_z
# Rows begin at the start, keep the clearance, and end with the tip at the goal.
awk -F, 'NR == 2 { ok = $1 == 0 && $4 == -0.15 && $17 > 0.0499999 && $17 < 0.0500001 }
    NR > 1 { ok = ok && $6 >= 0.008 && $7 >= 0.008 && $7 <= $6
        off = sqrt(($15 - 0.045)^2 + $16^2 + ($17 - 0.108)^2) }
    END { exit !(ok && NR > 2 && off < 0.001) }' way.csv || failed "$(cat way.csv)"
run 0 cpinn-plan "${harder[@]}" --shapes shapes.csv --quiet
awk -F, 'NR == 1 { ok = $0 == "t,s,x,y,z,radius,left" }
    NR > 1 { ok = ok && $6 == 0.009 && $7 >= 0.008; frames = $1 + 1 }
    END { exit !(ok && NR == 1 + frames * 121) }' shapes.csv || failed "$(head -3 shapes.csv)"
check "a row for each shape" -- test "$(tail -1 shapes.csv | cut -d, -f1)" -eq $(($(wc -l <way.csv) - 2))
# Its picture has the wall as glass, and what is left as colours.
run 0 cpinn-show shapes.csv --wall lumen.yaml --out shapes.svg --quiet
check "glass" -- test "$(grep -o 'fill-opacity' shapes.svg | wc -l)" -gt 1000
said shapes.svg '>left<'
run 0 cpinn-show shapes.csv --wall lumen.yaml --out shapes.html --quiet
if command -v python3 >/dev/null; then
    check "the wall of the page" -- python3 "$ROOT/tests/test_show.py" wall shapes.html lumen.obj
    python3 "$ROOT/tests/test_show.py" looks shapes.html || test $? = 77 || failed "the page with a wall"
fi
refused 'plan\.environment\.file: is not given, and --wall shows it; allowed: \.stl, \.obj' \
    cpinn-show shapes.csv --wall "$ROOT/configs/robots/tendon_family.yaml"
refused 'way.csv: --wall is of tables of shapes' cpinn-show way.csv --wall lumen.yaml --out no.html
# Goals in order, and how the tip points there.
places=(lumen.yaml --set plan.goal=null --set)
first='{position: [0.045, 0, 0.108]}' back='{position: [0, 0, 0.05]}'
run 0 cpinn-plan "${places[@]}" \
    "plan.goals=[$first, $back, {position: [0.045, 0, 0.108], direction: [2, 0, 2], angle: 0.5}]" --out goals.csv
said stdout.txt '^3 goals, [0-9]+ configurations; 3 searches, '
# Each at the row that is told.
awk -F, 'NR == FNR { if (/^goal . of 3 is reached at row/) { split($0, word, " "); row[word[2]] = word[9] }; next }
    FNR > 1 { for (k = 1; k <= 3; k++) if (row[k] == FNR - 1) {
        off = sqrt(($15 - (k == 2 ? 0 : 0.045))^2 + $16^2 + ($17 - (k == 2 ? 0.05 : 0.108))^2); good += off < 2e-4 } }
    END { exit !(good == 3 && row[3] == FNR - 1) }' stdout.txt goals.csv || failed "$(cat stdout.txt)"
run 3 cpinn-plan "${places[@]}" "plan.goals=[$first, {position: [0.045, 0, 0.4]}, {position: [0.045, 0.02, 0.08]}]"
said stdout.txt '^goal 1 of 3 is not tried$'
said stdout.txt '^goal 2 of 3 is out of reach: the tip comes to [0-9.]+ mm of it at nearest$'
said stdout.txt '^the tip reaches goal 3 of 3, but no such shape '
said stdout.txt '^warning \(none_found\): goal 2 of 3 is out of reach: the tip comes to [0-9.]+ mm of it at nearest$'
run 3 cpinn-plan lumen.yaml --set plan.goal.direction=[1,0,0]
said stdout.txt 'the goal is out of reach: the tip comes to [0-9.]+ mm of it and [0-9.]+ rad of its direction at nearest$'
# A roadmap in a file, for this surface and others.
map=(lumen.yaml --set plan.roadmap.file=map.h5 --set plan.roadmap.nodes=100)
run 0 cpinn-plan "${map[@]}"
said stdout.txt '^roadmap of 100 nodes and [0-9]+ edges, made, '
cp map.h5 kept.h5
run 0 cpinn-plan "${map[@]}"
said stdout.txt '^roadmap of 100 nodes and [0-9]+ edges, from its file, '
watched || run 0 cpinn-plan "${map[@]}" --set plan.environment.position=[0,0,0.001]
watched || said stdout.txt '^roadmap of .* edges, of another surface: its ways are looked at again, '
run 0 cpinn-plan "${map[@]}" --set plan.clearance=0.004
said stdout.txt '^roadmap of .* edges, of less clearance: its ways are looked at again, '
run 0 cpinn-plan "${map[@]}" --set rod.material.youngs_modulus=61e9
said stdout.txt '^roadmap of .* edges, of another robot or network: its ways are looked at again, '
run 0 cpinn-plan "${map[@]}" --set plan.environment.side=any --json -
said stdout.txt '"roadmap": \{"file": ".*map.h5", "nodes": 100, "edges": [0-9]+, "is": "of another surface'
check "the roadmap stays as it is" -- cmp map.h5 kept.h5
refused 'plan\.roadmap\.file: .*map\.h5: is a roadmap of other variables: pull_1 0 to 4, .*; allowed: pull_1 0 to 4' \
    cpinn-plan "${map[@]}" --set plan.slide=[-0.15,0.06]
refused 'plan\.roadmap\.file: .*lumen\.obj' cpinn-plan "${map[@]}" --set plan.roadmap.file=lumen.obj
refused 'plan\.roadmap\.nodes: is 1, which is out of range; allowed: a whole number 10 to' cpinn-plan "${map[@]}" --set plan.roadmap.nodes=1
if ! watched; then
    for planner in rrt_star prm; do
        run 0 cpinn-plan lumen.yaml --set plan.planner=$planner --set plan.states=3000
        said stdout.txt '^solved$'
    done
    run 0 cpinn-plan lumen.yaml --compile --threads 1 --json -
    said stdout.txt '"by": "solver", "error": 2.*e-05, .* "processor_seconds": [0-9]'
    # Searched by a network, which says how far it is off.
    run 0 cpinn-train lumen.yaml --quiet
    run 0 cpinn-plan "${harder[@]}"
    said stdout.txt '^search by the network in runs/lumen, off by [0-9.]*e-[0-9]+ m at worst of [45][0-9]+ members$'
    said stdout.txt '^solved$'
    rm -r runs
fi

# ---- no way -------------------------------------------------------------------------------------

run 3 cpinn-plan lumen.yaml --set plan.goal.position=[0.045,0,0.4]
said stdout.txt '^warning \(none_found\): the goal is out of reach: the tip comes to [0-9.]+ mm of it '
run 3 cpinn-plan lumen.yaml --set plan.goal.position=[0.045,0.02,0.08] --quiet
said stderr.txt '^cpinn-plan: warning \(none_found\): the tip reaches the goal, but no such shape '
check "no table without a way" -- test ! -e none.csv

# ---- refused ------------------------------------------------------------------------------------

refused 'lumen.obj: is [0-9]+ m across, and the robot 0.2 m long; is its unit another' \
    cpinn-plan lumen.yaml --set plan.environment.unit=m
head -n -1 lumen.obj >open.obj
refused 'open.obj:[0-9]+: near \(.*\) m the surface is open' \
    cpinn-plan lumen.yaml --set plan.environment.file=open.obj
head -n 9 lumen.obj >cut.obj
awk '$1 == "f" { print NF == 4 ? "f " $4 " " $3 " " $2 : "f " $5 " " $4 " " $3 " " $2; next } 1' \
    lumen.obj >inverted.obj
refused 'inverted.obj: is inside out' cpinn-plan lumen.yaml --set plan.environment.file=inverted.obj
refused 'cut.obj: has no triangles' cpinn-plan lumen.yaml --set plan.environment.file=cut.obj
refused 'plan\.start: .*too near to the surface there: of 2 mm, -' \
    cpinn-plan lumen.yaml --set plan.start=[4,0,0,0,0]
refused 'plan\.start: .*too near to the surface there: of 2 mm, -' \
    cpinn-plan lumen.yaml --set plan.environment.side=outside
refused 'plan\.start: .*has 3 numbers; the robot has 5 variables' \
    cpinn-plan lumen.yaml --set plan.start=[0,0,0]
refused 'plan\.start: .*pull_1 = 5 is outside its range; allowed: 0 to 4' \
    cpinn-plan lumen.yaml --set plan.start=[5,0,0,0,0]
refused 'plan\.goal\.position: is not given' cpinn-plan lumen.yaml --set plan.goal=null
refused 'plan\.goal\.direction: has no length; allowed: not all three 0' \
    cpinn-plan lumen.yaml --set plan.goal.direction=[0,0,0]
refused 'plan\.goals: are given beside plan\.goal; allowed: one of the two' \
    cpinn-plan lumen.yaml --set "plan.goals=[$first]"
refused 'plan\.goals\[1\]\.position: is not given; allowed: three numbers \(m\), or plan\.goals\[1\]\.actuators' \
    cpinn-plan "${places[@]}" "plan.goals=[$first, {tolerance: 0.001}]"
refused 'plan\.goals\[0\]\.actuators: .*has 2 numbers; the robot has 5 variables' \
    cpinn-plan "${places[@]}" "plan.goals=[{actuators: [0, 0]}]"
refused 'plan\.radius: is not given' cpinn-plan lumen.yaml --set plan.radius=null
refused 'plan\.fixed: .*pull_9=1 is not NAME=VALUE' \
    cpinn-plan lumen.yaml --set plan.fixed=[pull_9=1]
refused 'plan\.actuators: .*pull_9 is no parameter' \
    cpinn-plan lumen.yaml --set plan.actuators=[pull_9]
refused 'plan\.slide: is for scenes where only actuators act' \
    cpinn-plan lumen.yaml --set loads.gravity=[0,0,-9.81]
refused 'plan\.unknown: .*pull_1 is given twice, or fixed' \
    cpinn-plan lumen.yaml --set plan.unknown=[pull_1] --set plan.fixed=[pull_1=0]
refused 'has no section plan' cpinn-plan "$ROOT/configs/robots/tendon_family.yaml"

finish
