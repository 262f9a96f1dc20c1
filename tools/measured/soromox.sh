# SoRoMoX's robots of two segments, as it compares itself with SoRoSim: the tip in 3 s after they are let go. SoRoSim is
# taken for the truth here, as its trajectories follow from the equations with the same few modes of the strains; published
# is how far SoRoMoX is off them. SoRoSim's damping is eta = 1e4 Pa s, three times that in bending and stretch.
# Then the speed of SoRoMoX's parallel rollouts, simulated seconds a second, of all 256 robots at once by an RTX 5090
# (paper_results/secIVb_parallel_rollouts_gpu, 2026-08); here of one robot, on one core.
cpu=paper_results/secIVa_benchmarking_sequential_cpu/data
gpu=paper_results/secIVb_parallel_rollouts_gpu/data
take tud-phi/soromox $cpu $gpu
damping=(--set 'rod.damping.strain=[28.274,28.274,84.823]' --set 'rod.damping.curvature=[0.0190852,0.0190852,0.0127235]')

distances() { # of two tables with columns t, x, y, z, in the order of the first: rms and largest, mm
    awk -F, 'FNR == 1 { next } NR == FNR { at[sprintf("%.4f", $1)] = $2 " " $3 " " $4; next }
        sprintf("%.4f", $1) in at { split(at[sprintf("%.4f", $1)], r, " ")
            d = ($2 - r[1])^2 + ($3 - r[2])^2 + ($4 - r[3])^2; sum += d; if (d > most) most = d; rows++ }
        END { print 1e3 * sqrt(sum / rows), 1e3 * sqrt(most), rows }' "$1" "$2"
}

tip_of() { # of a file of --grid 2xN
    awk -F, 'NR == 1 || $1 + 0 > 0.5 { print $2 "," $3 "," $4 "," $5 }' "$1"
}

robot() { # name, file, modes, keys of the scene
    local name=$1 file=$2 modes=$3
    shift 3
    python3 "$root/tools/measured/mat_to_csv.py" "data/$cpu/end_effector_position_${file}_sorosim.mat" t Pos_EE_all \
        >sorosim.csv || fail "$file: python3 does not read SoRoSim's file"
    awk -F, -v OFS=, '{ if (NF == 3) print $1, $2, 0, $3; else print }' \
        "data/$cpu/end_effector_position_${file}_soromox.csv" >soromox.csv
    local -a ours rod theirs
    theirs=($(distances sorosim.csv soromox.csv))
    run "$file.txt" cpinn-solve "$scenes/soromox.yaml" "${damping[@]}" "$@" --method modes --modes "$modes" --grid 2x3001 \
        --out "$file.csv" --json "$file.json"
    tip_of "$file.csv" >tip.csv
    ours=($(distances sorosim.csv tip.csv))
    row "$name: tip rms off SoRoSim" unit=mm rows="${ours[2]}" published="$(times 1 "${theirs[0]}")" \
        physics="$(times 1 "${ours[0]}")" seconds="$(times 1 "$(number seconds "$file.json")")"
    run "rod.txt" cpinn-solve "$scenes/soromox.yaml" "${damping[@]}" "$@" --grid 2x3001 --out rod.csv --json rod.json
    tip_of rod.csv >rod_tip.csv
    rod=($(distances rod_tip.csv tip.csv))
    row "$name: these modes off the rod; rms" unit=mm rows="${rod[2]}" physics="$(times 1 "${rod[0]}")" \
        seconds="$(times 1 "$(number seconds rod.json)")"
    (echo "s,SoRoSim,SoRoMoX,cpinn with these modes,the rod"
        awk -F, -v OFS=, 'FNR == 1 { file++; next } { t = sprintf("%.4f", $1) } file < 4 { x[file, t] = $2; next }
            (1, t) in x && (2, t) in x { print t, x[1, t], x[2, t], x[3, t], $2 }' sorosim.csv soromox.csv tip.csv rod_tip.csv
    ) >"$file.plot.csv"
    plot "$file.plot.csv" "$name" "t, s" "x of the tip, m"
}

# Simulated seconds a second: here of one robot, published of all at once.
speed() { # name, file, segments or order there, modes, keys of the scene
    local name=$1 fast modes=$4
    fast=$(awk -F, -v size="$3" 'NR == 1 { for (c = 1; c <= NF; c++) at[$c] = c } NR > 1 && $at["size_value"] == size &&
        $at["total_speed_ratio"] > most { most = $at["total_speed_ratio"] } END { print most }' "data/$gpu/$2_1s.csv")
    shift 4
    run speed.txt cpinn-solve "$scenes/soromox.yaml" --set time.duration=1 --method modes --modes "$modes" --json speed.json "$@"
    row "$name: simulated seconds a second" rows=1 published="$(times 1 "$fast")" \
        physics="$(times 1 "$(awk -v t="$(number seconds speed.json)" 'BEGIN { print 1 / t }')")" \
        seconds="$(times 1 "$(number seconds speed.json)")"
}

robot "planar; constant strains" planar_pcs 1,1,1,1 --set 'loads.gravity=[-9.81,0,0]'
robot "in space; constant strains" spatial_pcs 1,1,1,1
robot "in space; linear strains" complex_gvs 2,0,2,0
robot "two tendons; linear strains" tendon_driven_gvs 2,2,2,0 --set 'loads.gravity=[0,0,-9.81]' \
    --set 'tendons=[{offset: [-0.02,0], tension: 1},{offset: [0,0.02], tension: 1}]'

pieces() { # number, length of each
    local list i
    for ((i = 0; i < $1; i++)); do list+="{length: $2},"; done
    echo "segments=[${list%,}]"
}
# Clamped lying and let go, as in tools/benchmarks/_benchmark_common.py; theirs begin with small strains and rates.
pcs=(--set rod.section.radius=0.02 --set rod.material.youngs_modulus=6e5 --set rod.material.poissons_ratio=0.2
    --set rod.material.density=1050 --set 'rod.damping={strain: [0.15,0.15,0.15], curvature: [5e-4,5e-4,5e-4]}'
    --set 'loads.gravity=[-9.81,0,0]')
gvs=(--set rod.section.radius=0.02 --set rod.material.poissons_ratio=0.45 --set rod.material.density=980
    --set 'rod.damping={strain: [3.1416,3.1416,9.4248], curvature: [9.4248e-4,9.4248e-4,6.2832e-4]}'
    --set 'loads.gravity=[9.81,0,0]')
for segments in 1 2 4 8; do
    speed "constant strains; segments: $segments" pcs $segments 1,1,1,1 "${pcs[@]}" --set "$(pieces $segments 0.1)"
done
for order in 1 3 5; do
    modes=$((order + 1))
    speed "one segment; strains of order $order" gvs_basis_order $order $modes,$modes,$modes,$modes "${gvs[@]}" \
        --set "$(pieces 1 0.25)"
done
