# size 760,640
set multiplot layout 2,1 margins 0.12,0.74,0.09,0.97 spacing 0,0.12
set xlabel "y (m)"
set ylabel "z (m)"
set size ratio -1
stats csv u 12 name "Y" nooutput
stats csv u 13 name "Z" nooutput
set object 1 rectangle center Y_mean,Z_mean size 0.01,0.06 fc "#bbbbbb" fs solid
plot csv u 7:8 t "without the wall" lt 2, '' u 3:4 t "around it" lt 1
unset object 1
set size noratio
set xlabel "time (s)"
set ylabel "clearance beyond 5 mm (m)"
plot csv u 1:9 t "without the wall" lt 2, '' u 1:5 t "around it" lt 1, 0 t "at the margin" lt 5
