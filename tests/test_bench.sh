#!/bin/bash
# cpinn-bench from end to end on a tiny elastica: what it says, writes, draws and refuses.
#   test_bench.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
command -v python3 >/dev/null || exit 77

mkdir parts
(cd parts && python3 "$ROOT/tests/test_bench.py" "$BIN" >parts.txt 2>&1) || failed "$(cat parts/parts.txt)"
rm -r parts

tiny=(--set losses.interior.points=16 --set losses.held_out_points=16 --threads 1 --seconds 60)
methods='first=adam:20,second=adam:10+lbfgs:10'

# ---- a comparison -----------------------------------------------------------------------------

printf '# by hand\nname,seconds,error\nslow one,1,0.1\nslow one,10,0.01\nquick,2,0.5\n' >others.csv
run 0 cpinn-bench "$elastica" "${tiny[@]}" --methods "$methods" --networks 1x4,2x4 --seeds 2 \
    --curve others.csv --out a
for file in runs.csv summary.csv curves.csv elastica_deep.gp about.txt; do
    check a comparison leaves "$file" -- test -s "a/$file"
done
check a line for each run -- test \
    "$(grep -c '^\[[1-8]/8\] elastica_deep .* every stage ended; warning: not_converged$' stdout.txt)" -eq 8
check no live lines in a pipe -- test -z "$(tr -dc '\r' <stdout.txt)"
said a/about.txt 'second = adam:10\+lbfgs:10'
said a/runs.csv '^scene,method,network,seed,seconds,step,error,held_out,loss,'
check rows that grow in time and step -- awk -F, 'NR > 1 { run = $2 $3 $4
    if (run == last && ($5 < t || $6 <= n)) exit 1
    last = run; t = $5; n = $6 }' a/runs.csv
check every run ends at step 20 -- awk -F, 'NR > 1 { run = $2 $3 $4
    if (NR > 2 && run != last && n != 20) { bad = 1; exit }
    last = run; n = $6 } END { exit bad || n != 20 }' a/runs.csv

# The summary is the median, here the mean of two, of the last rows; the table shows the same.
awk -F, 'NR > 1 { end[$2 "," $3 "," $4] = $7 }
    END { for (run in end) printf "%s,%.17g\n", run, end[run] }' a/runs.csv |
    awk -F, '{ sum[$1 "," $2] += $4 / 2 }
    END { for (cell in sum) printf "%s %.8e\n", cell, sum[cell] }' | sort >ends
awk -F, 'NR > 1 { printf "%s,%s %.8e\n", $2, $3, $9 }' a/summary.csv | sort >medians
same ends medians
check four medians -- test "$(wc -l <medians)" -eq 4
awk -F, 'NR > 1 { printf "%s %s %d %.1e\n", $2, $3, $4, $9 }' a/summary.csv >wanted
awk '$1 ~ /^(first|second)$/ { print $1, $2, $8, $15 }' stdout.txt >shown
same shown wanted

# The script holds the medians of curves.csv and the curves of others.
check four bands -- test "$(grep -c '^\$band[0-3] << END' a/elastica_deep.gp)" -eq 4
said a/elastica_deep.gp "title 'slow one'"
said a/elastica_deep.gp "title 'first, 2x4'"
last=$(awk -F, 'END { printf "%.6g %.6g %.6g %.6g", $4, $5, $6, $7 }' a/curves.csv)
check the last point is drawn -- grep -qxF "$last" a/elastica_deep.gp

check a picture -- test -s a/elastica_deep.svg -a -s a/elastica_deep.png
check nothing on stderr -- test ! -s stderr.txt
said a/elastica_deep.svg 'slow one'
rm a/elastica_deep.svg
(cd a && gnuplot elastica_deep.gp) || failed "the script does not draw by itself"
check it draws again -- test -s a/elastica_deep.svg

# In windows of time an error counts once it covers them all, which the last row does.
run 0 cpinn-bench "$dynamic" "${tiny[@]}" --methods w=adam:4 --set 'network.hidden=[4]' --seeds 1 \
    --set time.windows=2 --out w
check no error before the last window -- awk -F, 'NR > 1 && ($7 == "nan") != ($6 <= 4) { bad = 1 }
    $6 == 4 || $6 == 8 { ends++ } END { exit bad || ends != 2 }' w/runs.csv

# ---- folders ----------------------------------------------------------------------------------

before=$(contents a)
refused 'a: there are results already.*--out' cpinn-bench "$elastica" "${tiny[@]}" \
    --methods first=adam:2 --seeds 1 --out a
check a refusal changes nothing -- test "$before" = "$(contents a)"
short=("${tiny[@]}" --methods first=adam:2 --set 'network.hidden=[4]' --seeds 1 --quiet)
run 0 cpinn-bench "$elastica" "${short[@]}"
check quiet says nothing -- test ! -s stdout.txt
run 0 cpinn-bench "$elastica" "${short[@]}"
check two folders of our own -- test -s bench/elastica_deep/runs.csv -a -s bench/elastica_deep-2/runs.csv
rm -r bench
run 0 cpinn-bench "$elastica" "$ROOT/configs/rollup.yaml" "${short[@]}"
for scene in elastica_deep rollup; do
    check a picture of each scene -- test -s "bench/elastica_deep+rollup/$scene.gp"
done
check a line for each scene -- test "$(wc -l <bench/elastica_deep+rollup/summary.csv)" -eq 3
rm -r bench

