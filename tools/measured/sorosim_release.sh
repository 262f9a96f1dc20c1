# SoRoSim's 20 releases, 10 of each rod: the first second of them, 200 instants, middle and tip. Files are given to
# 1e-4 in SI units, the loads too, so that no less than some 0.03 mm rms can be seen. Where the rod that
# is held flutters there is no equilibrium to start from, and the motion is left out.
dynamics=data/reference/sorosim/sorosim_dynamics
take ContinuumRoboticsLab/opencr-mujoco $dynamics

# Keys of the scene, of the first two lines: damping by stiffness and gravity; moments and forces.
numbers() {
    awk 'NR == 1 { print "--set rod.material.relaxation_time=" $1; split("gx gy gz", name)
            for (k = 1; k <= 3; k++) print "--set parameters." name[k] "=" $(10 + k) }
        NR == 2 { split("mid_mx mid_my mid_mz mid_fx mid_fy mid_fz tip_mx tip_my tip_mz tip_fx tip_fy tip_fz", name)
            for (k = 1; k <= 12; k++) print "--set parameters." name[k] "=" $(1 + k)
            exit }' "$1"
}

published() { # s, t, x, y, z of the middle and the tip
    awk -v l="$2" 'BEGIN { print "s,t,x,y,z" }
        NR > 2 && $1 <= 1 { print l / 2 "," $1 "," $5 "," $6 "," $7; print l "," $1 "," $11 "," $12 "," $13 }' "$1"
}

# Sum of squares, largest, number of distances, m; that of the tip at the start.
compare() { # published, motion
    paste -d, "$1" "$2" | awk -F, 'NR > 1 { off = ($8 - $3)^2 + ($9 - $4)^2 + ($10 - $5)^2; sum += off
            if (off > most) most = off }
        NR == 3 { start = sqrt(off) }
        END { print sum, sqrt(most), NR - 1, start }'
}

rod() { # name in the table, file, length, keys of the scene
    local name=$1 file=$2 length=$3 all=0 i
    shift 3
    : >"$name.txt"
    for i in 1 2 3 4 5 6 7 8 9 10; do
        published "data/$dynamics/${file}MuJoCo_$i.txt" "$length" >published.csv
        cut -d, -f1,2 published.csv >places.csv
        rm -f motion.csv
        run "$file$i.txt" sh -c '"$@" || [ $? -ne 1 ]' - cpinn-solve "$scenes/sorosim_release.yaml" "$@" --tolerance 1e-4 \
            $(numbers "data/$dynamics/${file}MuJoCo_$i.txt") --points places.csv --out motion.csv
        [ -e motion.csv ] || continue
        all=$(awk -v a="$all" -v b="$seconds" 'BEGIN { print a + b }')
        compare published.csv motion.csv >>"$name.txt"
    done
    set -- $(wc -l <"$name.txt") $(awk '{ sum += $1; rows += $3; start += $4^2; if ($2 > most) most = $2 }
        END { printf "%.3f %.2f %d %.3f\n", 1e3 * sqrt(sum / rows), 1e3 * most, rows, 1e3 * sqrt(start / NR) }' "$name.txt")
    row "$name: held tips rms" unit=mm rows="$1" physics="$5"
    row "$name: positions rms" unit=mm rows="$4" physics="$2" seconds="$(printf %.2g "$all")"
    row "$name: positions worst" unit=mm rows="$4" physics="$3"
}

rod "spring steel" SpringSteelRod 0.6
rod TPU TPURod 0.4 --set rod.length=0.4 --set parameters.radius=0.005 --set parameters.young=70e6 \
    --set loads.points[0].at=0.2 --set rod.material.poissons_ratio=0.4 --set rod.material.density=1200
