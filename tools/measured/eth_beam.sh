# ETH's silicone beam, let go six times: the middle of two markers at its tip, by the scene's order of files. E and
# damping are fitted to three recordings; the other three and what all come to rest at are judged. Published is
# Timoshenko's formula with E 263824 Pa of the same repository, at rest: 7.4, 17.7 and 27.6 mm at the tip, where
# markers went down by 6.5, 17.0 and 25.7 mm.
recordings=python/realbeam_experiments/Measurement_data
take srl-ethz/diffPD_sim2real $recordings
run fit.txt cpinn-solve "$scenes/eth_beam.yaml" --data "data/$recordings" --tolerance 1e-3 --json fit.json \
    --residuals residuals.csv

mm() { # number of that key, in mm
    awk -v x="$(number "$1" fit.json "$2")" 'BEGIN { printf "%.2f", 1e3 * x }'
}

row "Young's modulus" unit=Pa physics="$(printf %.0f "$(number value fit.json 4)")" \
    deviation="$(printf %.0f "$(number standard_deviation fit.json 4)")" seconds="$seconds"
row "damping by E" unit=ms physics="$(mm value 5)" deviation="$(mm standard_deviation 5)"
k=1
for load in "no load" "52 g" "102 g"; do
    row "$load: motion rms" unit=mm rows="$(number rows fit.json $k)" physics="$(mm rms $k)" \
        physics_held_out="$(mm rms $((k + 3)))"
    row "$load: rest rms" unit=mm rows="$(number rows fit.json $((k + 6)))" physics="$(mm rms $((k + 6)))" \
        physics_held_out="$(mm rms $((k + 9)))"
    k=$((k + 1))
done
run page.txt cpinn-show residuals.csv
