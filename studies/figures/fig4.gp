# size 760,400
set xlabel "angle of the joint EB (°)"
set ylabel "w_x / w_θ, in units of γ"
set key enhanced
stats csv u "lower" name "L" nooutput
stats csv u "upper" name "U" nooutput
set xrange [L_min-30:U_max+30]
set yrange [-0.05:1.15]
set arrow 1 from L_min,graph 0 to L_min,graph 1 nohead lc "#777777" dt 2
set arrow 2 from U_max,graph 0 to U_max,graph 1 nohead lc "#777777" dt 2
set label "limit" at L_min,1.1 offset 0.5,0 tc "#777777"
set label "limit" at U_max,1.1 offset 0.5,0 tc "#777777"
plot csv u "angle":"literal" t "Eq. (28) literally" lt 2 dt 3, '' u "angle":"here" t "paper" lt 2, '' u "angle":"guarded" t "guarded" lt 1
