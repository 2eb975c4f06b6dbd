# size 760,420
set xlabel "integration step"
set ylabel "position (target at 1)"
set yrange [0:1.25]
set linetype 5 lc "#c98a1b" lw 2 dt 1
set linetype 6 lc "#333333" lw 2
set arrow from 0,1 to 300,1 nohead lc "#777777" dt 2
plot for [i=1:6] csv u 1:(column(i + 1)) lt i dt i lw (i == 6 ? 3 : 2) t columnhead(i + 1)
