#!/bin/bash
# Own equations: error against run time, beside what others publish and beside DeepXDE.
#   tools/bench/equations.sh [--out DIR] [--tolerances "1e-2 1e-4"] [--seconds S] [case...]
#   tools/bench/equations.sh --variations DIR [--out DIR]
# Cases are those of configs/equations, each at every tolerance. DIR gets equations.csv, and with gnuplot
# equations.svg. configs/equations/published.csv has what others publish, peers.csv there what
# tools/bench/peers/equations.py and equations_jinns.py measured. --variations takes the files that
# configs/equations/reference.py --variations DIR wrote, at the tolerance of each, and says how many
# estimates are within ten times of the error.
set -u
root=$(cd "$(dirname "$0")/../.." && pwd) || exit 2
PATH=$PATH:$root/build/tools
scenes=$root/configs/equations
tolerances="1e-2 1e-4 1e-6 1e-8" seconds= out= variations= cases=()
while [ $# -gt 0 ]; do
    case $1 in
    --out) out=${2:?"--out: a folder is missing"} && shift 2 ;;
    --tolerances) tolerances=${2:?"--tolerances: numbers are missing"} && shift 2 ;;
    --seconds) seconds=${2:?"--seconds: a number is missing"} && shift 2 ;;
    --variations) variations=${2:?"--variations: a folder is missing"} && shift 2 ;;
    -*)
        echo "equations.sh: $1: allowed: --out, --tolerances, --seconds, --variations" >&2
        exit 2
        ;;
    *) cases+=("$1") && shift ;;
    esac
done
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
TIMEFORMAT='%R %U %S'
status=0

number() { # key of the program's JSON
    sed -n "s/.*\"$1\": *\([-+0-9.e]*\).*/\1/p" "$work/fit.json" | head -1
}

# Sets error, estimate, wall, cpu; "-" where the program says nothing.
fit() { # scene, reference, options of cpinn-fit
    local scene=$1 reference=$2
    shift 2
    rm -f "$work/fit.json"
    { time cpinn-fit "$scene" --reference "$reference" --json "$work/fit.json" --quiet "$@" \
        >"$work/log" 2>"$work/error"; } 2>"$work/time"
    case $? in
    0 | 1 | 3) ;; # 1: the time was over; 3: a warning, as one that the tolerance is not reached
    *) cat "$work/error" >&2 && status=1 ;;
    esac
    read -r wall user system <"$work/time"
    cpu=$(awk "BEGIN { printf \"%.2f\", $user + $system }")
    error=- estimate=-
    if [ -s "$work/fit.json" ]; then
        error=$(number relative_l2) estimate=$(number estimated_error)
        error=${error:+$(printf %.1e "$error")} estimate=${estimate:+$(printf %.1e "$estimate")}
        error=${error:--} estimate=${estimate:--}
    fi
}

table=$work/equations.csv
echo "case,tolerance,error,estimate,wall,cpu" >"$table"

