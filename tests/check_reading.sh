#!/bin/sh
# A file is read without anything being solved: of what the library that reads calls, directly or
# through others, nothing lies in the library that solves. That goes by objects: all that one refers
# to counts, whether it is called or not.
#   check_reading.sh NM READS SOLVES LIBRARY...     the last: all between them
# Prints the way from reading to solving; exit status 1 when there is one, or nothing to look at.
set -eu
nm=$1
reads=$2
solves=$3
shift 3
"$nm" -A -g "$reads" "$solves" "$@" | awk -v reads="$reads" -v solves="$solves" '
    NF > 1 {
        at = $1
        sub(/:[0-9a-f]*$/, "", at)
        object[at] = 1
        if ($(NF - 1) == "U")
            needs[at] = needs[at] " " $NF
        else if ($(NF - 1) ~ /^[A-TV-Z]$/ && !($NF in home))
            home[$NF] = at
    }
    function visit(at, way, symbol) {
        way[at] = symbol
        queue[last++] = at
    }
    END {
        for (at in object) {
            if (index(at, reads ":") == 1)
                visit(at, way, "")
            found += index(at, solves ":") == 1
        }
        for (first = 0; first < last; first++) {
            from = queue[first]
            if (index(from, solves ":") == 1) {
                sub(/.*\//, "", from)
                print from " is reached by" way[queue[first]]
                bad++
                continue
            }
            count = split(needs[from], symbols, " ")
            for (i = 1; i <= count; i++) {
                to = home[symbols[i]]
                if (to != "" && !(to in way))
                    visit(to, way, way[from] " " symbols[i])
            }
        }
        if (last == 0 || !found)
            print "nothing to look at"
        exit bad > 0 || last == 0 || !found
    }'
