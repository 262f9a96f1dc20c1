#!/bin/bash
# A law at a point and an optimiser are added as CONTRIBUTING says, in a copy of the tree and in the
# files that it names. The programs are built there. Network, collocation, strains, nodes and modes of a
# motion solve scenes with the law and agree; the tests of optimisers try the new one unasked.
#   test_adding.sh BIN ROOT SHIM COMPARE
set -u
shim=$(realpath "$3") compare=$(realpath "$4")
. "$(dirname "$0")/programs.sh"
unset CMAKE_C_COMPILER_LAUNCHER CMAKE_CXX_COMPILER_LAUNCHER
mkdir tree built && (cd "$ROOT" && tar -cf - CMakeLists.txt autodiff nn optim physics tests tools) |
    tar -xf - -C tree

# add before|after FILE LINE: what is read, at the one line that has these words.
touched=
add() {
    touched="$touched $2"
    cat >words
    awk -v side="$1" -v anchor="$3" '
        index($0, anchor) { found++; if (side == "after") print }
        index($0, anchor) { while ((getline line < "words") > 0) print line }
        !index($0, anchor) || side == "before"
        END { exit found != 1 }' "tree/$2" >new && cp new "tree/$2" || failed "no one '$3' in $2"
}

# new FILE: of what is read.
new() {
    touched="$touched $1"
    cat >"tree/$1"
}

# How many are touched.
files() {
    tr ' ' '\n' <<<"$touched" | grep . | sort -u | wc -l
}

# named HEAD: the files touched are those that the step of CONTRIBUTING names.
named() {
    awk -v head="- **$1" '/^## How to add/ { on = 1; next } /^## / { on = 0 }
        on && index($0, head) == 1 { take = 1; print; next }
        on && /^- / { take = 0 } on && take' "$ROOT/CONTRIBUTING.md" >steps
    for file in $touched; do
        check CONTRIBUTING names "$file" -- grep -qF "\`${file/nadam/NAME}\`" steps
    done
    touched=
}

# ---- a foundation that hardens: force -k |d|^2 d, d from where the unstressed rod is -------------

add after physics/law/law.h 'LAW_RESISTANCE,' <<'END'
    LAW_HARDENING, /* energy: k |r - place|^4/4 */
END
add before physics/law/law.c '/* ---- the laws ---' <<'END'
/* k, place */
static void record_hardening(const ad_value *given, ad_value *energy)
{
    const ad_value *k = given + NUMBERS, *place = k + 1;
    const ad_value off[3] = {ad_sub(given[0], place[0]), ad_sub(given[1], place[1]),
                             ad_sub(given[2], place[2])};
    const ad_value square =
        ad_add(ad_add(ad_square(off[0]), ad_square(off[1])), ad_square(off[2]));
    *energy = ad_scale(ad_mul(k[0], ad_square(square)), 0.25);
}

END
add before physics/law/law.c '[LAW_RESISTANCE] = {' <<'END'
    [LAW_HARDENING] = {.name = "hardening",
                       .about = "A foundation that hardens: k |r - place|^4/4; k, place.",
                       .kind = LAW_STORES,
                       .numbers = 4,
                       .has_energy = true,
                       .along_axes = true,
                       .by_position = true,
                       .has_force = true,
                       .record = record_hardening},
END
add before physics/scene/scene.h 'scene_load base;' <<'END'
    quantity hardening;      /* f = -hardening |r - r0|^2 (r - r0); of s; N/m^4, >= 0 */
END
add before physics/scene/scene_rows.h 'X("loads.foundation", 3' <<'END'
    X("loads.hardening", 1, loads.hardening, LOADS, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "N/m^4", \
      ZERO, NULL, "A foundation that hardens.") \
END
add before physics/scene/scene_rows.h 'X(LAW_RESISTANCE, "drag", drag' <<'END'
    X(LAW_HARDENING, "hardening", hardening, .unit = {{4}}) \
END
add before physics/scene/scene_rows.h 'X("drag", "loads.drag"' <<'END'
    X("a hardening foundation", "loads.hardening", OF_STATE) \
END
add before tests/library/test_support.c '{.feature = "a foundation"' <<'END'
    {.feature = "a hardening foundation", .changes = {"loads.hardening=1e6"}},
END

