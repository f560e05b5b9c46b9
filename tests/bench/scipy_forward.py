#!/usr/bin/env python3
"""One motion as the peer program computes it.

    scipy_forward.py PEER ENGINE METHOD SAMPLES STEP_S k k1 T0 y0_mm [REPEATS]

Loads PEER (a Python program with the functions simulate_ivp and simulate_exact), runs its engine (ivp or exact) at
rtol 1e-8 and atol 1e-10, its defaults, released at rest from y0 with the slider loaded, and prints one JSON object: the displacements
in mm and the processor time of one run, the median of REPEATS.
"""
import importlib.util
import json
import statistics
import sys
import time

import numpy as np


def main():
    peer_file, engine, method, samples, step, k, k1, T0, y0_mm = sys.argv[1:10]
    repeats = int(sys.argv[10]) if len(sys.argv) > 10 else 5
    spec = importlib.util.spec_from_file_location("peer", peer_file)
    peer = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(peer)
    simulate = {"ivp": peer.simulate_ivp, "exact": peer.simulate_exact}[engine]
    t = float(step) * np.arange(int(samples))
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        y = simulate(t, float(k), float(k1), float(T0), 1e-3 * float(y0_mm), 0.0, "loaded", method, 1e-8, 1e-10)
        seconds.append(time.process_time() - start)
    json.dump({"y_mm": [1e3 * float(value) for value in y], "cpu_s": statistics.median(seconds)}, sys.stdout)


if __name__ == "__main__":
    main()
