#!/bin/bash
# cpinn-show: pages of all that it reads, and what it refuses; files for ParaView.
#   test_show.sh BIN ROOT pages|browser
# With "browser" the picture is looked at, in Chromium; exit status 77 where there is none.
set -u
part=$3
. "$(dirname "$0")/programs.sh"
arm=$ROOT/configs/soft_arm.yaml
run 0 cpinn-solve "$arm" --grid 21x11 --out arm.csv
run 0 cpinn-show arm.csv --scene "$arm" --reference arm.csv
if [ "$part" = browser ]; then
    python3 "$ROOT/tests/test_show.py" browser arm.html arm.csv
    exit
fi
said stdout.txt '^wrote arm.html$'
python=0
command -v python3 >/dev/null || python=77
test $python = 77 || check numbers of the page -- \
    python3 "$ROOT/tests/test_show.py" structure arm.html arm.csv

# A run, with its verdict, history, reference and text; names cannot end the script.
sed 's/^rod:/name: "<script>\&"\nrod:/' "$arm" >named.yaml
run 0 cpinn-train named.yaml --quiet --threads 1 --out trained
run 0 cpinn-show trained --grid 21x11 --quiet
run 0 cpinn-eval trained --grid 21x11 --out trained.csv
check its own scripts alone -- test "$(grep -c '<script' trained/report.html)" -eq 2
check escaped -- grep -q '<title>&lt;script>&amp;</title>' trained/report.html
test $python = 77 || check numbers of a run -- \
    python3 "$ROOT/tests/test_show.py" structure trained/report.html trained.csv
said trained/report.html '"verdict": .*"outcome": "solved"'
said trained/report.html '"name": "classical solution'
said trained/report.html 'Training: loss and error'

# A family: all of it, and one member.
run 0 cpinn-train "$ROOT/configs/robots/bensch_2024.yaml" --quiet --threads 1 --out family
run 0 cpinn-show family
said family/report.html '"labels": \["tension_1 = 0"'
said family/report.html 'Predicted error of the shape'
run 0 cpinn-show family --at tension_1=2,share=0.5 --out member.html
said member.html '"share", "0.5"'

# Other sources: a scene with tendons, a beam, a closed loop, a folder of tables and pictures.
run 0 cpinn-show "$ROOT/configs/robots/tendon_pulled.yaml" --out tendon.html
said tendon.html '"kind": "tendon"'
run 0 cpinn-show "$ROOT/configs/beam_cantilever.yaml" --out beam.html
printf 't,reference_x,reference_y,reference_z,true_x,true_y,true_z,input_p,input_q\n0,0,0,0,0,0,3e-3,1,2\n1,1,0,0,1,0,-4e-3,1,2\n' >loop.csv
run 0 cpinn-show loop.csv
said loop.html '"at most", "4 mm"'
mkdir folder
printf 'case,seconds\na,1\n' >folder/cases.csv
printf '<svg xmlns="http://www.w3.org/2000/svg"/>' >folder/cases.svg
run 0 cpinn-show folder/
said folder/report.html '"rows": \[\["case", "seconds"\], \["a", "1"\]\]'

# Pictures of shapes over time, in a plane and in space.
if command -v gnuplot >/dev/null; then
    run 0 cpinn-show arm.csv --out still.svg
    check a picture of 11 instants -- test "$(grep -c 'END' still.gp)" -eq 2 -a -s still.png -a -s still.svg
    run 0 cpinn-show "$ROOT/configs/helix.yaml" --out helix.png
    run 0 cpinn-show arm.csv --out moves.gif
    check an animation -- test "$(head -c 6 moves.gif)" = GIF89a
fi

# What cannot be shown.
mkdir empty
refused 'there is nothing to show' cpinn-show empty
refused 'does not exist' cpinn-show nowhere
printf 's,t,x,y,z\n0,0,0,0,0\n1,0,0,0,1\n0,1,0,0,0\n' >uneven.csv
refused 'uneven.csv: rows 3 to 3 .* the first 2 are' cpinn-show uneven.csv

# ParaView.
run 0 cpinn-solve "$arm" --grid 21x11 --out arm.pvd
test $python = 77 || check files of instants -- \
    python3 "$ROOT/tests/test_show.py" vtp arm.pvd arm.csv
run 0 cpinn-eval trained --grid 21x11 --out trained.vtkhdf
refused 'allowed: .csv, .h5, .hdf5, .npz, and for ParaView .vtkhdf, .pvd' \
    cpinn-solve "$arm" --out arm.vtk
exit $((failures > 0))
