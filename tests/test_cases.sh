#!/bin/bash
# cpinn-cases: rows that succeed, are refused, run out of time; what it writes and refuses.
#   test_cases.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
command -v python3 >/dev/null || exit 77

# ---- a folder of cases ------------------------------------------------------------------------

mkdir few
cp "$ROOT/configs/elastica.yaml" few/b_bent.yaml
sed 's/elastica/nothing/' "$ROOT/configs/elastica.yaml" >few/c_wrong.yaml
cat >few/a_beam.yaml <<'END'
rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}}
beam: {force: -1}
reference: {deflection: -(6*s^2 - 4*s^3 + s^4)/24}
END
echo 'no case' >few/readme.txt
run 1 cpinn-cases few --threads 1 --out a
said stdout.txt '^case +method +position +rotation +seconds +size$'
said stdout.txt '^a_beam +mixed form by random waves +[0-9.]+e-(0[7-9]|1[0-9]) .* 4 unknowns, 4 equations$'
said stdout.txt \
    '^b_bent +mixed form by random waves +[0-9.]+e-(0[7-9]|1[0-9]) .* 6 unknowns, 6 equations$'
said stdout.txt '^ +collocation +[0-9.]+e-1[0-9] .* [0-9]+ nodes, [0-9]+ steps$'
said stdout.txt '^ +collocation +[0-9.]+e-1[0-9] .* [0-9]+ nodes$' # a linear scene
said stdout.txt '^c_wrong +network +- +- +[0-9.]+ +-$'
said stdout.txt '^ +refused \(bad_input\): few/c_wrong.yaml:[0-9]+:[0-9]+: reference.analytic: '
check nothing on stderr -- test ! -s stderr.txt
said a/cases.csv '^case,method,form,outcome,reason,position_error,rotation_error,seconds,unknowns,equations,points,steps$'
check two rows for each case, in order -- test \
    "$(cut -d, -f1,2 a/cases.csv | tail -n +2 | tr '\n' ' ')" = \
    'a_beam,network a_beam,solver b_bent,network b_bent,solver c_wrong,network c_wrong,solver '
said a/cases.csv '^b_bent,network,mixed form by random waves,solved,none,[0-9.e-]+,[0-9.e-]+,[0-9.e-]+,6,6,[0-9]+,'
said a/cases.csv '^c_wrong,solver,solver,refused,bad_input,nan,nan,'

# The same errors with several at a time, but for times.
run 1 cpinn-cases few --threads 1 --jobs 3 --out b
same <(cut -d, -f1-7,9- a/cases.csv) <(cut -d, -f1-7,9- b/cases.csv)

# ---- those without an answer -------------------------------------------------------------------

cat >refused.yaml <<'END'
rod: {model: cosserat, length: 1, stiffness: {bending: [1, 1], torsion: 1, shear: [9, 9], axial: 9}, inertia: {mass_per_length: 1, rotary: [0, 0, 0]}}
time: {duration: 1}
boundary: {start: {type: clamped}}
END
# Steps without end: what there is counts when the time is up.
sed 's/^ *steps: 5000$/      steps: 1000000000/' "$ROOT/configs/elastica_deep.yaml" >endless.yaml
run 1 cpinn-cases refused.yaml endless.yaml --threads 1 --seconds 2
said stdout.txt '^ +refused \(no_method\): .*: method collocation of a motion does not take a rod that shears without rotary inertia'
said stdout.txt '^endless +mixed form by a network +[0-9.]+e'
said stdout.txt '^ +out of time \(time_limit\): stopped after 2 s$'

# A load that is not reached whole has no answer, and no error of 0.
printf 's,x,y,z\n0,0,0,0\n1,0,0,0.6\n' >held.csv
cat >held.yaml <<'END'
rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}}
boundary: {end: {type: clamped, position: [0, 0, 0.6], rotation: [1, 0, 0, 0]}}
reference: {file: held.csv}
END
run 1 cpinn-solve held.yaml --json held.json
said held.json '"reason": "load_not_reached"'
said held.json '"position_relative_l2": null'

cpinn-cases endless.yaml "$elastica" --threads 1 --out cut >stdout.txt 2>stderr.txt &
pid=$!
for ((i = 0; i < 200; i++)); do # until it trains
    grep -q "^case" stdout.txt && break
    sleep 0.05
done
kill -TERM "$pid"
status=0
wait "$pid" || status=$?
pid=
check stopped by the signal -- test "$status" -eq 143
check no rows -- test "$(wc -l <stdout.txt)" -eq 1
check no table of nothing -- test ! -e cut/cases.csv

# ---- what is refused --------------------------------------------------------------------------

run 0 cpinn-cases --help
said stdout.txt '^usage: cpinn-cases '
mkdir empty
refused '^cpinn-cases: missing.yaml: No such file' cpinn-cases few missing.yaml
refused '^cpinn-cases: .*FOLDER' cpinn-cases
refused '^cpinn-cases: unknown option --no-such-option' cpinn-cases few --no-such-option
refused 'empty: holds no case' cpinn-cases empty
refused 'a: there is a table already' cpinn-cases few --out a
refused '^cpinn-cases: --seconds 0: allowed: a number > 0' cpinn-cases few --seconds 0
refused '^cpinn-cases: --jobs two: allowed' cpinn-cases few --jobs two
refused 'without mpirun or srun; --jobs N' env OMPI_COMM_WORLD_SIZE=2 cpinn-cases few
finish
