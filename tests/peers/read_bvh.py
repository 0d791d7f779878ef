"""Reads BVH files with bvhio, a reader that isn't ours, and compares world positions with the `poses` table.

    read_bvh.py CORPUS FOLDER [LEAST]       FOLDER: exported clips, NAME.bvh; at least LEAST of them (1)

Ten frames of each file; every joint that both know by name, at least ten; 0.1 mm, or 1e-5 of the distance from the
origin. Exit 1 where they differ.                       (pip install bvhio numpy polars)
"""

import sys
from pathlib import Path

import bvhio
import polars

TOLERANCE_M = 1e-4


def clip_of(clips, stem):
    rows = clips.filter(polars.col("name").str.split("/").list.last() == stem)
    if len(rows) != 1:
        sys.exit(f"{stem}: {len(rows)} clips of that name")
    return rows.row(0, named=True)


def compare(corpus, clips, file):
    clip = clip_of(clips, file.stem)
    poses = (
        polars.scan_parquet(f"{corpus}/poses/layout={clip['layout']}/*.parquet", hive_partitioning=False)
        .filter(polars.col("clip_id") == clip["clip_id"])
        .sort("frame")
        .collect()
    )
    root = bvhio.readAsHierarchy(str(file))
    frames = sorted({int(at * (clip["frames"] - 1) / 9) for at in range(10)})
    worst, compared = 0.0, set()
    for frame in frames:
        root.loadPose(frame)
        row = poses.row(frame, named=True)
        for joint, _, _ in root.layout():
            if f"{joint.Name}.x" not in row:
                continue
            compared.add(joint.Name)
            ours = [row[f"{joint.Name}.{axis}"] for axis in "xyz"]
            theirs = [value * clip["unit_m"] for value in joint.PositionWorld]
            off = max(abs(a - b) for a, b in zip(ours, theirs))
            allowed = max(TOLERANCE_M, 1e-5 * max(map(abs, ours)))
            if off > allowed:
                sys.exit(f"{file.name}: frame {frame}, joint {joint.Name}: bvhio {theirs}, ours {ours}")
            worst = max(worst, off)
    if len(compared) < 10:
        sys.exit(f"{file.name}: only {len(compared)} joints in common: {sorted(compared)}")
    print(f"{file.name}: {len(frames)} frames, {len(compared)} joints, within {worst * 1000:.4f} mm")


def main(corpus, folder, least=1):
    clips = polars.read_parquet(f"{corpus}/clips.parquet")
    files = sorted(Path(folder).rglob("*.bvh"))
    if len(files) < int(least):
        sys.exit(f"{folder}: {len(files)} BVH files, expected {least}")
    for file in files:
        compare(corpus, clips, file)


if __name__ == "__main__":
    main(*sys.argv[1:])
