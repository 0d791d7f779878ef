#!/usr/bin/env python3
"""Compares a cluster tree with scipy's centroid linkage of the same canonical vectors.

    centroid_linkage.py vectors.f32 merges.json

vectors.f32: rows of 48 little-endian floats, one a sample. merges.json: [[item, a, b, e, members], ...]
in merge order, as `tree` returns them. The member sets of all our merges must be those of scipy's first
merges, whatever the order of near ties, and each set's E must agree; the samples should hold no
duplicates, whose order scipy leaves open. Needs numpy and scipy. Exit 0: they agree.
"""

import json
import sys

import numpy as np
from scipy.cluster.hierarchy import linkage


def member_sets(n, pairs):
    """Bit set of the samples below each merge."""
    below = [1 << sample for sample in range(n)]
    for a, b in pairs:
        below.append(below[a] | below[b])
    return below[n:]


def main():
    vectors = np.fromfile(sys.argv[1], "<f4").reshape(-1, 48).astype(np.float64)
    merges = json.load(open(sys.argv[2], encoding="utf-8"))
    n = len(vectors)
    if n < 2 or not merges:
        sys.exit("nothing to compare")
    if len(np.unique(vectors, axis=0)) != n:
        sys.exit("the vectors hold duplicates")
    theirs = linkage(vectors, "centroid")[: len(merges)]
    ours = dict(zip(member_sets(n, [(m[1], m[2]) for m in merges]), merges))
    sets = member_sets(n, [(int(row[0]), int(row[1])) for row in theirs])
    missing = [at for at, members in enumerate(sets) if members not in ours]
    if missing:
        at = missing[0]
        sys.exit(f"{len(missing)} of {len(sets)} sets differ; the first is scipy's merge {at}: {theirs[at]}")
    worst = 0.0
    for members, row in zip(sets, theirs):
        merge = ours[members]
        if merge[4] != members.bit_count() or merge[4] != int(row[3]):
            sys.exit(f"merge {merge} has {members.bit_count()} members")
        worst = max(worst, abs(np.sqrt(merge[3]) - row[2]))
    # Our means are rounded to f32 after every merge; scipy updates distances in f64.
    if worst > 1e-5:
        sys.exit(f"distances differ by up to {worst} m")
    print(f"{n} samples, {len(sets)} merges: equal sets, distances within {worst:.1e} m")


main()