if [ -n "$variations" ]; then
    printf '%-26s %9s %9s %6s %8s\n' case error estimate ratio 'CPU s'
    for scene in "$variations"/*.yaml; do
        name=$(basename "$scene" .yaml)
        fit "$scene" "${scene%.yaml}.csv" ${seconds:+--seconds "$seconds"}
        echo "$name,,$error,$estimate,$wall,$cpu" >>"$table"
        awk -v name="$name" -v e="$error" -v m="${estimate:--}" -v s="$cpu" 'BEGIN {
            ratio = (e > 0 && m > 0) ? sprintf("%.2g", m / e) : "-"
            printf "%-26s %9s %9s %6s %8s\n", name, e, m, ratio, s }'
    done
    # An estimate within rounding of the reference counts by its size, not by the ratio.
    awk -F, 'NR > 1 { all++; silent += !($4 > 0); near += $3 > 0 && ($4 < 10 * $3 || $4 < 1e-10) && $4 > $3 / 10 }
        END { printf "%d of %d estimates within ten times of the error; %d silent\n", near, all, silent }' "$table"
else
    if [ ${#cases[@]} -eq 0 ]; then
        mapfile -t cases < <(cd "$scenes" && basename -s .yaml -- *.yaml)
    fi
    printf 'relative L2 errors at the places of the reference; seconds of CPU, both cores together\n'
    for name in "${cases[@]}"; do
        printf '\n%-30s %9s %9s %8s %8s\n' "$name" error estimate 'CPU s' 'wall s'
        for tolerance in $tolerances; do
            fit "$scenes/$name.yaml" "$scenes/reference/$name.csv" --tolerance "$tolerance" \
                ${seconds:+--seconds "$seconds"}
            echo "$name,$tolerance,$error,$estimate,$wall,$cpu" >>"$table"
            printf '  %-28s %9s %9s %8s %8s\n' "cpinn, tolerance $tolerance" "$error" "$estimate" "$cpu" "$wall"
        done
        # The last row of each of DeepXDE's stages, and how much sooner the best of it is reached here.
        awk -F, -v name="$name" 'FNR == 1 { file++ }
            file == 1 && $1 == name { last[$2] = $0; if ($2 ~ /^DeepXDE/ && (!best || $5 < best)) { best = $5; took = $4 } }
            file == 2 && $1 == name && best && $3 > 0 && $3 <= best && (!ours || $6 < ours) { ours = $6 }
            END { for (m in last) { split(last[m], f, ",")
                      gsub(";", ",", m); printf "  %-28s %9.1e %9s %8s %8s\n", m, f[5], "-", f[4], f[3] }
                  if (ours && best < 0.1) printf "  the best of DeepXDE, %.1e in %s s, is reached %.0f times sooner\n", best, took, took / ours }' \
            "$scenes/peers.csv" "$table"
        awk -F, -v name="$name" '$1 == name { printf "  %-28s %9s %9s %8s %8s  %s\n", "published", $3, "-", "-",
            $4 == "" ? "-" : $4, $2 }' "$scenes/published.csv"
    done
fi

if [ -n "$out" ]; then
    mkdir -p "$out" && cp "$table" "$out/equations.csv" || exit 1
    if [ -z "$variations" ] && command -v gnuplot >/dev/null; then
        {
            echo 'set terminal svg size 960,1280 dynamic font "sans,11" background rgb "white"'
            echo 'set output "equations.svg"'
            echo 'set datafile separator ","'
            echo 'set logscale; set format "10^{%L}"; set grid lt 1 lw 0.6 lc rgb "#DDDDDD"'
            echo 'set xrange [0.01:3000]; set yrange [1e-13:3]; set key bottom left'
            echo "set multiplot layout $(((${#cases[@]} + 2) / 3)),3"
            for name in "${cases[@]}"; do
                echo "\$ours << END"
                awk -F, -v name="$name" '$1 == name && $3 > 0 { print $6 "," $3 "," $4 }' "$table"
                echo "END"
                echo "\$deepxde << END"
                awk -F, -v name="$name" '$1 == name && /DeepXDE/ { print $4 "," $5 }' "$scenes/peers.csv"
                echo "END"
                echo "set title \"${name//_/ }\" noenhanced; set xlabel \"CPU s\"; set ylabel \"error\""
                lines=$(awk -F, -v name="$name" '$1 == name { printf ", %s with lines dt 2 lc rgb \"#999999\" title \"%s\"",
                    $3, (n++ ? "" : "published") }' "$scenes/published.csv")
                echo "plot \$ours using 1:2 with linespoints pt 7 ps 0.5 lc rgb \"#0060AD\" title \"cpinn\"," \
                    "\$ours using 1:3 with points pt 6 lc rgb \"#0060AD\" title \"its estimate\"," \
                    "\$deepxde using 1:2 with lines lc rgb \"#DD6600\" title \"DeepXDE\"$lines" |
                    if grep -q "^$name,DeepXDE" "$scenes/peers.csv"; then cat; else sed 's/\$deepxde[^,]*"DeepXDE",*//; s/, *$//'; fi
            done
            echo 'unset multiplot'
        } >"$out/equations.gp"
        (cd "$out" && gnuplot equations.gp) || status=1
    fi
fi
exit $status
