#!/bin/bash
# The published query of Bentley, Rucker and Kuntz (2022): time, success and clearance over seeds.
#   bentley.sh FOLDER [SEEDS [OPTION...]]
# FOLDER has problem.toml's mesh, data/env-mesh.stl of Kuntz-Lab/Tendon_Robot_Learning, as a clone or a bare git
# directory. SEEDS are 100 unless given; OPTIONs are those of cpinn-plan, such as --compile. Times are those of one
# thread's processor, then of the clock, in ms. Start and goal are looked at before, and are not within them.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
PATH=$PATH:$root/build/tools
[ $# -gt 0 ] || { sed -n '2,6s/^# //p' "$0" >&2; exit 2; }
folder=$1 seeds=${2:-100}
shift $(($# > 1 ? 2 : 1))
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ -e "$folder/data/env-mesh.stl" ]; then
    cp "$folder/data/env-mesh.stl" "$work"
else
    git -C "$folder" show HEAD:data/env-mesh.stl >"$work/env-mesh.stl"
fi

# The i-th number of that key on the line that is read.
number() { grep -o "\"$1\": [-0-9.e+]*" "$work/one.json" | sed -n "${2:-1}s/.*: //p"; }

for seed in $(seq "$seeds"); do
    got=0
    cpinn-plan "$root/configs/plan/bentley.yaml" --set plan.environment.file="$work/env-mesh.stl" --seed "$seed" \
        --threads 1 --quiet --json "$work/one.json" "$@" 2>"$work/said.txt" || got=$?
    [ $got = 0 ] || [ $got = 3 ] || { cat "$work/said.txt" >&2; exit $got; }
    echo "$got $(number processor_seconds) $(number processor_seconds 2) $(number seconds) $(number seconds 2)" \
        "$(number configurations) $(number shapes) $(number left) $(number searches)"
done >"$work/rows.txt"
awk '{ certified += $1 == 0
       if ($1 == 0) { n++; ms[1, n] = 1e3 * $2; ms[2, n] = 1e3 * $3; ms[3, n] = ms[1, n] + ms[2, n]; ms[4, n] = 1e3 * ($4 + $5)
           ms[5, n] = $6; ms[6, n] = $7; ms[7, n] = 1e3 * $8; searches = $9 > searches ? $9 : searches } }
     END { split("search,certificate,both,both on the clock,configurations,shapes,left (mm)", name, ",")
           printf "%d of %d certified, after %d searches at most\n%-20s %9s %9s %9s\n", certified, NR, searches, "", "median", "least", "most"
           for (k = 1; k <= 7 && n; k++) {
               for (i = 1; i <= n; i++) { x = ms[k, i]
                   for (j = i - 1; j > 0 && s[j] > x; j--) s[j + 1] = s[j]
                   s[j + 1] = x }
               printf "%-20s %9.4g %9.4g %9.4g\n", name[k], (s[int((n + 1) / 2)] + s[int(n / 2) + 1]) / 2, s[1], s[n] } }' "$work/rows.txt"
