# size 900,900
set multiplot layout 2,2 margins 0.08,0.97,0.07,0.90 spacing 0.09,0.09
joints = "SFE SAA SHR EB"
lower = "-90 -180 -90 -115"
upper = "90 0 30 0"
set key at screen 0.97,0.995 right top horizontal samplen 1
set size square
do for [i=0:3] {
  a = real(word(lower, i + 1)); b = real(word(upper, i + 1))
  set xrange [a-8:b+8]
  set yrange [a-8:b+8]
  set xlabel (i > 1 ? "target angle, in θ_T (°)" : "")
  set ylabel (i % 2 == 0 ? "angle at rest (°)" : "")
  set title word(joints, i + 1)
  target = sprintf("target_%d", i); rest = sprintf("rest_%d", i)
  if (i > 0) { unset key }
  # Arrived: points as short strokes, thick or thin, which take a third of the room.
  d = (b - a + 16) / 120.0
  plot x lt 5 t "", \
    csv u (column("law") == 0 && column("on_diagonal") == 1 ? column(target) - d / 2 : NaN):(column(rest)):(d):(0) w vectors nohead lw 3 dt 1 lc "#999999" t "paper, arrived", \
    '' u (column("law") == 1 ? column(target) - d / 4 : NaN):(column(rest)):(d / 2):(0) w vectors nohead lw 1.5 dt 1 lc "#1f6fb4" t "guarded, arrived (all)", \
    '' u (column("law") == 0 && column("on_diagonal") == 0 ? column(target) : NaN):(column(rest)) w points pt 8 ps 0.7 lc "#d1495b" t "paper, trapped"
}
