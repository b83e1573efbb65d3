# Plot of the CSV file of fire3dv-bench frame: medians of GPU time, bars up to the 95th percentile.
#
#   gnuplot -e "file='docs/benchmarks/h200.csv'" tools/lab/bench/scripts/frames.gp > docs/benchmarks/h200.svg
set terminal svg size 920,520 font "sans-serif" background "white"
set logscale xy
set grid
set key outside
set xlabel "triangles"
set ylabel "ms of GPU time"
set title system("sed -n '2s/^\"\\([^\"]*\\)\".*/\\1/p' '".file."'") noenhanced
# Triangles, median and 95th percentile of a quantity.
rows(condition, quantity) = sprintf("< sed -nE 's/.*,([0-9]+),[0-9]+,\"%s\",%s,ms,[0-9]+,([^,]+),([^,]+),.*/\\1 \\2 \\3/p' '%s'", \
                                    condition, quantity, file)
plot rows("product", "whole frame") using 1:2:2:3 with yerrorlines title "whole frame", \
     rows("paper", "whole frame") using 1:2:2:3 with yerrorlines title "whole frame, no culling", \
     rows("product, no shadows", "main pass") using 1:2:2:3 with yerrorlines title "main pass", \
     rows("paper, no shadows", "main pass") using 1:2:2:3 with yerrorlines title "main pass, no culling"