check "a law is five files, its test among them" -- test "$(files)" -le 5
named 'A term of the equations'

# ---- Adam with Nesterov's momentum: Dozat, ICLR workshop 2016 ------------------------------------

add before optim/methods.h 'X(OPTIM_SSBROYDEN, ssbroyden)' <<'END'
    X(OPTIM_NADAM, nadam) \
END
add before optim/CMakeLists.txt 'optimizer.c schedule.c' <<'END'
    nadam.c
END
new optim/nadam.c <<'END'
#include "internal.h"

#include <math.h>
#include <string.h>

static optim_status step(void *own, const optim_target *target)
{
    optim_adam *adam = own;
    const optim_settings *s = &adam->settings;
    const optim_status status = optim_adam_evaluate(adam, target);
    const double steps = adam->scalar[OPTIM_ADAM_STEPS] + 1, clip = optim_adam_clip(adam);
    const double rate = optim_schedule_rate(s, (int64_t)adam->scalar[OPTIM_ADAM_STEPS]);
    const double now = 1 - pow(s->beta1, steps), next = 1 - pow(s->beta1, steps + 1);
    const double second = 1 - pow(s->beta2, steps);
    for (size_t i = 0; status == OPTIM_RUNNING && i < adam->count; i++) {
        const double g = clip * adam->gradient[i];
        adam->mean[i] = s->beta1 * adam->mean[i] + (1 - s->beta1) * g;
        adam->square[i] = s->beta2 * adam->square[i] + (1 - s->beta2) * g * g;
        const double ahead = s->beta1 * adam->mean[i] / next + (1 - s->beta1) * g / now;
        adam->next_x[i] = adam->x[i] - rate * ahead / (sqrt(adam->square[i] / second) + s->epsilon);
    }
    if (status != OPTIM_RUNNING) {
        return status;
    }
    memcpy(adam->x, adam->next_x, adam->count * sizeof *adam->x);
    adam->scalar[OPTIM_ADAM_STEPS] = steps;
    adam->scalar[OPTIM_ADAM_LEARNING_RATE] = rate;
    return OPTIM_RUNNING;
}

static void defaults(optim_settings *settings)
{
    settings->beta1 = 0.95;
    settings->gradient_tolerance = 0;
}

const optim_kind optim_nadam_kind = {
    .about = "Adam that looks ahead",
    .needs = OPTIM_NEEDS_GRADIENTS,
    .reads = OPTIM_READS_RATE | OPTIM_READS_MEANS | OPTIM_READS_EPSILON,
    .defaults = defaults,
    .size = sizeof(optim_adam),
    .parts = optim_adam_parts,
    .begin = optim_adam_begin,
    .step = step,
    .objective_changed = optim_adam_objective_changed,
    .x = optim_adam_x,
    .best_x = optim_adam_best_x,
    .inspect = optim_adam_inspect,
    .state_check = optim_adam_state_check,
    .advice = "a smaller learning_rate"};
END
new tests/optim/test_optim_nadam.c <<'END'
#include "optim_testing.h"

static double slope(size_t count, const double *x, double *gradient)
{
    *gradient = 1;
    return count ? *x : 0;
}

/* Under a constant slope: beta1 (1 - beta1) / (1 - beta1^2) + 1. */
static void test_first_step(void **state)
{
    (void)state;
    problem p = make_problem(slope, 1);
    optim_settings settings = optim_settings_defaults(OPTIM_NADAM);
    settings.learning_rate = 0.5;
    settings.epsilon = 1e-300;
    optim_optimizer *o = optim_create(1, (const double[]){0}, &settings, NULL);
    assert_int_equal(step_by(o, objective, &p), OPTIM_RUNNING);
    assert_near(*optim_x(o), -0.5 * (1 + 0.95 / 1.95), 1e-15); /* some units of rounding */
    optim_free(o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_first_step)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
END
check "an optimiser is four files, its test among them" -- test "$(files)" -le 4
named 'An optimiser'

# ---- it is built and solves ---------------------------------------------------------------------

cmake -S tree -B built -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG=-O0 \
    -DBUILD_TESTING=OFF -DCPINN_MPI=OFF -DCPINN_WERROR=ON >cmake.txt 2>&1 &&
    cmake --build built -j "$(nproc)" --target cpinn-solve cpinn-train cpinn-eval >build.txt 2>&1
if ! [ -x built/tools/cpinn-solve ] || ! [ -x built/tools/cpinn-eval ]; then
    cat cmake.txt build.txt | grep -E -A5 'error:|Error' | head -20
    failed the tree with the law is not built
    exit 1
fi
PATH=$PWD/built/tools:$PATH

cat >rest.yaml <<'END'
rod:
  length: 0.5
  stiffness: {shear: [40, 40], axial: 100, bending: [0.1, 0.1], torsion: 0.1}
loads:
  tip: {force: [0.4, 0.2, 0]}
  hardening: 1000
END
cat rest.yaml - >motion.yaml <<'END'
time: {duration: 0.1}
END
sed -i 's/torsion: 0.1}/&\n  inertia: {mass_per_length: 0.1, rotary: [1e-4, 1e-4, 2e-4]}/' motion.yaml

# place FILE: x, y, z of the last row.
place() {
    awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i }
        END { print $at["x"], $at["y"], $at["z"] }' "$1"
}

