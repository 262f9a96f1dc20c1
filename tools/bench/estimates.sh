#!/bin/bash
# How well the error of a network with hidden layers is estimated: such networks are trained on scenes at
# rest and in motion, rods and beams, and looked at after more and more steps, from the first of Adam to
# those of Broyden's method. Each time the estimate of cpinn-train, which sees the network and the
# equations, is compared with the largest distance to the scene's closed form, or to its classical
# solution from the unstressed rod.
#   tools/bench/estimates.sh [--short] [SCENE.yaml...]
# --short: some scenes, few steps. Exit status 1: an estimate is further than a factor 10 from the error, is
# not known, or would let a network pass whose error is ten times the tolerance of its verdict. CPINN_BIN:
# where the programs are, if not in build/tools.
set -u
cd "$(dirname "$0")/../.." || exit 2
bin=${CPINN_BIN:-build/tools}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 143' TERM
trap 'exit 130' INT
export XDG_CACHE_HOME=$work/cache
looks=(20 300 600 1200 2500)
short=(elastica helix robots/tendon_one_segment beam_cantilever cantilever_dynamic beam_vibration)
scenes=(elastica heavy_cantilever helix rollup tapered_arm cases/follower_5 cases/bend_45 cases/shear_stretch
    robots/tendon_one_segment robots/soft_arm_three_chambers robots/catheter_routed_tendon robots/concentric
    beam_cantilever cases/timoshenko_tip_force cantilever_dynamic soft_arm robots/tendon_in_motion
    cases/spinning cases/release beam_vibration timoshenko_vibration cases/beam_step cases/beam_mode_pinned
    cases/travelling_helix cases/torsion_wave)
if [ "${1:-}" = --short ]; then
    looks=(20 300 600) scenes=("${short[@]}")
    shift
fi
scenes=("${scenes[@]/%/.yaml}")
[ $# -gt 0 ] && scenes=("$@") || scenes=("${scenes[@]/#/configs/}")

# 400 steps of Adam, then of Broyden's method.
stages() { # STEPS
    echo "{optimizer: adam, steps: $(($1 < 400 ? $1 : 400)), learning_rate: 5.0e-3}$(
        [ "$1" -gt 400 ] && echo ", {optimizer: ssbroyden, steps: $(($1 - 400))}")"
}

number() { # KEY of the report
    sed -nE "s/.*\"$1\": ([^,}]*).*/\1/p" "$work/report.json"
}

for scene in "${scenes[@]}"; do
    for steps in "${looks[@]}"; do
        rm -rf "$work/run"
        "$bin/cpinn-train" "$scene" --set formulation=mixed --set network=null \
            --set 'network={hidden: [20, 20]}' --set "training={seed: 1, stages: [$(stages "$steps")]}" \
            --set 'losses={interior: {points: 256}}' --out "$work/run" --json "$work/report.json" --quiet \
            2>"$work/said"
        [ -d "$work/run" ] || { cat "$work/said" >&2 && exit 2; }
        # The largest is over the length, also of beams, whose estimate is over the deflection.
        key=position_max_over_length
        grep -qE '^ *model: *(euler_bernoulli|rayleigh|timoshenko)' "$scene" && key=position_relative_l2
        echo "$(basename "$scene") $(number step) $(number "$key") $(number estimate)"
    done
done | awk 'BEGIN { least = 1e300; print "scene                        step   error      estimate     ratio" }
    {
        known = $4 != "null"
        ratio = known ? $4 / $3 : 0
        off = !(ratio <= 10 && ratio >= 0.1)
        silent = known && $4 <= 1e-3 && $3 > 1e-2
        printf "%-26s %6d   %.2e   %s   %6.3f%s%s%s\n", $1, $2, $3, known ? sprintf("%.2e", $4) : "-", ratio,
            off ? "   OFF" : "", silent ? "   SILENT" : "", known ? "" : "   unknown"
        fflush()
        all++; offs += off; silents += silent; unknowns += !known
        least = ratio < least ? ratio : least
        most = ratio > most ? ratio : most
    }
    END {
        printf "%d networks: estimate over error %.3f to %.3f; %d further off than a factor 10, %d silent, %d unknown\n",
            all, least, most, offs, silents, unknowns
        exit !(all > 0 && offs + silents + unknowns == 0)
    }'
exit $((PIPESTATUS[1]))
