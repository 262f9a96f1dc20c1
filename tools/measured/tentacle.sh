# SoRoMoX's tapered tentacle: four markers of 22 shapes. Published are the mean distances over all markers, of a rod with E
# and density found by the authors, and of that with their network for the rest, which was trained on 20 of the shapes.
data=paper_results/secVa_system_identification/data
take tud-phi/soromox $data/measured_pts.npy
run fit.txt cpinn-solve "$scenes/tentacle.yaml" --data data/$data --json fit.json --residuals residuals.csv
row "markers; E and density found: mean" unit=mm rows="$(number rows fit.json)" published=15.8 \
    physics="$(times 1000 "$(number mean fit.json)")" seconds="$seconds"
row "E" unit=kPa physics="$(times 0.001 "$(number value fit.json)")" \
    deviation="$(times 0.001 "$(number standard_deviation fit.json)")"
row "density" unit=kg/m3 physics="$(times 1 "$(number value fit.json 2)")" \
    deviation="$(times 1 "$(number standard_deviation fit.json 2)")"

run page.txt cpinn-show residuals.csv

# With the markers' places found, and a residual of the curvature at rest. Then two shapes are left out of all that is
# fitted, twelve times.
run residual.txt cpinn-residual "$scenes/tentacle_residual.yaml" --data data/$data --out residual.h5 \
    --leave-out 2 --choices 12 --steps 40
distance() { awk -v name="$1" 'index($0, name) == 1 { print $3 }' residual.txt; }
row "markers; their places found; with residual: mean" unit=mm rows=88 published=6.4 \
    physics="$(times 1000 "$(distance 'physics alone')")" \
    residual="$(times 1000 "$(awk '/^both/ { print $2 }' residual.txt)")" seconds="$seconds"
left_out() { awk -v name="$1" '/left out/ && index($0, name) { for (i = 1; i < NF; i++) if ($i == "mean") print $(i + 1) + 0 }' residual.txt; }
row "two shapes left out; 12 choices: mean" unit=mm rows=96 published=6.4 \
    physics_held_out="$(times 1000 "$(left_out 'physics alone')")" \
    residual_held_out="$(times 1000 "$(left_out both)")"
