#!/bin/bash
# Stiff and extreme scenes by cpinn-train and, where that makes sense, by cpinn-solve; each outcome
# beside the one that a user should expect: solved within a bound of error, refused or stopped with a
# reason, or answered with a warning. A wrong answer without a warning, a crash or an endless run is
# never expected. The scenes are those of stress_rows.sh.
#   tools/bench/stress.sh [--quick|--long] [--method network|solver] [--list] [NAME|SUBJECT...]
# --quick: those that take a moment; --long: those that take minutes, too; --list: what is expected,
# and why. Errors are of position, relative L2, unless a row says otherwise. Exit status 1: an outcome
# is not as expected. CPINN_BIN: where the programs are, if not in build/tools; CPINN_ROWS: other rows.
set -u
root=$(cd "$(dirname "$0")/../.." && pwd) || exit 2
bin=${CPINN_BIN:-$root/build/tools}
only=() selection=usual asked='network solver' list=
while [ $# -gt 0 ]; do
    case $1 in
    --quick | --long) selection=${1#--} ;;
    --method) asked=${2:?"--method: network or solver"} && shift ;;
    --list) list=yes ;;
    -*) echo "stress: $1: allowed: --quick, --long, --method NAME, --list" >&2 && exit 2 ;;
    *) only+=("$1") ;;
    esac
    shift
done
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 143' TERM
trap 'exit 130' INT
export XDG_CACHE_HOME=$work/cache
rows=0 surprises=0

# ---- closed forms, of rods of L = EI = 1, and rhoA = 1 where they move ------------------------------

# The tip of a cantilever along +z, at rest at t = 0, that a small force along +x bends: Euler and
# Bernoulli's modes (Meirovitch, Fundamentals of Vibrations, ch. 8). tip DURATION FORMULA of t and of
# step(t), its deflection t after a unit force has come to it for good.
tip() {
    awk -v last="$1" 'function step(t, mode, beta, sum) {
            sum = 0
            for (mode = 39; mode >= 0 && t > 0; mode--) { # cos beta cosh beta = -1
                beta = mode < 4 ? first[mode] : (mode + 0.5) * atan2(0, -1)
                sum += 4 / beta ^ 4 * (1 - cos(beta ^ 2 * t))
            }
            return sum
        }
        BEGIN {
            split("1.8751040687119611 4.6940911329741746 7.8547574382376126 10.995540734875467", all, " ")
            for (i = 0; i < 4; i++) first[i] = all[i + 1]
            print "s,t,x,y,z"
            for (i = 0; i <= 20; i++) { t = last * i / 20; printf "1,%.17g,%.17g,0,1\n", t, '"$2"' }
        }'
}

# The tip of configs/reference/slender_100.csv, which says how it was computed, in other units.
scaled() { # LENGTH TIME
    awk -v length_="$1" -v time="$2" 'BEGIN { print "s,t,x,y,z" }
        { printf "%.17g,%.17g,%.17g,0,%.17g\n", length_, time * $1, length_ * $2, length_ * $3 }' <<END
0 1 0
0.2 0.9987606079 -0.0322121322
0.4 0.9475101849 -0.2752857074
0.6 0.6306007611 -0.7096354092
0.8 0.1877552241 -0.8617899806
1 0.3097811115 -0.8494051796
END
}

# ---- what a row has ---------------------------------------------------------------------------------

about() {
    title=$1
}

row() { # NAME [quick|long]; its scene and the rest follow
    name=$1 kind=${2:-usual} motion=() sets=() solver_sets=() measure=position_relative_l2 tolerance= seconds=10
    rm -rf "$work"/*.csv
}

scene() { # texts of YAML
    printf '%s\n' "$@" >"$work/scene.yaml"
}

set_to() { # overrides, as for --set
    local text
    for text; do
        sets+=(--set "$text")
    done
}

solver_set() { # the same for the solver alone
    solver_sets=(--set "$1")
}

file() { # what is in reference.csv beside the scene
    printf "${1:+%s\n}" ${1:+"$1"} >"$work/reference.csv"
}

# ---- running it -------------------------------------------------------------------------------------

is_asked() { # METHOD
    [[ " $asked " == *" $1 "* ]] || return 1
    local one
    for one in ${only[@]+"${only[@]}"}; do
        case $name in "$one" | "$one"/*) return 0 ;; esac
    done
    [ ${#only[@]} -eq 0 ] && case $selection in
        quick) [ "$kind" = quick ] ;;
        long) true ;;
        *) [ "$kind" != long ] ;;
    esac
}

number() { # KEY of the report
    sed -nE "s/.*\"$1\": ([^,}]*).*/\1/p" "$work/report.json"
}

