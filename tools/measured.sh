#!/bin/bash
# The table of measured robots: what others publish of a data set, beside what comes out here.
#   tools/measured.sh [--out DIR] FOLDER [SET...]
# FOLDER has the repositories of the data, as clones or as bare git directories, each as OWNER+NAME, OWNER/NAME or
# NAME. Without SET all sets are run whose repository is there; a line says which are missing, and where they are.
# The table is printed, and written to DIR/table.md and DIR/table.csv (default build/measured); DIR/SET has what
# the set has read, run and drawn. Exit status: 1 where a set failed, 2 where nothing was there.
#
# A set is a file tools/measured/SET.sh. It is run by bash in its folder DIR/SET, with these words:
#   take OWNER/NAME PATH...   copies files or folders of the repository to data/PATH; ends the set where it is missing
#   run LOG COMMAND...        keeps what COMMAND prints in LOG, and its time in $seconds; a warning (3) is no failure
#   number KEY FILE [N]       the N-th number of that key in a file of --json
#   times FACTOR NUMBER       three figures of the product, such as mm of m
#   row WHAT KEY=VALUE...     a row of the table: unit, rows (how many measurements), measured (how much), published,
#                             physics, physics_held_out, residual, residual_held_out, deviation (of an unknown that
#                             was found), seconds
#   plot CSV TITLE X Y        draws the columns over the first one; a column `measured` as points
# Scenes are $scenes/SET.yaml. To add a set: write both files, name the set in configs/measured/README.md.
set -u
root=$(cd "$(dirname "$0")/.." && pwd)
PATH=$PATH:$root/build/tools
columns=(set what unit rows measured published physics physics_held_out residual residual_held_out deviation seconds)
MISSING=9 # exit status of a set whose repository is not there

refuse() {
    echo "measured.sh: $*" >&2
    exit 2
}

# ---- words of a set ------------------------------------------------------------------------------

# The folder or bare git directory of OWNER/NAME.
find_repository() {
    local at
    for at in "${1/\//+}" "$1" "${1#*/}"; do
        for at in "$folder/$at/repo" "$folder/$at"; do
            [ -d "$at" ] && echo "$at" && return
        done
    done
    return 1
}

# One file after the other: a snapshot may lack others, which an archive would ask for.
take_from_git() {
    local from=$1 file
    shift
    git -C "$from" ls-tree -r --name-only HEAD -- "$@" >files.txt
    [ -s files.txt ] || return 1
    while IFS= read -r file; do
        mkdir -p "data/$(dirname "$file")" && git -C "$from" show "HEAD:$file" >"data/$file" || return 1
    done <files.txt
}

take() {
    local from repository=$1 path
    shift
    from=$(find_repository "$repository") || {
        echo "$set: not there: $repository; it is at https://github.com/$repository" >&3
        exit $MISSING
    }
    for path in "$@"; do
        mkdir -p "data/$(dirname "$path")"
        if [ -e "$from/HEAD" ]; then
            take_from_git "$from" "$path"
        else
            cp -r "$from/$path" "data/$path"
        fi || fail "$repository: $path is missing"
    done
}

fail() {
    echo "$set: $*" >&3
    exit 1
}

run() {
    local log=$1 status=0 start=$EPOCHREALTIME
    shift
    "$@" >"$log" 2>&1 || status=$?
    seconds=$(awk -v a="$start" -v b="$EPOCHREALTIME" 'BEGIN { printf "%.2g", b - a }')
    [ $status -eq 0 ] || [ $status -eq 3 ] || fail "$1: exit status $status: $(tail -1 "$log")"
}

number() {
    grep -o "\"$1\": *[^,}]*" "$2" | sed -n "${3:-1}s/.*: *//p"
}

times() {
    awk -v a="$1" -v b="$2" 'BEGIN { x = a * b; printf (x * x < 1e6 ? "%.3g" : "%.0f") "\n", x }'
}

row() {
    local -A cell=([set]=$set [what]=$1)
    local pair key line=
    shift
    for pair in "$@"; do
        key=${pair%%=*}
        [[ " ${columns[*]} " == *" $key "* ]] || fail "row: there is no column $key"
        cell[$key]=${pair#*=}
    done
    [[ "${cell[*]}" != *,* ]] || fail "row: a comma in ${cell[*]}"
    for key in "${columns[@]}"; do
        line+=",${cell[$key]:--}"
    done
    echo "${line:1}" >>"$table_rows"
}

plot() {
    command -v gnuplot >/dev/null || { echo "$set: no picture, gnuplot is not installed" >&3; return; }
    gnuplot <<END || fail "$1: gnuplot failed"
set terminal svg size 720,440 background 'white'
set output '${1%.csv}.svg'
set datafile separator ','
set title '$2' noenhanced
set xlabel '$3'
set ylabel '$4'
set key outside below noenhanced
plot for [i = 2:$(head -1 "$1" | awk -F, '{ print NF }')] '$1' using 1:i title columnheader(i) \
    with points pointtype (i == 2 ? 7 : 0) pointsize 0.6, \
    for [i = 3:$(head -1 "$1" | awk -F, '{ print NF }')] '$1' using 1:i notitle with lines
END
}

# ---- the table -----------------------------------------------------------------------------------

# CSV as a table of Markdown that is also read as it is.
as_markdown() {
    awk -F, '{ for (i = 1; i <= NF; i++) { cell[NR, i] = $i; if (length($i) > width[i]) width[i] = length($i) } n = NF }
        END { for (r = 1; r <= NR; r++) {
            for (i = 1; i <= n; i++) printf "| %-" width[i] "s ", cell[r, i]
            print "|"
            for (i = 1; r == 1 && i <= n; i++) { rule = sprintf("%" width[i] "s", ""); gsub(/ /, "-", rule); printf "| %s ", rule }
            if (r == 1) print "|" } }'
}

out=$root/build/measured
if [ "${1:-}" = --out ]; then
    out=${2:?--out: a folder is missing}
    shift 2
fi
[ -d "${1:-}" ] || refuse "${1:-}: is no folder; allowed: one that has the repositories of the data"
folder=$(cd "$1" && pwd)
shift
known=$(cd "$root/tools/measured" && ls -- *.sh | sed 's/\.sh$//')
for set in "$@"; do
    [ -e "$root/tools/measured/$set.sh" ] || refuse "$set: is no set; allowed:" $known
done
[ $# -gt 0 ] || set -- $known
mkdir -p "$out" || exit 2
out=$(cd "$out" && pwd)
scenes=$root/configs/measured
there=0 status=0
echo "${columns[*]}" | tr ' ' , >"$out/table.csv"
for set in "$@"; do
    rm -rf "${out:?}/$set" && mkdir "$out/$set" || exit 2
    table_rows=$out/$set/rows.csv
    (cd "$out/$set" && set -e && . "$root/tools/measured/$set.sh") 3>&2 2>"$out/$set/stderr.txt"
    ended=$?
    case $ended in
    0)
        there=$((there + 1))
        cat "$table_rows" >>"$out/table.csv"
        ;;
    "$MISSING") ;;
    *)
        echo "$set: failed; see $out/$set" >&2
        status=1
        ;;
    esac
done
[ $there -gt 0 ] || [ $status -ne 0 ] || refuse "$folder: no set is there"
as_markdown <"$out/table.csv" | tee "$out/table.md"
exit $status
