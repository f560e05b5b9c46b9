#!/usr/bin/env bash
# Draws the picture of the README from a run of the main job. Needs gnuplot and Python 3; nothing else of the project does.
#   ./run identify measurements/lateral_*.txt && docs/figures/make.sh
set -euo pipefail
cd "$(dirname -- "$(readlink -f -- "$0")")/../.."
data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT
python3 - "$data" <<'PYTHON'
import csv, json, sys
folder = sys.argv[1]
result = json.load(open("out/result.json"))
first = result["records"][0]["file"]
with open(folder + "/record.dat", "w") as out:
    for row in csv.DictReader(open("out/residuals.csv")):
        if row["file"] == first:
            print(row["time_s"], row["measured_mm"], row["modelled_mm"], row["residual_mm"], file=out)
with open(folder + "/arcs.dat", "w") as out:
    for record in result["records"]:
        for arc in record["sine_fit"]["arcs"]:
            print(arc["extremum_mm"], arc["k"], arc["k_expected"], arc["k_corrected"], file=out)
fit = result["fit"]["parameters"]["k"]
open(folder + "/k.gp", "w").write("k=%g\nlow=%g\nhigh=%g\n" % (fit["value"], fit["low"], fit["high"]))
PYTHON
DATA=$data gnuplot <<'GNUPLOT'
folder = system("echo $DATA")
load folder."/k.gp"
set terminal svg size 1000,400 font "Helvetica,13" background "white"
set output "docs/figures/ring_down.svg"
set multiplot
set style line 1 lc rgb "#0072b2" lw 1.4
set style line 2 lc rgb "#d55e00" lw 1.4
set style line 3 lc rgb "#555555" lw 1.0
set border 3 lw 0.8
set tics nomirror out scale 0.6
set lmargin at screen 0.06; set rmargin at screen 0.57
set tmargin at screen 0.90; set bmargin at screen 0.42
set title "lateral 01: measured and plain model"
set ylabel "reading [mm]" offset 1.5
set format x ""
set key top right samplen 2
plot folder."/record.dat" using 1:2 with lines ls 1 title "measured", "" using 1:3 with lines ls 2 title "model"
set tmargin at screen 0.36; set bmargin at screen 0.14
unset title; unset key; set ytics 1
set format x "%g"
set xlabel "time [s]" offset 0,0.5
set ylabel "residual [mm]" offset 1.5
plot folder."/record.dat" using 1:4 with lines ls 3
set lmargin at screen 0.67; set rmargin at screen 0.98; set ytics autofreq
set tmargin at screen 0.90; set bmargin at screen 0.14
set title "k of all records, by the extremum used"
set xlabel "amplitude of the extremum [mm]" offset 0,0.5
set ylabel "k [1/m]" offset 1.5
set xrange [8:28]
set yrange [2.8:5.4]
set key top right samplen 1.5
set object 1 rectangle from 8,low to 28,high fc rgb "#009e73" fs transparent solid 0.25 noborder
plot folder."/arcs.dat" using 1:2 with points pt 7 ps 0.5 lc rgb "#0072b2" title "published method", \
     "" using 1:3 with points pt 6 ps 0.6 lc rgb "#555555" title "its bias, in closed form", \
     k with lines lc rgb "#009e73" lw 1.6 title "fit, 95 % bounds"
unset multiplot
GNUPLOT
