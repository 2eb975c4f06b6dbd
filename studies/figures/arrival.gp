# size 760,480
set multiplot layout 2,1 margins 0.12,0.72,0.12,0.96 spacing 0,0.12  # axes begin and end at one place
set logscale y
set format y "10^{%L}"
set xlabel ""
set ylabel "hand to target (m)"
set yrange [1e-6:1]
plot csv u 1:2 t "paper" lt 2, '' u 1:3 t "guarded" lt 1, 1e-4 t "arrived: 0.1 mm" lt 5
set xlabel "time (s)"
set ylabel "γ (rad²/m²)"
set yrange [*:*]
plot csv u 1:4 t "guarded" lt 1
