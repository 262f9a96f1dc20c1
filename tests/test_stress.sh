#!/bin/bash
# Stiff and extreme scenes are answered as expected, and a row that is not so is found.
#   test_stress.sh PROGRAMS ROOT
. "$(dirname "$0")/programs.sh"
stress=("$ROOT/tools/bench/stress.sh")
export CPINN_BIN=$BIN

run 0 "${stress[@]}" --quick
said stdout.txt '^file/nan +solver +solved 1e-9 +solved .* as expected$'
check a hundred rows -- test "$(grep -c '/.* as expected$' stdout.txt)" -ge 100
run 0 "${stress[@]}" --list --quick slender
said stdout.txt '^  slender/10 +network +solved 1e-6 '

cat >wrong.sh <<'END'
scene_of() {
    scene 'rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}}' \
        "loads: {tip: {force: [$1, 0, 0]}}" "$2"
}
row wrong/bound
    scene_of 100 'reference: {analytic: elastica}'
    network solved 1e-12 'too small a bound'
    solver solved 1e-9 'right'
row wrong/reason
    scene_of 100 'reference: {analytic: elastica}'
    network warning unstable 'it is solved'
    solver refused 'rod.length' 'it is solved'
row wrong/text
    scene_of .nan 'reference: {analytic: elastica}'
    network refused 'rod.length' 'another key'
    solver refused 'loads.tip.force' 'right'
row wrong/file
    scene_of 100 'reference: {file: reference.csv}'
    network solved 1e-9 'there is no file'
END
run 1 env CPINN_ROWS=wrong.sh "${stress[@]}"
check what is right -- test "$(awk '/ as expected$/ && !/not as expected/ { print $1, $2 }' stdout.txt)" = 'wrong/bound solver
wrong/text solver'
said stdout.txt '^7 rows, 5 not as expected$'
run 2 "${stress[@]}" nothing
run 2 "${stress[@]}" --magic
finish
