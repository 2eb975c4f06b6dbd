# size 760,480
set multiplot layout 2,1 margins 0.12,0.72,0.12,0.96 spacing 0,0.12  # axes begin and end at one place
set logscale y
set format y "10^{%L}"
set yrange [1e-7:3]
set xlabel ""
set ylabel "hand to target (m)"
plot csv u 1:2 t "orientation (m = 6)" lt 1, '' u 1:4 t "pointing (m = 5)" lt 3
set xlabel "time (s)"
set ylabel "angle to target (rad)"
plot csv u 1:3 t "orientation (m = 6)" lt 1, '' u 1:5 t "pointing (m = 5)" lt 3
