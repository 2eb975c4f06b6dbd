# size 860,820
set multiplot layout 3,1 margins 0.12,0.80,0.07,0.98 spacing 0,0.10  # axes begin and end at one place
set xlabel "y in W (m)"
set ylabel "z in W (m)"
set size ratio -1
plot csv u ($1 < 10 ? NaN : $10):11 t "damped l. s." lt 4, '' u ($1 < 10 ? NaN : $6):7 t "paper" lt 2, '' u ($1 < 10 ? NaN : $4):5 t "guarded" lt 1, \
  '' u 2:3 t "target" lt 5
set size noratio
set xlabel ""
set ylabel "hand to target (mm),\nvelocity not told"
set logscale y
set yrange [0.01:300]
set xrange [0:300]
plot csv u 1:(1000*$12) t "guarded" lt 1, '' u 1:(1000*$13) t "paper" lt 2, '' u 1:(1000*$15) t "damped l. s." lt 4
set xlabel "time (s)"
set ylabel "hand to target (mm),\nvelocity told"
plot csv u 1:(1000*$16) t "guarded" lt 1, '' u 1:(1000*$17) t "paper" lt 2, '' u 1:(1000*$19) t "damped l. s." lt 4
