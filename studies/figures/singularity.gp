# size 760,640
set multiplot layout 3,1 margins 0.12,0.74,0.09,0.97 spacing 0,0.10  # axes begin and end at one place
set xlabel ""
set ylabel "hand to target (m)"
set logscale y
set format y "10^{%L}"
set yrange [1e-6:1]
plot csv u 1:3 t "guarded" lt 1, 1e-4 t "arrived: 0.1 mm" lt 5
unset logscale y
set format y "%g"
set yrange [0:7]
set ylabel "fastest joint (rad/s)"
plot csv u 1:5 t "guarded" lt 1, '' u 1:6 t "limit" lt 5
set xlabel "time (s)"
set ylabel "condition number"
set yrange [0:*]
plot csv u 1:7 t "guarded" lt 1, '' u 1:8 t "bound of Eq. (32)" lt 5
