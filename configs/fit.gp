# A field of the table that cpinn-fit --out has written, over its first coordinate, a curve for each value of
# the second:
#
#     cpinn-fit burgers.yaml --out u.csv --grid 201x6
#     gnuplot -e "table='u.csv'; field='u'" configs/fit.gp          # draws u.csv.svg and u.csv.png
#     gnuplot -e "table='u.csv'; field='u'; map=1" configs/fit.gp   # over both coordinates, as colours

if (!exists('table')) table = 'u.csv'
if (!exists('field')) field = 'u'
set datafile separator ','
set datafile columnheaders
set palette defined (0 '#30123b', 1 '#4669db', 2 '#1ae4b6', 3 '#a4fc3c', 4 '#faba39', 5 '#7a0403')
set terminal unknown
first = NaN
curves = 0
others = ''
count(x, other) = x == first ? (curves = curves + 1, others = others.sprintf(' %.3g', other)) : 0
stats table using (first = $0 == 0 ? column(1) : first, count(column(1), column(2)), column(1)) nooutput

set terminal svg size 840,520 dynamic font 'Helvetica,13' background rgb 'white'
set output table.'.svg'
set encoding utf8
set border 3 lw 1 lc rgb '#444444'
set tics nomirror out scale 0.7
set xlabel 'first coordinate'
set autoscale fix
if (exists('map')) {
    set ylabel 'second coordinate'
    plot table using 1:2:(column(field)) with image notitle
} else {
    set ylabel field
    set key outside right top Left reverse
    unset colorbox
    plot for [k=0:curves-1] table every curves::k using 1:(column(field)) with lines lw 2 \
        lc palette fraction (curves > 1 ? k/(curves - 1.0) : 0.2) title (curves > 1 ? word(others, k + 1) : field)
}
set terminal pngcairo size 1680,1040 fontscale 1.9 linewidth 1.9
set output table.'.png'
replot
unset output
