#!/bin/bash
# cpinn-cases: rows that succeed, are refused, run out of time; what it writes and refuses.
#   test_cases.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"

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
said stdout.txt '^case +method +position +rotation +seconds +size +left out$'
said stdout.txt '^a_beam +mixed form by random waves +[0-9.]+e-(0[7-9]|1[0-9]) .* time, shear$'
said stdout.txt \
    '^b_bent +mixed form by random waves +[0-9.]+e-(0[7-9]|1[0-9]) .* 6 unknowns, 6 equations +time, out of plane, shear, stretch$'
said stdout.txt '^ +collocation +[0-9.]+e-1[0-9] .* [0-9]+ nodes, [0-9]+ steps +time$'
said stdout.txt '^c_wrong +network +- +- +- +- +-$'
said stdout.txt '^ +refused \(bad_input\): few/c_wrong.yaml:[0-9]+:[0-9]+: reference.analytic: '
check nothing on stderr -- test ! -s stderr.txt
said a/cases.csv '^case,method,form,outcome,reason,left_out,position_error,rotation_error,seconds,unknowns,equations,instructions,points,steps$'
check two rows for each case, in order -- test \
    "$(cut -d, -f1,2 a/cases.csv | tail -n +2 | tr '\n' ' ')" = \
    'a_beam,network a_beam,solver b_bent,network b_bent,solver c_wrong,network c_wrong,solver '
said a/cases.csv '^b_bent,network,mixed form by random waves,solved,none,time; out of plane; shear; stretch,[0-9.e-]+,[0-9.e-]+,[0-9.e-]+,6,6,[0-9]+,'
said a/cases.csv '^c_wrong,solver,solver,refused,bad_input,nothing,nan,nan,nan,'
check the same as HDF5 -- test -s a/cases.h5

# ---- one that takes too long, one that the solver refuses -------------------------------------

cat >refused.yaml <<'END'
rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}, inertia: {mass_per_length: 1, rotary: [0, 0, 0]}}
time: {duration: 1}
boundary: {start: {type: clamped}}
END
run 1 cpinn-cases refused.yaml "$dynamic" --threads 1 --seconds 0.01
said stdout.txt '^refused +strain modes by polynomials '
said stdout.txt '^ +refused \(no_method\): method collocation of a motion does not take a rod without shear and rotary inertia'
said stdout.txt '^ +out of time \(time_limit\): 0.01 s in window 1 of 1$'
check four rows -- test "$(grep -cE '^[a-z_]* +(strain modes by polynomials|network|mixed form by a network|solver|spectral elements) ' stdout.txt)" -eq 4

# ---- what is refused --------------------------------------------------------------------------

run 0 cpinn-cases --help
said stdout.txt '^usage: cpinn-cases '
mkdir empty
refused '^cpinn-cases: .*missing.yaml: No such file' cpinn-cases few missing.yaml
refused '^cpinn-cases: .*operand|FOLDER' cpinn-cases
refused 'empty: holds no case' cpinn-cases empty
refused 'a: there is a table already' cpinn-cases few --out a
refused '^cpinn-cases: --seconds 0: allowed' cpinn-cases few --seconds 0
finish
