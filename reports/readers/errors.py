#!/usr/bin/env python3
"""python3 errors.py transitions.csv mine.csv: the error of each value, paired with the truth.

A line of the truth ends with value and bar, a line of yours with a value; what stands before them is the key. Equal
keys are paired in their order. Exit status 1 if a value has no partner."""

import sys
from collections import defaultdict


def read(path, after_key):
    """Lists of the last columns by key, in the file's order."""
    rows = defaultdict(list)
    with open(path, encoding="utf-8") as file:
        next(file)  # the names of the columns
        for line in filter(str.strip, file):
            (*key,) = line.strip().split(",")
            rows[",".join(key[:-after_key])].append([float(text) for text in key[-after_key:]])
    return rows


truth, mine = read(sys.argv[1], 2), read(sys.argv[2], 1)
cases = {key.partition(",")[0] for key in mine}
unpaired = 0
print("key,value,true,error,bar")
for key in sorted(truth.keys() | mine.keys()):
    if key.partition(",")[0] not in cases:
        continue  # a scene that you have not run
    for k in range(max(len(truth[key]), len(mine[key]))):
        if k >= len(mine[key]):
            print(f"{key},missed,{truth[key][k][0]:.17g},,")
        elif k >= len(truth[key]):
            print(f"{key},{mine[key][k][0]:.17g},spurious,,")
        else:
            (value,), (true, bar) = mine[key][k], truth[key][k]
            print(f"{key},{value:.17g},{true:.17g},{value - true:.3e},{bar:.1e}")
            continue
        unpaired += 1
sys.exit(unpaired > 0)