# Largest change of the energy of a motion, over the largest kinetic energy, from t = 0.9 on, when the
# force at its tip stays (-1, 0, 0): of a rod of L = EI = GJ = rhoA = 1 with this rotary inertia, by
# Simpson's rule over 65 places.
energy() { # TABLE INERTIA
    awk -F, -v rotary="$2" 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; split(rotary, J, " "); next }
        function of(name) { return $at[name] }
        of("t") > 0.9 - 1e-9 {
            k = int(64 * of("s") + 0.5)
            weight = (k == 0 || k == 64 ? 1 : k % 2 ? 4 : 2) / 192
            t = of("t")
            kinetic[t] += weight / 2 * (of("vx") ^ 2 + of("vy") ^ 2 + of("vz") ^ 2)
            for (i = 1; i <= 3; i++) {
                kinetic[t] += weight / 2 * J[i] * of("w" i) ^ 2
                stored[t] += weight / 2 * of("m" i) ^ 2
            }
            stored[t] += k == 64 ? of("x") : 0
            if (!(t in seen)) { seen[t] = 1; times[++count] = t }
        }
        END {
            for (i = 1; i <= count; i++) {
                now = kinetic[times[i]] + stored[times[i]]
                first = i == 1 ? now : first
                off = now - first > off ? now - first : first - now > off ? first - now : off
                most = kinetic[times[i]] > most ? kinetic[times[i]] : most
            }
            if (count > 100 && most > 0) printf "%.3e\n", off / most
        }' "$1"
}

# The solver's own estimate is what is known where it has only itself to be compared with.
error_of() { # METHOD
    local error
    if [ "$measure" = energy ]; then
        [ "$1" = solver ] || "$bin/cpinn-eval" "$work/run" --grid 65x201 --out "$work/motion.csv" --quiet >"$work/said" 2>&1
        energy "$work/motion.csv" "$([ "$1" = solver ] && echo 1e-4 1e-4 2e-4 || echo 0 0 0)"
        return
    fi
    error=$(number "$measure")
    if [ "$1" = solver ] && { [ -z "$error" ] || [ "$error" = null ] || grep -q '"name": "classical' "$work/report.json"; } &&
        [ "$measure" = position_relative_l2 ]; then
        error=$(number estimated_error)
    fi
    echo "${error/null/}"
}

network() { # solved BOUND | warning REASON[:BOUND] | refused TEXT | stopped TEXT; why
    is_asked network && judge network "$@" "$bin/cpinn-train" "$work/scene.yaml" --threads 1 \
        --out "$work/run" ${sets[@]+"${sets[@]}"}
    rm -rf "$work/run"
}

solver() { # as network
    [ "$measure" != energy ] || motion=(--grid 65x201 --out "$work/motion.csv")
    is_asked solver && judge solver "$@" "$bin/cpinn-solve" "$work/scene.yaml" ${motion[@]+"${motion[@]}"} \
        ${tolerance:+--tolerance "$tolerance"} ${sets[@]+"${sets[@]}"} ${solver_sets[@]+"${solver_sets[@]}"}
}

judge() { # METHOD OUTCOME DETAIL WHY COMMAND...
    local method=$1 expected=$2 detail=$3 why=$4 bound='' outcome error status good=yes
    shift 4
    case $expected in
    solved) bound=$detail ;;
    warning) case $detail in *:*) bound=${detail#*:} ;; esac ;;
    esac
    if [ -n "$list" ]; then
        printf '%s  %-26s %-8s %-15s %s\n' "${title:+
$title
}" "$name" "$method" "$expected ${bound}" "$why"
        title=
        return
    fi
    rm -f "$work/report.json"
    timeout $((10 * seconds + 30)) "$@" --json "$work/report.json" --quiet >"$work/said" 2>&1
    status=$?
    outcome=$(sed -nE 's/.*"verdict": \{"outcome": "([a-z]+)".*/\1/p' "$work/report.json" 2>/dev/null)
    outcome=${outcome:-status $status}
    error=
    case $outcome in solved | warning) error=$(error_of "$method" 2>/dev/null) ;; esac
    [ "$outcome" = "$expected" ] || good=
    case $expected in
    warning) [ "$detail" = none ] || grep -q "\"reason\": \"${detail%:*}\"" "$work/report.json" || good= ;;
    refused | stopped) grep -qF -- "$detail" "$work/said" || good= ;;
    esac
    if [ -n "$bound" ]; then
        awk -v e="${error:-nan}" -v b="$bound" 'BEGIN { exit !(e ~ /[0-9]/ && e + 0 <= b + 0) }' || good=
    fi
    rows=$((rows + 1))
    [ -n "$good" ] || surprises=$((surprises + 1))
    printf '%-26s %-8s %-15s %-9s %8s  %s\n' "$name" "$method" "$expected $bound" "$outcome" \
        "$(printf "${error:+%.1e}" ${error:+"$error"} 2>/dev/null)" \
        "$([ -n "$good" ] || echo 'not ')as expected"
    [ -n "$good" ] || head -2 "$work/said"
}

[ -n "$list" ] || printf '%-26s %-8s %-15s %-9s %8s  %s\n' scene method expected outcome error verdict
. "${CPINN_ROWS:-$root/tools/bench/stress_rows.sh}"
if [ -z "$list" ]; then
    echo "$rows rows, $surprises not as expected"
    [ "$rows" -gt 0 ] || { echo "stress: there is no such scene" >&2 && exit 2; }
    [ "$surprises" -eq 0 ]
fi
