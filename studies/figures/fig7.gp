# size 760,420
set key at graph 0.74,0.97 right top
set xlabel "γ (rad²/m²)"
set ylabel "reaches that fail (%)"
set xrange [0:1030]
set yrange [0:*]
set arrow from 350,graph 0 to 350,graph 1 nohead dt 2 lc "#777777"
set label "0.035 rad²/cm²" at 350,graph 0.5 offset 0.5,0 tc "#777777"
plot csv u 1:3:4 w filledcurves lc "#f0c0c6" t "", '' u 1:2 w linespoints pt 7 ps 0.5 lt 2 dt 1 t "paper, with 95 % interval", '' u 1:5 w linespoints pt 4 ps 0.8 lt 1 t "guarded"
