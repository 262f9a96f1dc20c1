#!/bin/sh
# Dependencies between rooms point one way, tools -> physics -> nn -> autodiff, with
# optim by itself; among the tools bench -> programs -> library -> prepare -> config ->
# control -> surrogate -> train -> files, and library -> emit -> control. Within autodiff they are
# algebra -> run -> compile -> tape and emit -> compile; other folders include the headers that lie in
# autodiff itself. Within physics they are solve -> chain -> local -> learn -> check -> beam -> rod ->
# scene -> quantity -> law -> numerics.
# A header that is not shared stays within its folder and those in it. Shared headers include only
# shared ones; those that are installed include only installed ones and have extern "C".
#   check_dependencies.sh ROOT "INSTALLED_HEADER ..." SHARED_HEADER...     headers relative to ROOT
# Prints the offending lines; exit status 1 when there are any.
set -eu
cd "$1"
installed=$(echo "$2" | tr ';' ' ')
shift 2

# shellcheck disable=SC2086  # a list of names
if grep -L 'extern "C"' $installed | grep .; then
    echo 'installed headers without extern "C"'
    exit 1
fi
find autodiff nn optim physics tests tools -name '*.[ch]' -exec \
    grep -nHE '^[[:space:]]*#[[:space:]]*include' {} + | LC_ALL=C sort |
    awk -v installed_headers="$installed" -v shared_headers="$*" '
    function refuse(why) {
        print file ":" line ": " included ": " why
        bad++
    }
    function folder_of(path, part, count) {
        count = split(path, part, "/")
        if (count > 2 && (part[1] == "tools" || part[1] == "autodiff" || part[1] == "physics"))
            return part[1] "/" part[2]
        return part[1]
    }
    function exists(path, first) {
        if (!(path in found)) {
            found[path] = (getline first < path) >= 0
            close(path)
        }
        return found[path]
    }
    BEGIN {
        may["autodiff"] = " autodiff "
        may["autodiff/tape"] = " autodiff/tape autodiff "
        may["autodiff/compile"] = " autodiff/compile autodiff/tape autodiff "
        may["autodiff/emit"] = " autodiff/emit autodiff/compile autodiff/tape autodiff "
        may["autodiff/run"] = " autodiff/run autodiff/compile autodiff/tape autodiff "
        may["autodiff/algebra"] = " autodiff/algebra" may["autodiff/run"]
        may["optim"] = " optim "
        may["nn"] = " nn autodiff "
        rooms = split("numerics law quantity scene rod beam check learn local chain solve", room, " ")
        libraries = " nn autodiff "
        for (i = 1; i <= rooms; i++) {
            libraries = " physics/" room[i] libraries
            may["physics/" room[i]] = libraries
        }
        libraries = libraries "optim "
        training = libraries " tools/train tools/files "
        surrogate = training " tools/surrogate "
        control = surrogate " tools/environment tools/control " # for types
        may["tools/environment"] = training " tools/environment "
        may["tools/plan"] = training " tools/environment tools/plan "
        may["tools/optimize"] = training " tools/environment tools/optimize "
        everything = control " tools/config tools/prepare tools/emit tools/library tools/environment tools/plan tools/optimize tools/programs "
        may["tools/files"] = " tools/files autodiff "
        may["tools/train"] = training
        may["tools/surrogate"] = surrogate
        may["tools/control"] = control
        may["tools/config"] = control " tools/environment tools/plan tools/optimize tools/config " # for types; check_reading.sh says more
        may["tools/prepare"] = control " tools/config tools/prepare "
        may["tools/emit"] = control " tools/emit "
        may["tools/library"] = control " tools/config tools/prepare tools/emit tools/library "
        may["tools/programs"] = everything
        may["tools/bench"] = everything " tools/bench autodiff/compile autodiff/run "
        may["tests"] = everything " tools/bench tests autodiff/emit autodiff/compile autodiff/run autodiff/tape "
        count = split(installed_headers, list, " ")
        for (i = 1; i <= count; i++)
            is_installed[list[i]] = 1
        count = split(shared_headers, list, " ")
        for (i = 1; i <= count; i++)
            is_shared[list[i]] = 1
        is_text["autodiff/run/tanh.h"] = 1 # need nothing, serve everybody, also exported C
        is_text["autodiff/tape/stumpff.h"] = 1
        is_shared["physics/numerics/quaternion.h"] = 1
        is_shared["physics/numerics/quaternion_algebra.h"] = 1
        is_shared["physics/numerics/vector.h"] = 1
        is_shared["physics/numerics/vector_algebra.h"] = 1
        is_shared["physics/numerics/processor.h"] = 1
    }
    {
        split($0, part, ":")
        file = part[1]
        line = part[2]
        if (!match($0, /["<][^">]*[">]/))
            next
        included = substr($0, RSTART + 1, RLENGTH - 2)
        from = folder_of(file)
        directory = file
        sub("/[^/]*$", "", directory)
        path = included
        while (sub(/^\.\.\//, "", path))
            if (!sub("/[^/]*$", "", directory))
                directory = ""
        if (path != included && directory != "")
            path = directory "/" path
        else if (index(path, "/") == 0)
            path = directory "/" path
        to = folder_of(path)
        if (!(to in may) || !exists(path))
            next
        seen++
        if (path in is_text)
            next
        if (index(may[from], " " to " ") == 0)
            refuse(from " must not depend on " to)
        if (file in is_installed && !(path in is_installed))
            refuse("an installed header includes one that is not")
        if (path in is_shared)
            next
        if (file in is_shared)
            refuse("a shared header includes a private one")
        if (index(from "/", to "/") != 1 && index(from, "autodiff/") != 1 &&
            (index(from, "physics/") != 1 || index(to, "physics/") != 1) && from != "tests" &&
            from != "tools/bench" && index(to, "tools/") != 1)
            refuse("private to " to)
    }
    END {
        if (count == 0 || seen == 0) {
            print "nothing to check: " count " shared headers, " seen + 0 " includes"
            exit 1
        }
        exit bad > 0
    }'
