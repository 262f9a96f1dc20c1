#!/bin/bash
# Loops of twelve robots with 1 to 9 actuators, hanging, standing and across gravity, side by side: how far the
# place is off its path and how much the inputs move, for values of control.weights.rate or of any other key.
#   tools/bench/control.sh [--values "0.03 1 30"] [--key control.weights.rate] [--robots "arm3 arm3_side"]
#                          [--out FILE.csv] [cpinn-control options...]
# Without --values that of the default. Models are reduced rods, so nothing is trained. Errors are in mm, after
# the approach; changes are of the inputs' ranges in %, a sample of 20 ms. The exit status is 3 where a loop warns.
set -u
root=$(cd "$(dirname "$0")/../.." && pwd) || exit 2
PATH=$root/build/tools:$PATH
key=control.weights.rate values= out= wanted= options=()
while [ $# -gt 0 ]; do
    case $1 in
    --key) key=${2:?"--key: a key is missing"} && shift 2 ;;
    --values) values=${2:?"--values: numbers are missing"} && shift 2 ;;
    --robots) wanted=${2:?"--robots: names are missing"} && shift 2 ;;
    --out) out=${2:?"--out: a file is missing"} && shift 2 ;;
    *) options+=("$1") && shift ;;
    esac
done
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT

names=()
# NAME GRAVITY LENGTH RADIUS YOUNGS_MODULUS KIND MOST CIRCLE ANGLES...: one actuator to the tip for each angle in
# degrees, of KIND tendon or chamber, from 0 to MOST N; an angle with a minus sign in front ends in the middle.
robot() {
    local name=$1 gravity=$2 length=$3 radius=$4 modulus=$5 kind=$6 most=$7 circle=$8 i=0 angle end
    shift 8
    names+=("$name")
    {
        echo "parameters:"
        for angle; do
            i=$((i + 1))
            echo "  a$i: {range: [0, $most]}"
        done
        echo "  off: 0.7*$radius"
        echo "rod:"
        echo "  model: cosserat"
        echo "  length: $length"
        echo "  section: {shape: circle, radius: $radius}"
        echo "  material: {youngs_modulus: $modulus, poissons_ratio: 0.45, density: 1100, relaxation_time: 0.03}"
        echo "time: {duration: 3, windows: 1}"
        echo "boundary: {start: {type: clamped}}"
        echo "loads: {gravity: $gravity}"
        echo "${kind}s:"
        i=0
        for angle; do
            i=$((i + 1))
            case $angle in -*) end=", end: $length/2" angle=${angle#-} ;; *) end= ;; esac
            case $kind in
            tendon) echo "  - {offset: [off*cos(pi*$angle/180), off*sin(pi*$angle/180)], tension: a$i$end}" ;;
            *) echo "  - {offset: [off*cos(pi*$angle/180), off*sin(pi*$angle/180)], area: 1, pressure: a$i$end}" ;;
            esac
        done
        echo "surrogate: {step: 0.02, modes: [2, 1, 1, 1]}"
        echo "control:"
        echo "  model: reduced"
        echo "  task: {path: circle, radius: $circle, frequency: 0.5}"
        echo "  tolerance: {rms: 1, worst: 1}" # only how inputs move and what the filter sees is judged
    } >"$work/$name.yaml"
}
down='[0, 0, 9.81]' side='[-9.81, 0, 0]' slant='[-6, 3, 7]' up='[0, 0, -9.81]'
robot single       "$down" 0.2  0.007 6e6   tendon  6 0.005 0
robot single_side  "$side" 0.2  0.007 6e6   tendon  6 0.005 0
robot pair_side    "$side" 0.2  0.007 6e6   tendon  6 0.01  0 180
robot tendons3     "$down" 0.2  0.007 6e6   tendon  8 0.03  0 120 240
robot tendons3_up  "$up"   0.2  0.007 6e6   tendon  8 0.03  0 120 240
robot arm3         "$down" 0.13 0.021 8e4   chamber 8 0.03  0 120 240
robot arm3_side    "$side" 0.13 0.021 1.6e5 chamber 12 0.02 0 120 240
robot tendons4     "$side" 0.2  0.007 6e6   tendon  8 0.03  0 90 180 270
robot tendons5     "$slant" 0.25 0.008 4e6  tendon  6 0.03  0 72 144 216 288
robot tendons6     "$side" 0.2  0.01  2e6   tendon  6 0.03  -0 -120 -240 60 180 300
robot arm6         "$slant" 0.2 0.02  1.6e5 chamber 5 0.03  -0 -120 -240 60 180 300
robot tendons9     "$side" 0.3  0.01  6e6   tendon  8 0.04  -0 -120 -240 40 160 280 80 200 320

# OBJECT KEY: the first number of that name in the first loop, "" or within an object.
number() {
    tr -d '\n' <"$work/json" | sed "s/.*\"loops\"://; s/^.*\"$1\": *{/{/" | grep -o "\"$2\": *[-0-9.e+]*" |
        head -1 | sed 's/.*: *//'
}
: "${wanted:=${names[*]}}"
: "${values:=default}"
heads="robot,actuators,value,rms_mm,worst_mm,change_percent,largest_change_percent,jitter_percent,saturated_percent,status"
[ -n "$out" ] && { echo "$heads" >"$out" || exit 1; }
printf '%s\n%-12s %2s %8s %8s %8s %8s %8s %8s %9s %6s\n' "$key" robot m value rms worst change largest 'to & fro' 'at limits' exit
status=0
for name in $wanted; do
    [ -f "$work/$name.yaml" ] || { echo "control.sh: --robots: $name is none of: ${names[*]}" >&2 && exit 2; }
    for value in $values; do
        set=(--set "$key=$value")
        [ "$value" != default ] || set=()
        cpinn-control "$work/$name.yaml" --quiet ${set[@]+"${set[@]}"} --json "$work/json" \
            ${options[@]+"${options[@]}"} 2>"$work/error"
        exits=$?
        [ $exits = 0 ] || status=$exits
        [ $exits = 0 ] || [ $exits = 3 ] || cat "$work/error" >&2
        printf '%s %s %s %s %s %s %s %s %s %s\n' "$name" "$(grep -c '^  a[0-9]*:' "$work/$name.yaml")" "$value" \
            "$(number '' rms)" "$(number '' worst)" "$(number change mean)" "$(number change worst)" \
            "$(number change jitter)" "$(number '' saturated)" $exits |
            awk -v file="$out" 'NF == 10 {
                printf "%-12s %2s %8s %8.3g %8.3g %8.3g %8.3g %8.2g %9.3g %6s\n",
                    $1, $2, $3, 1e3 * $4, 1e3 * $5, 100 * $6, 100 * $7, 100 * $8, 100 * $9, $10
                if (file != "") printf "%s,%s,%s,%g,%g,%g,%g,%g,%g,%s\n",
                    $1, $2, $3, 1e3 * $4, 1e3 * $5, 100 * $6, 100 * $7, 100 * $8, 100 * $9, $10 >> file
            }'
    done
done
exit $status
