# size 980,820
set multiplot
gammas = "0 100 350 2000 10⁶"
set linetype 5 lc "#333333" lw 1.5 dt 1
do for [row=0:1] {
  law = word("paper guarded", row + 1)
  bottom = 0.5 - 0.5 * row
  set origin 0, bottom
  set size 0.45, 0.5
  set title law . ": paths of the hand, seen from above" noenhanced
  unset key
  set size ratio -1
  set xlabel "y (cm)"
  set ylabel "x (cm)"
  set xrange [-8:-20]
  set yrange [2:14]
  set xtics 2
  set ytics 2
  plot for [g=0:4] for [k=0:7] csv every ::0::40 u sprintf("%s_y%d%d", law, g, k):sprintf("%s_x%d%d", law, g, k) lt g+1 lw 1.2 dt g+1
  set size noratio
  set xtics autofreq
  set ytics autofreq
  set size 0.27, 0.5
  set origin 0.45, bottom
  set title "hand speed, to the right"
  set xlabel "time (s)"
  set ylabel "m/s" offset 1,0
  set xrange [0:1.2]
  set xtics 0.4
  set yrange [0:0.32]
  set key inside top right reverse Left title "γ (rad²/m²)"
  plot for [g=0:4] csv u "time":sprintf("%s_speed%d", law, g) lt g+1 dt g+1 t word(gammas, g + 1)
  set origin 0.72, bottom
  set size 0.28, 0.5
  set title "largest speed"
  set xlabel "distance (cm)"
  set xrange [0:10.5]
  set xtics 2
  unset key
  plot for [g=0:4] csv u "distance":sprintf("%s_peak%d", law, g) w linespoints lt g+1 dt g+1 pt (word("7 4 9 13 2", g + 1) + 0) ps 0.6
  set ylabel offset 0,0
}
