# Two robots of three segments and nine tendons given by length. Fitted are poses of single tendons, of one segment and
# of two; poses of all three segments are held out. Published is the model in MuJoCo with the authors' parameters, over
# the fitted poses of the first robot, after its mean is removed.
take ContinuumRoboticsLab/opencr-mujoco data/sysid/ftdcr_v4 data/sysid/ftdcr_v6

robot() { # version, prefix of its files, published rms
    local folder=data/data/sysid/ftdcr_$1/$2_analysis json=ftdcr_$1.json
    run "ftdcr_$1.txt" cpinn-solve "$scenes/ftdcr_$1.yaml" --data "$folder" --json "$json" \
        --residuals "residuals_$1.csv"
    row "$1: tip rms" unit=mm rows=$(($(wc -l <"$folder/$2_train.csv") - 1)) published="${3:--}" \
        physics="$(times 1000 "$(number rms "$json")")" physics_held_out="$(times 1000 "$(number rms "$json" 2)")" \
        seconds="$seconds"
    row "$1: tip median" unit=mm physics="$(times 1000 "$(number median "$json")")" \
        physics_held_out="$(times 1000 "$(number median "$json" 2)")"
    run page.txt cpinn-show "residuals_$1.csv"
}

# The residual of the first robot. Once each fifth pattern of commands is held out, once all that was not to be fitted.
residual() { # what, file with the rows that are held out, which rows of the first file are fitted, and of the other
    run "residual.txt" cpinn-residual "$scenes/ftdcr_v4.yaml" --data . --set 'data[0].file=patterns.csv' \
        --set "data[0].rows.where=$3" --set "data[1].file=$2" --set "data[1].rows.where=$4" \
        --steps 10 --folds 2 --out residual.h5 --json residual.json
    row "v4 ($1): tip rms" unit=mm rows="$(number rows residual.json)" \
        physics="$(times 1000 "$(number rms residual.json)")" physics_held_out="$(times 1000 "$(number rms residual.json 2)")" \
        residual="$(times 1000 "$(number rms residual.json 5)")" \
        residual_held_out="$(times 1000 "$(number rms residual.json 6)")" \
        deviation="$(times 1000 "$(number predicted residual.json 6)")" seconds="$seconds"
    row "v4 ($1): tip median" unit=mm \
        physics="$(times 1000 "$(number median residual.json)")" \
        physics_held_out="$(times 1000 "$(number median residual.json 2)")" \
        residual="$(times 1000 "$(number median residual.json 5)")" \
        residual_held_out="$(times 1000 "$(number median residual.json 6)")"
    row "v4 ($1): network alone; rms" unit=mm residual="$(times 1000 "$(number rms residual.json 3)")" \
        residual_held_out="$(times 1000 "$(number rms residual.json 4)")"
    row "v4 ($1): within 1 deviation" unit=% residual="$(times 100 "$(number within_1 residual.json 5)")" \
        residual_held_out="$(times 100 "$(number within_1 residual.json 6)")"
    row "v4 ($1): within 2 deviations" unit=% residual="$(times 100 "$(number within_2 residual.json 5)")" \
        residual_held_out="$(times 100 "$(number within_2 residual.json 6)")"
}

# Their labels are text; a number of each pattern, and the rest of its division by five.
number_patterns() { # file
    awk -F, -v OFS=, 'NR == 1 { print $0, "fifth"; next }
        { label = $2; sub(/_hold$/, "", label); n += label != last; last = label; print $0, n % 5 }' "$1"
}

robot v4 tdcr_sysid_20260511-183002 9.68
analysis=data/data/sysid/ftdcr_v4/tdcr_sysid_20260511-183002_analysis
number_patterns "$analysis/tdcr_sysid_20260511-183002_train.csv" >patterns.csv
number_patterns "$analysis/tdcr_sysid_20260511-183002_val.csv" >others.csv
residual "patterns held out" patterns.csv 'abs(fifth - 1) - 0.5' '0.5 - abs(fifth - 1)'
residual "three segments held out" others.csv 1 1
robot v6 tdcrv6_sysid_20260406-181730
