# size 860,720
set multiplot layout 3,1 margins 0.10,0.78,0.08,0.97 spacing 0,0.12  # axes begin and end at one place
set xrange [0:2.5]
set ylabel "hand's speed (m/s)"
plot csv u 1:3 t "guarded" lt 1, '' u 1:5 t "paper" lt 2, '' u 1:7 t "paper, literal" lt 3, '' u 1:9 t "damped l. s." lt 4
set ylabel "hand to target (m)"
set logscale y
set format y "10^{%L}"
set yrange [1e-6:1]
plot csv u 1:2 t "guarded" lt 1, '' u 1:4 t "paper" lt 2, '' u 1:6 t "paper, literal" lt 3, '' u 1:8 t "damped l. s." lt 4
unset logscale y
set format y "%g"
set autoscale x
set autoscale y
set xlabel "along the line between the points (m), there and back"
set ylabel "aside of it (mm)"
plot csv u 10:(1000*$11) t "guarded" lt 1, '' u 12:(1000*$13) t "paper" lt 2, '' u 14:(1000*$15) t "paper, literal" lt 3, \
  '' u 16:(1000*$17) t "damped l. s." lt 4