# apart FILE FILE LEAST MOST: the distance of their tips at the end.
apart() {
    echo "$(place "$1") $(place "$2") $3 $4" | awk '
        { off = sqrt(($1 - $4)^2 + ($2 - $5)^2 + ($3 - $6)^2) }
        { if (off >= $7 && off <= $8) exit 0; print "apart by " off; exit 1 }'
}

# The law moves the tip by centimetres, in motion by 4 mm. At rest methods that share nothing but the
# law are as far apart as they estimate. A force that begins suddenly excites more modes than there are
# here: they are off by half a millimetre with the law and without.
run 0 cpinn-solve rest.yaml --set loads.hardening=0 --out soft.csv
run 0 cpinn-solve rest.yaml --out nodes.csv
run 0 cpinn-train rest.yaml --quiet --out trained
run 0 cpinn-eval trained --out trained.csv
check the law acts -- apart soft.csv nodes.csv 1e-2 1
check the network knows the law -- apart nodes.csv trained.csv 0 1e-6
modes="--method modes --modes 4,2,2,2"
run 0 cpinn-solve motion.yaml --nodes 12 --set loads.hardening=0 --out soft.csv
run 0 cpinn-solve motion.yaml --nodes 12 --out nodes.csv
# shellcheck disable=SC2086  # words
run 0 cpinn-solve motion.yaml $modes --out modes.csv
check the law acts in motion -- apart soft.csv nodes.csv 3e-3 1
check modes know the law -- apart nodes.csv modes.csv 0 1e-3
run 0 cpinn-train rest.yaml --explain
said stdout.txt 'hardening'

# ---- every test of optimisers tries the new one, and nothing else had to know ---------------------

run 0 cpinn-train --help
said stdout.txt 'optimizer: one of adam, lbfgs, gauss_newton, nadam, ssbroyden, soap; required'
tr -s ' \n' ' ' <stdout.txt >words.txt # where lines are broken does not matter
said words.txt 'nadam: Adam that looks ahead;'
said stdout.txt 'beta1: .*default: 0\.9, nadam 0\.95, soap 0\.95; adam, nadam, soap only'
refused 'memory: belongs to optimizer lbfgs, but this stage runs nadam' \
    cpinn-train "$elastica" --set 'training.stages=[{optimizer: nadam, memory: 3}]' --out refused
for name in optim_nadam optim_methods; do
    # shellcheck disable=SC2046  # words
    "${CC:-cc}" -std=c11 -D_POSIX_C_SOURCE=200809L -Itree -Itree/tests/helpers -o $name \
        "tree/tests/optim/test_$name.c" tree/optim/*.c $(pkg-config --cflags --libs cmocka) -lm \
        tree/tests/helpers/allocations.c \
        -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=posix_memalign \
        2>compiled.txt || failed "test_$name: $(grep -m1 error compiled.txt)"
    run 0 ./$name
done
check threads -- bash "$ROOT/tests/test_threads.sh" built/tools "$ROOT" nadam
run 0 bash "$ROOT/tests/test_resume_kinds.sh" built/tools "$ROOT" "$shim" "$compare" rest_nadam
said stdout.txt 'rest_nadam: [1-9][0-9]* checkpoints'

finish