# ---- without gnuplot, with one that fails, after a failure, after a signal ----------------------

mkdir empty
own=$(command -v cpinn-bench)
ln -s "$(command -v python3)" empty/
run 0 env PATH="$PWD/empty" "$(command -v python3)" "$own" "$elastica" "${short[@]}" --out b
check one line on stderr -- test "$(wc -l <stderr.txt)" -eq 1
said stderr.txt 'no picture, gnuplot is not installed; once it is: \(cd b && gnuplot elastica_deep.gp\)'
check everything else is there -- test -s b/runs.csv -a -s b/summary.csv -a -s b/elastica_deep.gp
printf '#!/bin/sh\necho "x.gp line 3: unknown terminal" >&2\nexit 1\n' >empty/gnuplot
chmod +x empty/gnuplot
run 0 env PATH="$PWD/empty:$PATH" "$own" "$elastica" "${short[@]}" --out c
said stderr.txt 'no picture, gnuplot failed: line 3: unknown terminal; to see: '
check one line on stderr -- test "$(wc -l <stderr.txt)" -eq 1

run 0 env PATH="$PWD/empty:$PATH" "$own" "$elastica" "${tiny[@]}" --out d --seeds 2 \
    --methods bad=adam:30,short=adam:1 --set 'training.stages[0].learning_rate=1e200'
said stdout.txt 'bad .* failed: step 2: loss term'
said stdout.txt '^  bad .* 2 of 2 failed'
check failed runs are counted -- awk -F, '$2 == "bad" { bad = $6 " " $9 }
    $2 == "short" { short = $6 } END { exit !(bad == "2 inf" && short == 0) }' d/summary.csv

"$own" "$elastica" "${tiny[@]}" --methods endless=lbfgs --seeds 3 --out e \
    --set 'training.stages[0].function_tolerance=0' >stopped.txt 2>&1 &
pid=$!
for ((i = 0; i < 400; i++)); do
    grep -qs 'runs of at most' stopped.txt && break
    sleep 0.05
done
kill -TERM "$pid"
status=0
wait "$pid" || status=$?
pid=
check stopped by the signal -- test "$status" -eq 143
check what there is was written -- test -s e/runs.csv -a -s e/summary.csv
said e/about.txt '^runs: [0-3] of 3$'

# ---- refusals ---------------------------------------------------------------------------------

# ---- the classical solver beside networks, with which sweeps have nothing to do -----------------

run 0 cpinn-bench "$ROOT/configs/heavy_cantilever.yaml" "${tiny[@]}" --methods solver --seeds 1 --out own
said stdout.txt '^  solver -       collocation .* [0-9.]*e-1[0-9]$' # its own reference, solved anew
run 0 cpinn-bench "$elastica" "${tiny[@]}" --methods first=adam:20,solver --networks 1x4,2x4 \
    --seeds 1 --out solved
check one line for the solver -- test "$(grep -c '^\[.*solver - seed .* every stage ended$' \
    stdout.txt)" -eq 1
check the solver is exact -- awk -F, '$2 == "solver" { error = $7 } END { exit !(error < 1e-12) }' \
    solved/runs.csv
said solved/elastica_deep.gp "'solver'"

bench() {
    cpinn-bench "$elastica" "${tiny[@]}" --out z "$@"
}
refused '^cpinn-bench: --methods quick: there is no such method' bench --methods quick
refused "^cpinn-bench: --methods adm:3: 'adm' is not an optimiser" bench --methods a=adm:3
refused '^cpinn-bench: --networks 2x: allowed: LAYERSxWIDTH' bench --networks 2x
refused '^cpinn-bench: --error size: allowed: position, tip, rotation' bench --error size
refused '^cpinn-bench: --seeds 0: allowed: an integer, 1 to 100' bench --seeds 0
refused '^cpinn-bench: --seconds 0: allowed' bench --seconds 0
refused '^cpinn-bench: override rod.lenth=1: ' bench --set rod.lenth=1
refused '^cpinn-bench: --set training.stages: .*--methods config' bench \
    --set 'training.stages=[{optimizer: adam}]'
refused '^cpinn-bench: --set network.fourier.features: ' bench --networks f4 --set network.fourier.features=3
refused '^cpinn-bench: --set network.hidden: ' bench --networks 1x4 --set 'network.hidden=[4]'
refused 'no_such.yaml: cannot be read' cpinn-bench no_such.yaml --out z
refused 'names no reference' bench --set reference.analytic=none
refused 'a scene called elastica_deep is there already' cpinn-bench "$elastica" "$elastica" --out z
refused 'one CONFIG.yaml at a time' cpinn-bench "$elastica" "$ROOT/configs/rollup.yaml" \
    --curve others.csv --out z
printf 'seconds,error\n1,1\n2,0\n' >bad.csv
refused '^cpinn-bench: bad.csv:3: error is 0; allowed: > 0' bench --curve bad.csv
refused 'no_such.csv' bench --curve x=no_such.csv
refused '^cpinn-bench: --error rotation: the reference cantilever_ramp.csv of .* does not know it' \
    cpinn-bench "$dynamic" --set losses.interior.points=16 --networks 1x4 --methods adam:1 \
    --error rotation --out z
echo data >file
refused '^cpinn-bench: file: ' cpinn-bench "$elastica" "${short[@]}" --out file

finish
