#!/bin/bash
# What the pages of the project show is so: the commands of README.md run, in the order in which they
# stand there, in a folder with nothing but configs; scenes and programs are those of the files that
# the page names; the options of every other command exist; links lead to files.
#   test_readme.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
PATH=$BIN/bench:$PATH
ln -s "$ROOT/configs" "$ROOT/tests" .
mapfile -t pages < <(cd "$ROOT" && ls README.md autodiff/README.md configs/{,cases/,tutorial/}README.md \
    configs/tutorial/{equations,fit,python}.md tools/{bench,python}/README.md CHANGELOG.md CONTRIBUTING.md \
    tools/site/pages/*.md)

# ---- README.md --------------------------------------------------------------------------------

block README.md yaml 1 >shown.yaml
same shown.yaml configs/soft_arm.yaml

run_page README.md 5
for file in runs/soft_arm/{checkpoint.h5,history.csv,config.yaml} soft_arm.csv solved.csv; do
    check "README.md leaves $file" -- test -s "$file"
done

# The network and the solver agree on the scene of the page. Both are within 1e-4 of the length by
# their own estimates; the points are the same.
check network and solver agree -- awk -F, 'NR == FNR { row[FNR] = $3 " " $4 " " $5; next }
    FNR > 1 { split(row[FNR], r, " "); for (i = 1; i <= 3; i++) {
        off = r[i] - $(i + 2); if (off > 1e-4 * 0.3 || off < -1e-4 * 0.3) exit 1 } }
    END { if (FNR != 1 + 41 * 25) exit 1 }' soft_arm.csv solved.csv

check README.md is short -- test "$(wc -w <"$ROOT/README.md")" -le 2300

# ---- the pages of the site --------------------------------------------------------------------

# Each runs in a folder of its own, with the files that it shows: ```yaml NAME.
for page in "$ROOT"/tools/site/pages/*.md; do
    mkdir -p "page_$(basename "$page" .md)" && cd "page_$(basename "$page" .md)" || exit 2
    ln -sf "$ROOT/configs" .
    awk '/^```$/ { file = "" } file { print >file } /^```yaml [a-z_]+\.yaml$/ { file = $2 }' "$page"
    ! grep -q '^```sh$' "$page" || run_page "${page#"$ROOT/"}" 1
    cd "$work" || exit 2
done

# design.md shows what is found: the design to its digits; tips of the other solver within 0.5 mm of the
# places, but for 10 nm, since constraints of tips are kept to 1e-8 of what they vary by; stays in the loop.
found=page_design
check the design that is shown -- awk -F, 'function off(x, y) { return x > y ? x - y : y - x }
    NR == 2 { exit !(off($1, 7.98e-3) < 6e-6 && off($2, 0.1378) < 6e-5 && off($3, 0.06) < 6e-5) }' $found/design.csv
paste -d' ' <(tail -n +2 $found/tensions.csv | cut -d, -f7-9 | tr , ' ') $found/tips.txt | awk '
    { for (k = 1; k <= 3; k++) if (($k - $(k + 4)) ^ 2 > 0.50001e-3 ^ 2) wrong++ }
    END { print NR, wrong + 0 }' >tips.txt
said tips.txt '^4 0$'
check the tip stays at its places -- awk '$2 > 0.3 { wrong++ } END { exit NR != 5 || wrong }' $found/stays.txt

# shown_in LANGUAGE FILE: the block of library.md stands in the file, line after line.
shown_in() {
    local page=tools/site/pages/library.md
    block "$page" "$1" 1 >block.txt
    check "$page shows $1" -- test -s block.txt
    check "the $1 of $page is in $2" -- awk 'NR == FNR { want[NR] = $0; count = NR; next }
        { have[FNR] = $0; last = FNR }
        END { for (i = 1; i <= last; i++) {
            for (k = 1; k <= count && have[i + k - 1] == want[k]; k++) { }
            if (k > count) exit 0 }
            exit 1 }' block.txt "$ROOT/$2"
}
shown_in c tests/install/from_file.c
shown_in python tests/install/from_file.py

# ---- all pages --------------------------------------------------------------------------------

# Commands too slow to be run here: their programs and options exist.
check_options() {
    local program=$1 option
    shift
    for option in "$@"; do
        "$program" --help 2>&1 | grep -q -- "$option" || failed "$program has no option $option"
    done
}

for page in "${pages[@]}"; do
    check "$page is there" -- test -s "$ROOT/$page"
    # one command a line, of tables and of indented examples
    while IFS= read -r command; do
        program=${command%% *}
        options=$(grep -oE -- '(^| )--[a-z][a-z-]*' <<<"$command" | tr -d ' ' | sort -u)
        # shellcheck disable=SC2086  # a list of options
        check_options "$program" $options
    done < <(sed -nE 's/^(<!-- table: |    )//p' "$ROOT/$page" | grep -oE '(cpinn-[a-z]+) [^;|#`]*')
    # links to files, without their anchors
    folder=$(dirname "$ROOT/$page")
    while IFS= read -r link; do
        check "$page: the link $link" -- test -e "$folder/${link%%#*}"
    done < <(grep -oE '\]\([^)]+\)' "$ROOT/$page" | sed 's/^](//; s/)$//' | grep -v '^http')
done

# tables.sh replaces what a command printed, and leaves the table of a command that fails.
cat >page.md <<'EOT'
before
<!-- table: echo one; echo two -->
old
<!-- end of table -->
<!-- table: no-such-command -->
kept
<!-- end of table -->
after
EOT
run 1 "$ROOT/tools/bench/tables.sh" "$work/page.md"
said stderr.txt 'failed, the table stays as it was'
check the new table -- test "$(sed -n '3,7p' page.md | head -4 | tr '\n' '|')" = \
    '```|$ echo one; echo two|one|two|'
check the table of a failed command -- grep -qx kept page.md
check what is around stays -- test "$(head -1 page.md) $(tail -1 page.md)" = "before after"
said page.md '^Run on [0-9]{4}-[0-9]{2}-[0-9]{2}, .*, [0-9]+ cores\.$'

finish
