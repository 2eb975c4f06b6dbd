# size 760,640
set key enhanced
set multiplot layout 3,1 margins 0.12,0.76,0.09,0.97 spacing 0,0.10  # axes begin and end at one place
set xlabel ""
set ylabel "θ_T (rad)"
plot csv u 1:2 t "SFE" lt 1, '' u 1:3 t "SAA" lt 2, '' u 1:4 t "SHR" lt 3, '' u 1:5 t "EB" lt 4
set ylabel "θ (rad)"
plot csv u 1:6 t "SFE" lt 1, '' u 1:7 t "SAA" lt 2, '' u 1:8 t "SHR" lt 3, '' u 1:9 t "EB" lt 4
set xlabel "time (s)"
set ylabel "speed (rad/s); number"
plot csv u 1:10 t "fastest joint" lt 1, '' u 1:12 t "choices of θ_T" lt 5
