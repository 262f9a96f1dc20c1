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

robot v4 tdcr_sysid_20260511-183002 9.68
robot v6 tdcrv6_sysid_20260406-181730
