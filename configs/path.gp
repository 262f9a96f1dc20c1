# Load against deflection, of the table that cpinn-solve --path has written:
#
#     gnuplot -e "path='arch'" configs/path.gp        # reads arch.csv, draws arch.svg and arch.png

if (!exists('path')) path = 'path'
set datafile separator ','
set datafile columnheaders
table = path.'.csv'
at(wanted) = wanted ? column('load_factor') : NaN
marked(word) = stringcolumn('mark') eq word

set terminal svg size 720,480 dynamic font 'Helvetica,13' background rgb 'white'
set output path.'.svg'
set encoding utf8
set border 3 lw 1 lc rgb '#444444'
set tics nomirror out scale 0.7
set grid xtics ytics lt 1 lw 0.6 lc rgb '#DDDDDD'
set xlabel 'deflection (m)'
set ylabel 'load factor'
set key outside top horizontal Left reverse
plot table using 'deflection':(at(column('unstable') == 0 || marked('bifurcation'))) with lines lw 2 lc rgb '#0072B2' title 'stable', \
     table using 'deflection':(at(column('unstable') > 0 || marked('bifurcation'))) with lines lw 1.5 dt 2 lc rgb '#D55E00' title 'unstable', \
     table using 'deflection':(at(stringcolumn('unstable') eq 'nan')) with lines lw 1.5 lc rgb '#666666' title 'not asked', \
     table using 'deflection':(at(marked('limit'))) with points pt 7 ps 0.9 lc rgb '#000000' title 'limit point', \
     table using 'deflection':(at(marked('bifurcation'))) with points pt 6 ps 1 lc rgb '#000000' title 'bifurcation'

set terminal pngcairo size 1440,960 fontscale 1.9 linewidth 1.9 pointscale 1.8
set output path.'.png'
replot
unset output
