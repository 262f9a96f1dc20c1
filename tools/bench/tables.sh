#!/bin/bash
# Writes the published tables anew: in each FILE, what stands between
#
#     <!-- table: COMMAND -->
#     <!-- end of table -->
#
# becomes the output of COMMAND, run from the root of the project with its programs on the path, and
# a line that says when it was run and on what. OUT in a command is a temporary folder. A command that
# fails leaves its table as it was.
#   tools/bench/tables.sh [--only TEXT] [FILE.md...]     TEXT: tables whose command contains it
# Without FILE: all pages that have such tables. Times are only worth publishing from a machine that does nothing else.
set -u
cd "$(dirname "$0")/../.." || exit 2
PATH=$PWD/build/tools:$PWD/build/tools/bench:$PATH
only=
if [ "${1:-}" = --only ]; then
    only=${2:?--only: a text is missing}
    shift 2
fi
[ $# -gt 0 ] || set -- configs/cases/README.md tools/bench/README.md tools/site/pages/{families,laws}.md

# "2026-11-22, AMD EPYC 7B13, 2 cores"
machine() {
    local model
    model=$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo | head -1)
    echo "$(date +%F), ${model:-$(uname -m)}, $(nproc) cores"
}

# What a command prints, without the lines that count runs or name the files in OUT.
run_table() {
    local folder=$1 command=$2
    (eval "${command//OUT/$folder}") 2>"$folder/stderr" </dev/null >"$folder/stdout"
    local status=$?
    grep -vF "$folder" "$folder/stdout" | sed -e '/^\[[0-9]*\/[0-9]*\] /d' -e 's/[[:space:]]*$//' |
        cat -s
    return $status
}

failures=0
for file in "$@"; do
    work=$(mktemp -d) || exit 1
    new=$work/new.md
    : >"$new"
    skipping=
    while IFS= read -r line || [ -n "$line" ]; do
        if [[ $line == '<!-- end of table -->' ]]; then
            skipping=
        fi
        [ -n "$skipping" ] || printf '%s\n' "$line" >>"$new"
        [[ $line =~ ^'<!-- table: '(.*)' -->'$ ]] || continue
        command=${BASH_REMATCH[1]}
        [[ $command == *"$only"* ]] || continue
        echo "$file: $command" >&2
        rm -rf "$work/out" && mkdir "$work/out" || exit 1
        if run_table "$work/out" "$command" >"$work/table"; then
            {
                printf '```\n$ %s\n' "$command"
                cat "$work/table"
                printf '```\n\nRun on %s.\n' "$(machine)"
            } >>"$new"
            skipping=yes
        else
            echo "failed, the table stays as it was: $(tail -1 "$work/out/stderr")" >&2
            failures=$((failures + 1))
        fi
    done <"$file"
    [ -n "$skipping" ] && { echo "$file: a table has no end" >&2; exit 2; }
    cp "$new" "$file"
    rm -r "$work"
done
[ "$failures" -eq 0 ]
