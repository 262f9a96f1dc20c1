#!/bin/bash
# cpinn-train --watch on terminals of many kinds.
#   test_watch.sh BIN ROOT TERMINAL_RUN
set -u
. "$(dirname "$0")/programs.sh"
terminal=$3
export TERM=xterm LANG=C.UTF-8
unset LC_ALL LC_CTYPE NO_COLOR

scene=("$dynamic" --set 'network.hidden=[8, 8]' --set losses.interior.points=48
    --set losses.held_out_points=16 --set losses.interior.sampler=uniform
    --set checkpoint.every=1000 --threads 1)
for_long=(--set 'training.stages=[{optimizer: adam, steps: 1000000}]')

# watch STATUS SIZE [PICTURES ACTION]... -- OPTIONS...: into the screen of that size.
watch() {
    local wanted=$1
    shift
    local before=()
    while [ "$1" != -- ]; do
        before+=("$1")
        shift
    done
    shift
    run "$wanted" "$terminal" "${before[0]}" screen.txt "${before[@]:1}" -- \
        cpinn-train "$@" --watch
}

pictures() {
    sed -n 's/^pictures //p' stdout.txt
}

# once PATTERN: in one line of all that is and has been on the screen, as a picture that is drawn
# over another leaves none.
once() {
    [ "$(grep -Ec -- "$1" screen.txt)" -eq 1 ] ||
        failed "$(grep -Ec -- "$1" screen.txt) lines with '$1': $(cat screen.txt)"
}

# ---- the same run -----------------------------------------------------------------------------

adam=(--set 'training.stages=[{optimizer: adam, steps: 12000}]')
run 3 cpinn-train "${scene[@]}" "${adam[@]}" --out plain
watch 3 100x60 -- "${scene[@]}" "${adam[@]}" --out watched
check several pictures -- test "$(pictures)" -gt 2
once '^[a-z_]+  12000 steps in [0-9.]+ s$'
once '━━ loss .*━━ held-out .*━━ error '
once '└.*┴.*┴'
once 't = 0 ■■■■■■■■■ '
once '^done: 12000 steps'
said screen.txt '1e-0[0-9]┤'
said screen.txt '⠉|⠒|⠤|⣀'
for folder in plain watched; do
    run 0 cpinn-eval "$folder" --grid 21x11 --out "$folder.csv"
    without_seconds "$folder/history.csv" >"$folder.history"
done
same watched.csv plain.csv
same watched.history plain.history

# ---- how it ends ------------------------------------------------------------------------------

watch 130 80x60 3 int -- "${scene[@]}" "${for_long[@]}" --out int
once '^[a-z_]+  [0-9]+ steps in '
said screen.txt 'stopped at step [0-9]+ and saved; continue with'
watch 143 80x60 3 term -- "${scene[@]}" "${for_long[@]}" --out int --resume
once '^[a-z_]+  [0-9]+ steps in '
said screen.txt 'resumed at step [1-9]'
watch 1 80x60 -- "${scene[@]}" --set 'training.stages=[{optimizer: adam, steps: 1000000,
    learning_rate: 1e300}]' --out not_finite
said screen.txt '^cpinn-train: step .* not finite'

# ---- sizes ------------------------------------------------------------------------------------

for size in 12x5 48x30 300x100; do
    watch 130 "$size" 2 int -- "${scene[@]}" "${for_long[@]}" --out "$size"
done
watch 130 120x40 2 60x20 4 50x12 6 130x50 8 int -- "${scene[@]}" "${for_long[@]}" --out resized
sed -n '/^----$/,$p' screen.txt >last.txt
check one picture after changes of size -- test "$(grep -c '━━ loss' last.txt)" -eq 1

# ---- other kinds of rods, families and one-step models ------------------------------------------

for config in helix beam_cantilever; do
    watch 0 100x80 -- "$ROOT/configs/$config.yaml" --out "$config"
    once "^$config  [0-9]+ steps in "
    once '┴'
done
said screen.txt 'deflection '
watch 3 100x80 -- "$ROOT/configs/robots/tendon_family.yaml" --set members.solved=2000 \
    --set 'training.stages=[{optimizer: soap, steps: 20}]' --out family
once '7 members of the family'
watch 130 100x40 2 int -- "$ROOT/configs/robots/soft_arm_control.yaml" --set surrogate.kind=flow \
    --set surrogate.solved=800 --set 'training.stages=[{optimizer: ssbroyden, steps: 100000}]' \
    --out one_step
once '^soft_arm_control  [0-9]+ steps in '
once '^errors of steps, over those of the linear map'

# ---- terminals that cannot, and none -----------------------------------------------------------

short=(--set 'training.stages=[{optimizer: adam, steps: 20}]')
export LANG=C
watch 3 80x60 -- "${scene[@]}" "${short[@]}" --out ascii
once '== loss .*== held-out '
check ASCII alone -- test -z "$(LC_ALL=C tr -d '\n\040-\176' <screen.txt)"
TERM=dumb watch 3 80x60 -- "${scene[@]}" "${short[@]}" --out dumb
check no picture -- test "$(pictures)" -eq 0
once '^done: 20 steps'
run 3 cpinn-train "${scene[@]}" "${short[@]}" --out pipe --watch
said stdout.txt '^done: 20 steps'
check no control sequences -- test -z "$(tr -cd '\033' <stdout.txt)"
watch 3 80x60 -- "${scene[@]}" "${short[@]}" --out quiet --quiet
check no picture -- test "$(pictures)" -eq 0

finish
