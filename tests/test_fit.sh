#!/bin/bash
# cpinn-fit as users run it: a file, overrides, tables, references, unknowns, and what it refuses.
#   test_fit.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"

# Heat in a bar with cold ends: u = exp(-pi^2 k t) sin(pi x).
cat >heat.yaml <<'END'
equations:
  coordinates:
    x: {range: [0, 1]}
    t: {range: [0, 0.5], time: true}
  parameters: {k: 0.4}
  fields: [u]
  inside: [u_t - k*u_xx]
  conditions:
    - {at: {t: 0}, u: sin(pi*x)}
    - {at: {x: 0}, u: 0}
    - {at: {x: 1}, u: 0}
fit: {tolerance: 1e-7, seconds: 60}
END
awk 'BEGIN { pi = atan2(0, -1); print "t,x,u"
    for (i = 0; i <= 10; i++) for (j = 0; j <= 10; j++) {
        x = i / 10; t = j / 20; printf "%.17g,%.17g,%.17g\n", t, x, exp(-pi ^ 2 * 0.4 * t) * sin(pi * x) } }' >exact.csv

# ---- what is solved -----------------------------------------------------------------------------

run 0 cpinn-fit heat.yaml --threads 1 --reference exact.csv --out u.csv --grid 5x3 --save u.h5 --json u.json
said stdout.txt '^heat: 1 field of x, t; '
said stdout.txt '^estimate: [0-9.e-]+$'
said stdout.txt '^error: [0-9.e-]+, largest [0-9.e-]+, of u at 121 points of exact.csv$'
said stdout.txt '^solved$'
check the error is within ten times its estimate -- awk '/^estimate/ { e = $2 + 0 } /^error/ { d = $2 + 0 }
    END { exit !(d <= 10 * e && e <= 1e-7) }' stdout.txt
check rows of the grid -- awk -F, 'NR == 1 && $0 != "x,t,u,error_u" { exit 1 } NR == 6 && ($1 != 0.25 || $2 != 0.25) { exit 1 }
    END { exit NR != 16 }' u.csv
gnuplot -e "table='u.csv'; field='u'" "$ROOT/configs/fit.gp" || failed the script does not draw
check a curve for each time -- test "$(grep -c 'id="gnuplot_plot_' u.csv.svg)" -eq 3
gnuplot -e "table='u.csv'; field='u'; map=1" "$ROOT/configs/fit.gp" || failed the script does not draw a map
check u.h5 is kept -- test -s u.h5
said u.json '"end": "converged", "estimated_error": '
said u.json '"reference": \{"name": "exact.csv", "points": 121, "field": "u", "relative_l2": '

# A reference that is of something else contradicts the estimate.
run 3 cpinn-fit heat.yaml --threads 1 --set equations.parameters.k=0.3 --reference exact.csv
said stdout.txt '^warning \(estimates_contradict\): the solution is [0-9.e-]+ off exact.csv'

# Places of a file.
printf 'x,t\n0.5,0.5\n' >places.csv
run 0 cpinn-fit heat.yaml --threads 1 --points places.csv --out places_u.csv --quiet
check nothing is said -- test ! -s stdout.txt -a ! -s stderr.txt
check the middle at the end -- awk -F, 'NR == 2 { pi = atan2(0, -1); d = $3 - exp(-pi ^ 2 * 0.2); exit !(d < 1e-6 && d > -1e-6) }' places_u.csv

# Too little time; not even the first window of time.
run 1 cpinn-fit heat.yaml --threads 1 --seconds 0.001
said stdout.txt '^out of time \(time_limit\): after [0-9.e-]+ s it has come to [0-9]+ % of the time; give it more seconds'

# Unknown numbers, and a parameter with a range.
run 0 cpinn-fit heat.yaml --threads 1 --set 'equations.parameters.k={guess: 0.2}' --set 'equations.data={file: exact.csv}'
check the unknown -- awk '$1 == "k" { found = $3 > 0.4 - 1e-5 && $3 < 0.4 + 1e-5 } END { exit !found }' stdout.txt
run 0 cpinn-fit heat.yaml --threads 1 --set 'equations.parameters.k={range: [0.3, 0.4]}' --tolerance 1e-3 \
    --grid 3x3x3 --out all.csv
check all values of the parameter -- awk -F, 'NR > 1 { pi = atan2(0, -1)
    d = $4 - exp(-pi ^ 2 * $3 * $2) * sin(pi * $1); if (d > 1e-4 || d < -1e-4) exit 1 } END { exit NR != 28 }' all.csv

# ---- what is refused ----------------------------------------------------------------------------

refused 'equations.inside: column 7 of .u_t - w.: unknown name .w.' cpinn-fit heat.yaml --set 'equations.inside=u_t - w'
refused 'elastica.yaml: has no equations; needed: a section equations. Scenes .* cpinn-train' cpinn-fit "$ROOT/configs/elastica.yaml"
refused 'heat.yaml:1:1: equations: is of no scene; cpinn-fit takes' cpinn-train heat.yaml
refused 'heat.yaml:1:1: equations: is of no scene; cpinn-fit takes' cpinn-solve heat.yaml
printf 'x,t\n2,0\n' >beyond.csv
printf 'x,v\n0,0\n' >lacks.csv
refused 'beyond.csv: row 1 has x = 2; allowed: 0 to 1' cpinn-fit heat.yaml --points beyond.csv --out no.csv
refused 'lacks.csv: has no column t; needed' cpinn-fit heat.yaml --reference lacks.csv
refused 'places.csv: has no column of a field' cpinn-fit heat.yaml --reference places.csv
refused '\-\-grid 3; allowed: 2 numbers of points' cpinn-fit heat.yaml --grid 3 --out no.csv
refused '\-\-grid is given; allowed: with --out' cpinn-fit heat.yaml --grid 3x3
refused 'none.yaml: cannot be read' cpinn-fit none.yaml
finish
