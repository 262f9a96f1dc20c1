# SoRoSim's equilibria of two rods, 500 each, under gravity and wrenches at the middle and the tip. They are given to
# 1e-4 in SI units, the loads too. Published is the MuJoCo model of 100 links of the same repository, off SoRoSim at
# the tip by 0.098 and 0.105 % of the length in the mean (docs/assets/validation/sorosim_statics_error.png, 2026-07).
statics=data/reference/sorosim/sorosim_statics
take ContinuumRoboticsLab/opencr-mujoco $statics

# Six rows of the file are a shape: Euler angles and positions; columns: gravity, the two wrenches (moments in the
# rows of angles), 7 stations of each half, of which the first of the second half is the last of the first.
members() {
    awk -F, 'BEGIN { print "gx,gy,gz,mid_mx,mid_my,mid_mz,mid_fx,mid_fy,mid_fz,tip_mx,tip_my,tip_mz,tip_fx,tip_fy,tip_fz" }
        NR > 2 { k = (NR - 3) % 6; for (c = 2; c <= 4; c++) load[c, k] = $c
            if (k == 5) print list(2, 3, 5) "," list(3, 0, 5) "," list(4, 0, 5) }
        function list(c, from, to,   k, text) {
            for (k = from; k <= to; k++) text = text (k > from ? "," : "") load[c, k]
            return text }' "$1"
}

stations() { # of a rod of this length
    awk -F, -v half="$2" 'BEGIN { print "s" }
        NR == 2 { for (c = 5; c <= NF; c++) if (c != 12) printf "%.10g\n", half * ($c + (c > 11)) }' "$1"
}

published() { # positions, a line each
    awk -F, 'BEGIN { print "x,y,z" }
        NR > 2 { k = (NR - 3) % 6; for (c = 5; c <= NF; c++) r[k, c] = $c
            if (k == 5) for (c = 5; c <= NF; c++) if (c != 12) print r[3, c] "," r[4, c] "," r[5, c] }' "$1"
}

# rms and largest distance of all stations, mean of the tip, mm; the part of the coordinates, %, that are off by no
# more than the digits left out of them and of the loads, as derivatives have it.
compare() { # published, shapes
    awk -F, 'NR == FNR { for (k = 1; k <= 3; k++) at[FNR, k] = $k; next }
        FNR == 1 { for (c = 1; c <= NF; c++) { name[c] = $c; if ($c ~ /^[xyz]$/) column[index("xyz", $c)] = c }; next }
        { off = 0
            for (k = 1; k <= 3; k++) { d = $column[k] - at[FNR, k]; off += d^2; bound = 1
                for (c = column[3]; c <= NF; c++) if (index(name[c], name[column[k]] "_by_") == 1) bound += $c < 0 ? -$c : $c
                coordinates++; within += d^2 <= (0.5e-4 * bound + 1e-7)^2 }
            sum += off; if (off > most) most = off; rows++
            if ((FNR - 1) % 13 == 0) { tip += sqrt(off); tips++ } }
        END { printf "%.3f %.3f %.3f %.2f\n", 1e3 * sqrt(sum / rows), 1e3 * sqrt(most), 1e3 * tip / tips, 100 * within / coordinates }' "$1" "$2"
}

rod() { # name in the table, file, length, published mean of the tip in mm, keys of the scene
    local name=$1 file=data/$statics/$2_dataStatics.csv length=$3 tip=$4
    shift 4
    members "$file" >members.csv
    stations "$file" "$(awk -v l="$length" 'BEGIN { print l / 2 }')" >stations.csv
    published "$file" >published.csv
    run "$name.txt" cpinn-solve "$scenes/sorosim.yaml" "$@" --members members.csv --points stations.csv \
        --derivatives --out "$name.csv" --json "$name.json"
    set -- $(compare published.csv "$name.csv")
    local count=$(($(wc -l <members.csv) - 1))
    seconds=$(number seconds "$name.json")
    row "$name: positions rms" unit=mm rows=$count physics="$1"
    row "$name: positions worst" unit=mm rows=$count physics="$2"
    row "$name: tip mean" unit=mm rows=$count published="$tip" physics="$3" seconds="$(printf %.2g "$seconds")"
    row "$name: coordinates within the digits given" unit=% rows=$count physics="$4"
}

rod "spring steel" SpringSteelRodMuJoCo 0.6 0.59
rod TPU TPURodMuJoCo 0.4 0.42 --set rod.length=0.4 --set parameters.radius=0.005 --set loads.points[0].at=0.2 \
    --set rod.material.youngs_modulus=70e6 --set rod.material.poissons_ratio=0.4 --set rod.material.density=1200
