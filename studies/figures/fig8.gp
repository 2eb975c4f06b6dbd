# size 900,620
set multiplot layout 2,3 margins 0.08,0.98,0.09,0.93 spacing 0.06,0.13
unset key
gammas = "350 1000 10000"
set size ratio -1
set xrange [-0.24:0.24]
set yrange [-0.24:0.24]
set xtics 0.1
set ytics 0.1
set object 1 circle at 0,0 size 0.217 fc "#999999" fs empty border
do for [row=0:1] {
  do for [i=1:3] {
    g = real(word(gammas, i))
    set title (row == 0 ? sprintf("γ = %g", g) : "")
    set xlabel (row == 0 ? "forward (m)" : "left (m)")
    set ylabel (i == 1 ? "up (m)" : "")
    plot csv u (column("gamma") == g ? column(row == 0 ? "forward" : "left") : NaN):(column("up")) w dots lw 2 lc "#d1495b"
  }
}
