# DEFORM's cables, of which robots move both ends: bending and damping from one or two recordings of 5 s, then the 14
# recordings that its authors evaluate. Published is the mean absolute error per coordinate of DEFORM, a network on discrete
# elastic rods, trained with 56 recordings. Its code takes the mean over all vertices, the four that are given among them,
# of samples 2 to 499. It begins with the vertices of samples 0 and 1. Here a cable begins at rest, 2 s earlier where the
# recording before goes on without a gap.
absolute() { # fitted or held_out, how many vertices of how many are free: mean absolute error of a coordinate, mm
    awk -F, -v judged="$1" -v part="$2" -v of="$3" 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
        $at["judged"] == judged && $at["distance"] != "nan" {
            for (k = 1; k <= 3; k++) {
                name = substr("xyz", k, 1)
                off = $at[name] - $at[name "_computed"]
                sum += off < 0 ? -off : off
                count++ } }
        END { printf "%.2f", 1000 * part / of * sum / count }' "$name.csv"
}
cable() { # name, published, free vertices, all vertices, recordings to fit, keys...
    local name=$1 published=$2 free=$3 all=$4 files=data/data_set/$1 recordings=$5 keys=() key
    shift 5
    for key; do
        keys+=(--set "$key")
    done
    take roahmlab/DEFORM "data_set/$name"
    mkdir -p "$name"
    python3 "$root/tools/measured/deform.py" "$files" "$name/fit.csv" $recordings &&
        python3 "$root/tools/measured/deform.py" "$files" "$name/test.csv" \
            $(cd "$files" && ls -- eval/*.pkl | sed 's/\.pkl$//') || fail "$name: python3 does not read the recordings"
    run "$name.txt" cpinn-solve "$scenes/deform.yaml" --data "$name" --set "rod.length=$(cat "$name/fit.length")" "${keys[@]}" --method modes \
        --modes 5,3,0,0 --json "$name.json" --residuals "$name.csv"
    ! grep -q 'there is no solution' "$name.txt" || fail "$name: recordings without a solution would not count"
    row "$name; bending" unit=Nm2 physics="$(times 1 "$(number value "$name.json")")" \
        deviation="$(times 1 "$(number standard_deviation "$name.json")")" seconds="$seconds"
    row "$name; damping by it" unit=s physics="$(times 1 "$(number value "$name.json" 2)")" \
        deviation="$(times 1 "$(number standard_deviation "$name.json" 2)")"
    row "$name; all vertices: mean absolute error" unit=mm rows="$(awk -F, '/held_out/' "$name.csv" | wc -l)" \
        published="$published" physics="$(absolute fitted "$free" "$all")" \
        physics_held_out="$(absolute held_out "$free" "$all")"
    row "$name; free vertices: mean absolute error" unit=mm physics="$(absolute fitted 1 1)" physics_held_out="$(absolute held_out 1 1)"
}
cable DLO1 11.1 9 13 'train/105 train/114'
cable DLO3 9.9 8 12 train/22 'parameters.bending={identify: 0.006, range: [0.003, 0.012]}' 'parameters.tau={identify: 0.06, range: [0.02, 0.2]}'
