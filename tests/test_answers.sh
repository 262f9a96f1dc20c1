#!/bin/bash
# Answers for members of families as users get them: with their errors, from files, verified.
#   test_answers.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"

scene='parameters: {push: {range: [0.5, 2]}, stiff: {range: [0.8, 1.25], scale: log}}
rod: {model: kirchhoff, length: 1, stiffness: {bending: ["stiff", "stiff"], torsion: 1}}
boundary: {end: {type: loaded}}
loads: {tip: {force: ["push", 0, 0]}}'
cat >strain.yaml <<END
$scene
formulation: strain
network: {hidden: [16, 16]}
members: {solved: 500}
training: {stages: [{optimizer: adam, steps: 300}]}
END
cat >mixed.yaml <<END
$scene
network: {fourier: {features: 40}}
losses: {interior: {points: 20}, held_out_points: 50}
training: {stages: [{optimizer: gauss_newton, steps: 8}]}
END
cpinn-train strain.yaml --out strain --quiet --threads 1 >/dev/null 2>&1
cpinn-train mixed.yaml --out mixed --quiet --threads 1 >/dev/null 2>&1
check both are trained -- test -s strain/checkpoint.h5 -a -s mixed/checkpoint.h5

# tip_of FILE MEMBER: x at the end of a member
column() {
    head -1 "$1" | tr ',' '\n' | grep -nx "$2" | cut -d: -f1
}
value() { # FILE ROW COLUMN
    sed -n "$(($2 + 1))p" "$1" | cut -d, -f"$(column "$1" "$3")"
}
near() { # A B TOLERANCE
    awk -v a="$1" -v b="$2" -v t="$3" 'BEGIN { exit !(a - b <= t && b - a <= t) }'
}

# ---- one member -------------------------------------------------------------------------------

cpinn-solve mixed.yaml --at push=1.1,stiff=0.9 --grid 3 --out solved.csv --quiet
for run in strain mixed; do
    for polish in 0 1 2; do
        run 0 cpinn-eval $run --at 'push=1.1, stiff=0.9' --polish $polish --grid 3 --out one.csv
        said stdout.txt '^trusted, from network$'
        said stdout.txt 'predicted error +[0-9.]+e[-+][0-9]+ mm'
        check "the error of $run after $polish steps" -- near "$(value one.csv 3 x)" \
            "$(value solved.csv 3 x)" "$(value one.csv 3 error | awk '{ print 2 * $1 + 1e-6 }')"
    done
    check two steps leave nothing -- near "$(value one.csv 3 x)" "$(value solved.csv 3 x)" 2e-6
done
run 0 cpinn-eval strain --at push=1,stiff=1 --grid 3
said stdout.txt '^ +1000 +[0-9.]+ +0 +[0-9.]+$'
run 0 cpinn-eval strain --at push=1,stiff=1 --json -
said stdout.txt '"answer": \{"error": [0-9.e-]+, "network_error": [0-9.e-]+, "trusted": 1'
run 0 cpinn-eval strain
said stdout.txt '^family of 2 parameters: push 0.5 to 2, stiff 0.8 to 1.25$'
refused 'values are missing of stiff' cpinn-eval strain --at push=1
refused 'weight is no parameter' cpinn-eval strain --at push=1,weight=1
refused 'push is given twice' cpinn-eval strain --at push=1,push=1
refused 'push=nan.*allowed' cpinn-eval strain --at push=nan,stiff=1
refused '^cpinn-eval: --at: push = 3 is outside its range; allowed: 0.5 to 2, or with --extrapolate' \
    cpinn-eval strain --at push=3,stiff=1
run 0 cpinn-eval strain --at push=3,stiff=1 --extrapolate
said stderr.txt '^cpinn-eval: warning: extrapolated: 1 of 1 members are outside the range$'
run 3 cpinn-eval strain --at push=1,stiff=-1 --extrapolate
said stderr.txt '^cpinn-eval: warning: not trusted: 1 of 1 members: 1 refused$'
said stdout.txt '^not trusted, from nothing \(refused: '

# ---- files ------------------------------------------------------------------------------------

printf 'stiff,push\n1,0.5\n# a remark\n0.9,1.1\n1.25,2\n' >members.csv
run 0 cpinn-eval strain --members members.csv --grid 3 --out shapes.csv --threads 1
said stdout.txt '^3 members: 3 trusted'
said stdout.txt '^wrote shapes.csv: 9 rows$'
check a row for each place of each member -- test "$(wc -l <shapes.csv)" -eq 10
said shapes.csv '^member,s,x,y,z,qw,qx,qy,qz,v1,v2,v3,u1,u2,u3,error,trusted,outside,source,reason$'
check the member of the second row -- test "$(value shapes.csv 6 x)" = "$(value one.csv 3 x)" -o \
    "$(value shapes.csv 6 member)" = 2
run 0 cpinn-eval strain --members members.csv --grid 3 --out again.csv --threads 2
check the same for any number of threads -- cmp shapes.csv again.csv
run 0 cpinn-eval strain --members members.csv --out shapes.h5
run 0 cpinn-eval strain --members members.csv --out shapes.csv --json -
said stdout.txt '"members": \{"count": 3, "trusted": 3, "outside": 0, "from_network": 3'

bad_file() { # PATTERN CONTENT
    printf "$2" >bad.csv
    refused "$1" cpinn-eval strain --members bad.csv --out none.csv
}
bad_file "^bad.csv: column 'stiff' is missing; members have columns push, stiff" 'push\n1\n'
bad_file "^bad.csv: column 's' is no parameter" 'push,stiff,s\n1,1,1\n'
bad_file '^bad.csv:3:1: ' 'push,stiff\n1,1\nnan,1\n'
bad_file '^bad.csv:3: push = 5 is outside its range; allowed: 0.5 to 2, or with' \
    'push,stiff\n1,1\n5,1\n'
bad_file '^bad.csv: there are no rows' 'push,stiff\n'
run 0 cpinn-eval strain --members members.csv --out shapes.csv
printf 'push,stiff\n1,1\n5,1\n' >far.csv
run 0 cpinn-eval strain --members far.csv --out far_shapes.csv --grid 2 --extrapolate
check outside is marked -- test "$(value far_shapes.csv 2 outside)$(value far_shapes.csv 3 outside)" = 01
refused 'nothing would be written' cpinn-eval strain --members members.csv
refused 'allowed: one of them' cpinn-eval strain --at push=1,stiff=1 --verify 5
refused '--polish 3: allowed' cpinn-eval strain --at push=1,stiff=1 --polish 3
refused 'no_such.csv' cpinn-eval strain --members no_such.csv --out none.csv
cpinn-train "$elastica" --set 'training.stages=[{optimizer: adam, steps: 1}]' --out single --quiet >/dev/null 2>&1
refused 'the scene is no family' cpinn-eval single --verify 10

# ---- verified ---------------------------------------------------------------------------------

for run in strain mixed; do
    run 0 cpinn-eval $run --verify 200 --threads 1
    said stdout.txt '^200 fresh members \(seed 1\).*: 200 solved by the solver of members, 0 by'
    said stdout.txt '^product .* 0      0 '
    check nothing on stderr -- test ! -s stderr.txt
done
run 0 cpinn-eval strain --verify 200 --seed 2 --json -
said stdout.txt '"answers": "product", "median": [0-9.e-]+'
said stdout.txt '"wrong_though_trusted": 0'

finish
