#!/bin/bash
# Robots of papers: what was published, beside what comes out here.
#   published.sh [--quick] [bensch|licher|law ...]
# All of them by default; --quick leaves out what takes more than some seconds.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
PATH=$PATH:$root/build/tools
robots=$root/configs/robots
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
quick=
if [ "${1:-}" = --quick ]; then
    quick=yes
    shift
fi
[ $# -gt 0 ] || set -- bensch licher law

row() { # paper, what, published, here
    printf '%-20s %-45s %9s  %s\n' "$@"
}

# ---- Bensch et al., ICRA 2024, arXiv 2312.12165 ---------------------------------------------------

# Their 160 actuations (github.com/Martin-Bensch/tdcr-pinn): six directions, 27 forces each, without two
# that are close to those of training.
actuations() {
    awk 'BEGIN { print "force,direction"
        for (i = 0; i < 6; i++) for (k = 0; k < 27; k++)
            if (k != 23 || i % 5 > 0) printf "%.15g,%d\n", 0.2 + k * 3.299 / 26, 12 * i }'
}

# Errors of the shapes in FILE: position and rotation at 20 places from the base to the tip, against the
# closed form. Without loads tendons that lie parallel to the axis bend to an arc:
#   EI u = - sum tau r x d3,  EA (v3 - 1) = - sum tau.
# The rotation is that of R^T R_closed, the norm of its logarithm, by quaternions.
errors() {
    awk -F, 'function norm(x, y, z) { return sqrt(x * x + y * y + z * z) }
    BEGIN { pi = atan2(0, -1); E = 60e9; r = 0.5e-3; EA = E * pi * r^2; EI = E * pi * r^4 / 4 }
    NR == FNR { if (FNR > 1) { force[FNR - 1] = $1; direction[FNR - 1] = $2 * pi / 180 } next }
    FNR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    $at["s"] > 0 {
        f = force[$at["member"]] / sin(2 * pi / 3); a = direction[$at["member"]]
        one = f * sin(pi / 3 + a); two = f * sin(pi / 3 - a)
        u1 = -two * 6.928203230275509e-3 / EI; u2 = (one * 8e-3 - two * 4e-3) / EI
        v3 = 1 - (one + two) / EA; u = norm(u1, u2, 0); angle = u * $at["s"]
        side = v3 * (1 - cos(angle)) / u
        x = side * u2 / u; y = -side * u1 / u; z = v3 * sin(angle) / u
        w = cos(angle / 2); p = sin(angle / 2) * u1 / u; q = sin(angle / 2) * u2 / u
        W = $at["qw"]; P = $at["qx"]; Q = $at["qy"]; S = $at["qz"]
        turn = 2 * atan2(norm(w * P - p * W - q * S, w * Q - q * W + p * S, w * S - p * Q + q * P),
                         sqrt((w * W + p * P + q * Q)^2))
        printf "%.6e %.6e %d\n", 1000 * norm($at["x"] - x, $at["y"] - y, $at["z"] - z),
            180 / pi * turn, ($at["s"] > 0.1999) }' "$work/actuations.csv" "$1"
}

quantile() { # of numbers, a line each
    sort -g | awk -v part="$1" '{ x[NR] = $1 }
        END { printf "%.2g\n", x[int(part * (NR - 1) + 0.5) + 1] }'
}

column() { # of the errors, quantile
    cut -d' ' -f"$1" "$work/errors" | quantile "$2"
}

bensch() { # paper, scene, options of cpinn-eval
    local paper=$1 scene=$2
    shift 2
    cpinn-train "$robots/$scene.yaml" --quiet --out "$work/$scene" || [ $? -eq 3 ] # a warning
    cpinn-eval "$work/$scene" --members "$work/actuations.csv" "$@" --out "$work/shapes.csv" >/dev/null
    errors "$work/shapes.csv" >"$work/errors"
    local position="position of 160 shapes" rotation="rotation, norm of log(R^T R)"
    row "$paper" "$position, median, mm" 0.479 "$(column 1 0.5)"
    row "$paper" "$position, 95 %, mm" 1.41 "$(column 1 0.95)"
    row "$paper" "$position, worst, mm" 6.8 "$(column 1 1)"
    row "$paper" "position of the tip, median, mm" 1.16 "$(awk '$3' "$work/errors" | quantile 0.5)"
    row "$paper" "$rotation, median, degrees" - "$(column 2 0.5)"
    row "$paper" "$rotation, worst, degrees" - "$(column 2 1)"
}

# ---- Licher et al. 2025, arXiv 2508.12681 ---------------------------------------------------------

# The circle with their acceleration, by the reduced rod, which needs no training.
licher() {
    cpinn-control "$robots/licher_2025.yaml" --set control.model=reduced \
        ${quick:+--set control.duration=2} >"$work/loop" || [ $? -eq 3 ]
    set -- $(sed -n 's/^reduced rod //p' "$work/loop") # rms, worst, filter, control, longest, rate
    row "Licher 2025" "tip in closed loop, worst, mm" "< 3" "$2"
    row "Licher 2025" "samples a second, here of one core" 70 "$6"
}

# ---- Schommartz et al. 2024, arXiv 2407.00640 -----------------------------------------------------

# Beams with a learned law of the section, against the law that made the data. Their sections warp.
law() {
    local scene
    for scene in rolled stretched; do
        cpinn-train "$root/configs/law/$scene.yaml" --quiet --json "$work/$scene.json" \
            --out "$work/$scene"
        row "Schommartz 2024" "$scene.yaml, tip, % of the length" - \
            "$(grep -o '"tip_over_length": [^,]*' "$work/$scene.json" |
                awk '{ printf "%.2g", 100 * $2 }')"
    done
}

for what in "$@"; do
    case $what in
    bensch | licher | law) ;;
    *)
        echo "published.sh: $what: allowed: bensch, licher, law" >&2
        exit 2
        ;;
    esac
done
row paper what published here
for what in "$@"; do
    case $what in
    bensch)
        actuations >"$work/actuations.csv"
        bensch "Bensch 2024" bensch_2024 --polish 0
        [ -n "$quick" ] || bensch "  by their recipe" bensch_2024_published --polish 0
        ;;
    *) "$what" ;;
    esac
done
