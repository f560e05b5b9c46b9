#!/usr/bin/env bash
# Draws the picture of the README from a run of the main job. Needs gnuplot, and Python 3, which nothing else of the project does.
#   ./run identify measurements/lateral_*.txt && docs/figures/make.sh
# UICLINK_OUT is the folder of the results (default: out), UICLINK_FIGURE the picture (default: docs/figures/ring_down.svg).
set -euo pipefail
cd "$(dirname -- "$(readlink -f -- "$0")")/../.."
data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT
python3 - "$data" "${UICLINK_OUT:-out}" <<'PYTHON'
import csv, json, sys
folder, out = sys.argv[1:]
result = json.load(open(out + "/result.json"))
record = result["records"][0]
with open(folder + "/record.dat", "w") as table:
    for row in csv.DictReader(open(out + "/residuals.csv")):
        if row["file"] == record["file"]:
            noise = record["noise_mm"]
            print(row["time_s"], row["measured_mm"], row["modelled_mm"], row["extended_mm"],
                  float(row["residual_mm"]) / noise, float(row["extended_residual_mm"]) / noise, file=table)
with open(folder + "/arcs.dat", "w") as table:
    for each in result["records"]:
        for arc in each["sine_fit"]["arcs"]:
            print(arc["extremum_mm"], arc["k"], arc["k_expected"], file=table)
fit = result["extended_fit"]["parameters"]["k"]
cause = result["diagnosis"]["causes"][0]
with open(folder + "/values.gp", "w") as values:
    values.write("k=%g\nlow=%g\nhigh=%g\n" % (fit["value"], fit["low"], fit["high"]))
    values.write('cause="%s"\n' % cause["effect"].replace("_", " "))
    values.write("before=%g\nafter=%g\n" % (cause["rms_before_mm"] / result["extended_fit"]["noise_mm"],
                                            result["extended_fit"]["rms_over_noise"]))
PYTHON
DATA=$data FIGURE=${UICLINK_FIGURE:-docs/figures/ring_down.svg} gnuplot <<'GNUPLOT'
folder = system("echo $DATA")
load folder."/values.gp"
set terminal svg size 1000,560 font "Helvetica,14" background "white"
set output system("echo $FIGURE")
set multiplot
# Okabe and Ito's colours: told apart with any colour vision, and by their grey.
set style line 1 lc rgb "#000000" lw 1.2
set style line 2 lc rgb "#d55e00" lw 1.4
set style line 3 lc rgb "#0072b2" lw 1.4
set border 3 lw 0.8
set tics nomirror out scale 0.6
set xrange [2:15]; set xtics 2
set lmargin at screen 0.075; set rmargin at screen 0.60
set tmargin at screen 0.93; set bmargin at screen 0.63
set title "lateral 01: measured, and both models" offset 0,-0.3
set ylabel "reading [mm]" offset 1
set format x ""
set yrange [-30:34]
set key top right samplen 1.6 horizontal
plot folder."/record.dat" using 1:3 with lines ls 2 title "plain model", \
     "" using 1:4 with lines ls 3 title "extended model", "" using 1:2 with lines ls 1 dt (3,4) title "measured"
set tmargin at screen 0.555; set bmargin at screen 0.375
set title sprintf("residual of the plain model: rms %.0f noise levels", before) offset 0,-0.7
unset key
set yrange [-180:180]; set ytics 90
set ylabel "noise levels" offset 1
plot folder."/record.dat" using 1:5 with lines ls 2
set tmargin at screen 0.30; set bmargin at screen 0.10
set title sprintf("with %s: rms %.2f noise levels (30 times enlarged)", cause, after) offset 0,-0.7
set format x "%g"
set yrange [-6:6]; set ytics 3
set xlabel "time [s]" offset 0,0.6
plot folder."/record.dat" using 1:6 with lines lc rgb "#0072b2" lw 0.5
set lmargin at screen 0.70; set rmargin at screen 0.985
set tmargin at screen 0.93; set bmargin at screen 0.10
set title "k of all records, by the extremum used" offset 0,-0.3
set xlabel "amplitude of the extremum [mm]" offset 0,0.6
set ylabel "k [1/m]" offset 1.5
set xrange [8:28]; set xtics 5
set yrange [2.8:5.4]; set ytics 0.5
set key top right samplen 1.5 vertical
set object 1 rectangle from 8,low to 28,high fc rgb "#009e73" fs transparent solid 0.25 noborder
plot folder."/arcs.dat" using 1:2 with points pt 7 ps 0.5 lc rgb "#d55e00" title "published method", \
     "" using 1:3 with points pt 6 ps 0.7 lc rgb "#000000" title "its bias, in closed form", \
     k with lines lc rgb "#009e73" lw 1.6 title "extended fit, 95 % bounds"
unset multiplot
GNUPLOT
