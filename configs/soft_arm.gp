# Draws how the soft arm of soft_arm.yaml swings: its shape at 25 instants, and the path of its tip.
#
#     cpinn-train configs/soft_arm.yaml
#     cpinn-eval runs/soft_arm --grid 41x25 --out soft_arm.csv
#     gnuplot configs/soft_arm.gp        # from soft_arm.csv to soft_arm.svg
set terminal svg size 640,400 font "sans-serif,14" background "white"
set output "soft_arm.svg"
set datafile separator ","
set key off
set size ratio -1
set xrange [0:0.32]
set yrange [-0.24:0.02]
set xlabel "x in m"
set ylabel "z in m"
set cblabel "t in s"
set grid linecolor "#e0e0e0"
set palette defined (0 "#c9d8ee", 0.5 "#2166ac", 1 "#08305c")
points = 41 # along the arm, of --grid
instants = 25
plot for [k = 0:instants - 1] "soft_arm.csv" using 3:5:2 skip 1 \
         every ::(k * points)::((k + 1) * points - 1) with lines linewidth 2 linecolor palette, \
     "soft_arm.csv" using 3:5 skip 1 every points::(points - 1) with lines linewidth 1 \
         dashtype 2 linecolor "#b2182b"
