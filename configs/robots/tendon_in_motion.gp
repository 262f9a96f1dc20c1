# Draws how the rod of tendon_in_motion.yaml swings: its shape at 26 instants, the path of its tip,
# and what the reference says of tip and middle.
#
#     cpinn-train configs/robots/tendon_in_motion.yaml
#     cpinn-eval runs/tendon_in_motion --grid 41x26 --out tendon_in_motion.csv
#     gnuplot configs/robots/tendon_in_motion.gp       # from tendon_in_motion.csv to tendon_in_motion.svg
set terminal svg size 520,460 font "sans-serif,13" background "white"
set output "tendon_in_motion.svg"
set datafile separator ","
set datafile commentschars "#"
set key off
set size ratio -1
set xrange [-0.02:0.17]
set yrange [0:0.21]
set xlabel "x in m"
set ylabel "z in m"
set cblabel "t in s"
set grid linecolor "#e0e0e0"
set palette defined (0 "#c9d8ee", 0.5 "#2166ac", 1 "#08305c")
points = 41 # along the rod, of --grid
instants = 26
plot for [k = 0:instants - 1] "tendon_in_motion.csv" using 3:5:2 skip 1 \
         every ::(k * points)::((k + 1) * points - 1) with lines linewidth 2 linecolor palette, \
     "tendon_in_motion.csv" using 3:5 skip 1 every points::(points - 1) with lines linewidth 1 \
         dashtype 2 linecolor "#b2182b", \
     "configs/robots/reference/tendon_in_motion.csv" using 3:5 skip 1 with points pointtype 6 \
         pointsize 0.7 linecolor "#b2182b"
