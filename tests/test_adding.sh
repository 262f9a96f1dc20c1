#!/bin/bash
# A term of the equations is added as CONTRIBUTING says, in a copy of the tree and in the files that it
# names: a law at a point. The programs are built there, and network, collocation, strains, nodes and
# modes of a motion solve scenes with it and agree.
#   test_adding.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
unset CMAKE_C_COMPILER_LAUNCHER CMAKE_CXX_COMPILER_LAUNCHER
mkdir tree built && (cd "$ROOT" && tar -cf - CMakeLists.txt autodiff nn optim physics tools) |
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
add after physics/rod_acting.c 'static const rod_given GIVENS' <<'END'
    {LAW_HARDENING, "hardening", GIVEN(hardening), .count = 1, .unit = {{.length = 4}}},
END
add before physics/scene.h 'scene_load base;' <<'END'
    quantity hardening;      /* f = -hardening |r - r0|^2 (r - r0); of s; N/m^4, >= 0 */
END
add before physics/scene_rows.h 'X("loads.foundation", 3' <<'END'
    X("loads.hardening", 1, loads.hardening, LOADS, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "N/m^4", \
      ZERO, NULL, "A foundation that hardens.") \
END
add before physics/support.c '{"gravity", "loads.gravity", NULL,' <<'END'
    {"a hardening foundation", "loads.hardening", NULL,
     "yyyyy yyy yyyy yy y", NULL},
END

# The files are those that the steps name.
awk '/^## How to add/ { on = 1; next } /^## / { on = 0 }
    on && /^- \*\*A term of the equations/ { take = 1; print; next }
    on && /^- / { take = 0 } on && take' "$ROOT/CONTRIBUTING.md" >steps
for file in $touched; do
    check CONTRIBUTING names "$file" -- grep -qF "\`$file\`" steps
done

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
run 0 cpinn-solve rest.yaml --method strain --out strain.csv
run 0 cpinn-train rest.yaml --quiet --out trained
run 0 cpinn-eval trained --out trained.csv
check the law acts -- apart soft.csv nodes.csv 1e-2 1
check strains know the law -- apart nodes.csv strain.csv 0 1e-9
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

exit $((failures > 0))
