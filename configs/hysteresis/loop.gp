# Tension against the deflection of the tip, by cpinn-solve --rows; tendon.yaml has the command.
# In a folder with tips.csv and pulls.csv: gnuplot loop.gp

set terminal svg size 720,480 dynamic font 'Helvetica,13' background rgb 'white'
set output 'loop.svg'
set encoding utf8
set datafile separator ','
set border 3 lw 1 lc rgb '#444444'
set tics nomirror out scale 0.7
set grid xtics ytics lt 1 lw 0.6 lc rgb '#DDDDDD'

set xlabel 'deflection of the tip (mm)'
set ylabel 'tension at the beginning of the tendon (N)'
set key left top Left reverse

plot '< awk -F, "NR == 1 || \$2 > 0" tips.csv | paste -d, pulls.csv -' skip 1 using ($4*1000):1 with linespoints pt 7 ps 0.4 lw 1.5 lc rgb '#0072B2' \
     title 'pulled, released, and pulled again, with a small loop'
