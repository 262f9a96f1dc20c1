# For tests of the programs; sourced. BIN is their folder, ROOT the project's. Everything happens in
# a folder of its own, which goes away at the end. A failed check is printed and counted.
BIN=$(cd "$1" && pwd) && ROOT=$(cd "$2" && pwd) && test -x "$BIN/cpinn-train" || exit 2
PATH=$BIN:$PATH
work=$(mktemp -d "${TMPDIR:-/tmp}/cpinn_test_programs_XXXXXX")
pid=
trap 'test -n "$pid" && kill -9 "$pid" 2>/dev/null; rm -rf "$work"' EXIT
mkdir "$work/cache"
export XDG_CACHE_HOME=$work/cache # never the user's
cd "$work"
failures=0

# Under sanitizers what goes the same ways again, with other numbers, is left out.
watched() {
    [ -n "${CPINN_WATCHED-}" ]
}

failed() {
    echo "FAILED: $*" >&2
    failures=$((failures + 1))
}

# check WORDS... -- COMMAND...: the command succeeds.
check() {
    local what=
    while [ "$1" != -- ]; do
        what="$what $1"
        shift
    done
    shift
    "$@" || failed "$what:  $*"
}

# A compiler with the sanitizers of CMakeLists.txt, for C that is exported, and with what nobody has set as
# wild numbers: clang takes a third of the time of gcc, and a half without the checks that AddressSanitizer
# makes in its way.
watching() {
    local tried wild=-ftrivial-auto-var-init=pattern
    sanitizers='-fsanitize=address,undefined -fno-sanitize=pointer-overflow,null,object-size
        -fno-sanitize-recover=undefined'
    echo 'int main(void) { return 0; }' >main.c
    for tried in "clang $wild" "cc $wild" cc; do
        quick=$tried
        $tried $sanitizers -o main main.c >/dev/null 2>&1 && return
    done
    failed no compiler with sanitizers
}

# quickly COMMAND...: with clang for the cc of the programs, where they have tried gcc, which takes three times as long.
quickly() {
    if [ ! -d "$work/quick" ] && mkdir "$work/quick" && clang --version >/dev/null 2>&1; then
        ln -s "$(command -v clang)" "$work/quick/cc"
    fi
    PATH=$work/quick:$PATH "$@"
}

# optimizers [KEY]: their names, or of those that have this key, one a line.
optimizers() {
    if [ $# -eq 0 ]; then
        cpinn-train --help | sed -n 's/^  training.stages\[\].optimizer: one of \(.*\); required$/\1/p'
    else
        cpinn-train --help | sed -n "s/^  training.stages\[\].$1: .*; \(.*\) only\$/\1/p"
    fi | tr -d ' ' | tr , '\n'
}

# run STATUS COMMAND...: runs it into stdout.txt and stderr.txt; the exit status has to be this one.
run() {
    local wanted=$1 got=0
    shift
    "$@" >stdout.txt 2>stderr.txt </dev/null || got=$?
    if [ "$got" -ne "$wanted" ]; then
        failed "exit $got, not $wanted: $*"
        head -5 stderr.txt >&2
    fi
}

# said FILE PATTERN
said() {
    grep -Eq -- "$2" "$1" || failed "no '$2' in $1: $(head -c 400 "$1")"
}

# plate_at MM: a plate from there on along x, 20 by 200 by 250 mm, as OBJ in mm.
plate_at() {
    awk -v x="$1" 'BEGIN {
        for (i = 0; i < 8; i++)
            printf "v %g %g %g\n", i % 2 ? x + 20 : x, int(i / 2) % 2 ? 100 : -100, i < 4 ? -50 : 200
        split("1 3 4,1 4 2,5 6 8,5 8 7,1 2 6,1 6 5,3 7 8,3 8 4,1 5 7,1 7 3,2 4 8,2 8 6", f, ",")
        for (i = 1; i <= 12; i++) print "f", f[i] }'
}

# refused PATTERN COMMAND...: exit 2, one line on stderr with that pattern, nothing on stdout, and
# no new entry in the folder.
refused() {
    local pattern=$1 before
    shift
    before=$(ls -A | grep -v '^std')
    run 2 "$@"
    [ "$(wc -l <stderr.txt)" -eq 1 ] || failed "$(wc -l <stderr.txt) lines on stderr: $*"
    said stderr.txt "$pattern"
    [ ! -s stdout.txt ] || failed "something on stdout: $*"
    [ "$before" = "$(ls -A | grep -v '^std')" ] || failed "the folder has changed: $*"
}

# Fingerprints of all files of a folder.
contents() {
    (cd "$1" && find . -type f | LC_ALL=C sort | xargs cksum)
}

# same A B: byte for byte.
same() {
    cmp "$1" "$2" >&2 || failed "$1 and $2 differ"
}

# history.csv without its column of seconds.
without_seconds() {
    cut -d, -f1,2,4- "$1"
}

# A header, then steps that only grow.
check_history() {
    head -1 "$1" | grep -q '^step,stage,seconds,loss,' || failed "$1 has no header"
    awk -F, 'NR > 1 { if (NF != n || $1 + 0 <= last) exit 1; last = $1 + 0 } { n = NF }' "$1" ||
        failed "$1: steps that do not grow, or rows of another length"
}

finish() {
    if [ "$failures" -gt 0 ]; then
        echo "$failures failed"
        exit 1
    fi
    echo "all passed"
}

elastica=$ROOT/configs/elastica_deep.yaml
dynamic=$ROOT/configs/cantilever_deep.yaml

# block PAGE LANGUAGE NUMBER: the content of a fenced block of a page of the project.
block() {
    awk -v open="\`\`\`$2" -v number="$3" '
        $0 == "```" { inside = 0 }
        inside { print }
        $0 == open && ++count == number { inside = 1 }' "$ROOT/$1"
}

# run_page PAGE LEAST: its blocks of sh, a command a line, have exit status 0 in the order in which
# they stand there; there are so many at least. What a line exports those after it have.
run_page() {
    local number=1 commands=0 command got line
    export -p >page.env
    while block "$1" sh "$number" >page.sh && [ -s page.sh ]; do
        while IFS= read -r line; do
            command=${line%%  #*}
            [ -n "$command" ] || continue
            got=0
            bash -c '. ./page.env; eval "$1"; got=$?; export -p >page.env; exit $got' - "$command" \
                >stdout.txt 2>stderr.txt </dev/null || got=$?
            check "exit 0 of '$command'" -- test "$got" -eq 0
            [ "$got" -eq 0 ] || head -5 stderr.txt >&2
            commands=$((commands + 1))
        done <page.sh
        number=$((number + 1))
    done
    check "commands of $1" -- test "$commands" -ge "$2"
}
