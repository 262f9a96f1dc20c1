#!/bin/sh
# The manual page of a program, made of what its --help prints.
#   man.sh PROGRAM VERSION PAGE
set -eu
program=$1
version=$2
page=$3
name=${program##*/}
"$program" --help >"$page.help"
{
    printf '.TH %s 1 "" "cpinn %s" "User Commands"\n' "$(echo "$name" | tr '[:lower:]' '[:upper:]')" \
        "$version"
    # The summary is the second paragraph; its first sentence is the name's line.
    summary=$(awk 'BEGIN { RS = "" } NR == 2' "$page.help" | tr '\n' ' ' | sed 's/\. .*//; s/[. ]*$//')
    printf '.SH NAME\n%s \\- %s\n.SH DESCRIPTION\n.nf\n' "$name" "$summary"
    sed 's/\\/\\e/g; s/-/\\-/g; s/^\([.'"'"']\)/\\\&\1/' "$page.help"
    printf '.fi\n'
} >"$page.new"
rm "$page.help"
mv "$page.new" "$page"
