#!/bin/sh
# Every external symbol of a library starts with one of its prefixes, so that a program's own names
# neither meet nor silently replace the library's.
#   check_symbols.sh NM LIBRARY PREFIX...     a prefix ends in _ or is a whole name
# Prints the other symbols; exit status 1 when there are any, or none at all to look at.
set -eu
nm=$1
library=$2
shift 2
"$nm" -g --defined-only "$library" | awk -v prefixes="$*" -v library="${library##*/}" '
    BEGIN {
        count = split(prefixes, prefix, " ")
    }
    # Names with a dot belong to the compiler: no program can have them.
    NF == 3 && $3 !~ /^_*(asan|ubsan|odr_asan|sanitizer)|[.]/ {
        seen++
        for (i = 1; i <= count; i++)
            if (index($3, prefix[i]) == 1 && (prefix[i] ~ /_$/ || $3 == prefix[i]))
                next
        print library ": " $3
        bad++
    }
    END {
        if (seen == 0)
            print library ": no symbols"
        exit bad > 0 || seen == 0
    }'
