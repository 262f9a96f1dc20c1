# Draws a robot of this folder at rest, seen along y and along x, with what its reference says.
#
#     cpinn-train configs/robots/tendon_two_segments.yaml
#     cpinn-eval runs/tendon_two_segments --grid 101 --out tendon_two_segments.csv
#     gnuplot -e "robot='tendon_two_segments'" configs/robots/robot.gp     # to tendon_two_segments.svg
if (!exists("robot")) robot = "tendon_two_segments"
solved = robot . ".csv"
reference = "configs/robots/reference/" . robot . ".csv"
set terminal svg size 420,460 font "sans-serif,13" background "white"
set output robot . ".svg"
set datafile separator ","
set datafile commentschars "#"
set key left bottom
set size ratio -1
set offsets 0.03, 0.03, 0.01, 0.03
set xlabel "x or y in m"
set ylabel "z in m"
set xtics 0.05
set ytics 0.05
set grid linecolor "#e0e0e0"
plot solved using 3:5 skip 1 with lines linewidth 3 linecolor "#2166ac" title "x", \
     solved using 4:5 skip 1 with lines linewidth 3 linecolor "#92c5de" title "y", \
     reference using 2:4 skip 1 with points pointtype 6 pointsize 0.7 linecolor "#b2182b" \
         title "reference", \
     reference using 3:4 skip 1 with points pointtype 6 pointsize 0.7 linecolor "#b2182b" notitle
