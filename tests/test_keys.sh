#!/bin/bash
# Every key of cpinn-train --help has an example in tools/site/examples.txt, and the reader takes it.
#   test_keys.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
cp -r "$ROOT/configs" .
run 0 cpinn-residual configs/identify/residual.yaml --set 'residual.hidden=[1]' --folds 2 \
    --out configs/identify/residual.h5
printf 't,pull\n0,0\n0.6,0.02\n' >configs/pull.csv

cpinn-train --help | sed -n '/^Keys of/,/^formulas/s/^  \([a-z][^ ]*\): .*/\1/p' >keys.txt
check "there are keys" -- test "$(wc -l <keys.txt)" -gt 250

# take KEY VALUE: the reader has to, in the scene.
take() {
    local key=${1/<name>/load} value=$2
    cpinn-train "${scene[@]}" --set "${key//\[\]/[0]}=$value" --print-config >stdout.txt 2>stderr.txt ||
        failed "$key = $value: $(head -c 300 stderr.txt)"
}

while IFS= read -r line; do
    case $line in
    '#'* | '') ;;
    'scene '*)
        eval "words=(${line#scene })"
        scene=("${words[0]}")
        for word in "${words[@]:1}"; do
            scene+=(--set "$word")
        done
        ;;
    *)
        take "${line%% = *}" "${line#* = }"
        sed 's/\[[0-9]*\]/[]/' <<<"${line%% = *}" >>shown.txt
        ;;
    esac
done <"$ROOT/tools/site/examples.txt"

# Of a piece as of the rod.
grep '^segments\[\]' keys.txt | grep -vxFf shown.txt >pieces.txt
while IFS= read -r key; do
    value=$(sed -n "s/^rod${key#segments\[\]} = //p" "$ROOT/tools/site/examples.txt" | head -1)
    check "an example of rod${key#segments\[\]}" -- test -n "$value"
    shape=circle
    case $key in
    *width | *height) shape='rectangle, radius: null, width: 0.01, height: 0.004' ;;
    *inner_radius) shape='tube, inner_radius: 0.003' ;;
    esac
    scene=(configs/soft_arm.yaml --set rod.model=cosserat --set rod.length=null
        --set "segments=[{length: 0.15, section: {shape: $shape}}, {length: 0.15}]")
    take "$key" "$value"
done <pieces.txt

sort -u shown.txt pieces.txt >known.txt
# A law's numbers are written by --print-config.
missing=$(sort keys.txt | comm -23 - known.txt | grep -vx 'rod\.law\.numbers')
check "examples of all keys, not of $missing" -- test -z "$missing"
unknown=$(sort keys.txt | comm -13 - known.txt)
check "examples of keys that there are, not of $unknown" -- test -z "$unknown"

# Keys that the pages name in backticks are keys or sections.
sed 's/\[\]//g' keys.txt >plain.txt
sections=$(sed 's/[.].*//' plain.txt | sort -u | paste -sd '|')
while IFS= read -r key; do
    check "the pages' key $key" -- grep -qE "^${key//./[.]}([.]|$)" plain.txt
done < <(cat "$ROOT"/{README.md,configs/README.md,configs/tutorial/*.md,tools/site/pages/*.md} |
    grep -ohE "\`($sections)(\[[0-9]*\])?([.][a-z_]+(\[[0-9]*\])?)+\`" | tr -d '\`' |
    sed 's/\[[0-9]*\]//g' | sort -u | grep -vE '\.(yaml|csv|h5|md)$')
finish
