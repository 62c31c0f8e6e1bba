#!/usr/bin/env python3
"""Computes the metrics of a recording once more, from their definitions and its arrays alone, and compares.

Usage: check_metrics.py X.raydump METRICS.json
METRICS.json is what `inspector info X.raydump --json --metrics` printed. Needs NumPy. Prints how many
numbers were compared; exits with 1 at the first one that differs by more than 1e-5 of itself.
"""

import json
import sys
from pathlib import Path

import numpy as np

TOLERANCE = 1e-5
GROUP = 64
WIDTHS = (8, 32, 64)
MISS = 0xFFFFFFFF
f4 = np.float32


class Comparison:
    """Numbers that were compared, and the first that differs."""

    def __init__(self):
        self.compared = {}

    def __call__(self, what, where, found, expected):
        expected = float(expected)
        if found is None or not abs(found - expected) <= TOLERANCE * max(abs(expected), 1e-12):
            sys.exit(f"{what} of {where}: inspector says {found}, the arrays {expected}")
        self.compared[what] = self.compared.get(what, 0) + 1


def groups(values, width):
    """Consecutive slices of `width` values; the last may be shorter."""
    return [values[first:first + width] for first in range(0, len(values), width)]


def exit_length(origin, direction, sides):
    """Distance to where each ray leaves the scene's box, in single precision as recorders compute it."""
    near = np.zeros(len(origin), f4)
    far = np.full(len(origin), np.inf, f4)
    beside = np.zeros(len(origin), bool)
    for axis in range(3):
        o, d = origin[:, axis], direction[:, axis]
        still = d == 0
        beside |= still & ((o < 0) | (o > sides[axis]))
        with np.errstate(divide="ignore", invalid="ignore"):
            bounds = (f4(0) - o) / d, (sides[axis] - o) / d
        far = np.where(still, far, np.minimum(far, np.maximum(*bounds)))
        near = np.where(still, near, np.maximum(near, np.minimum(*bounds)))
    return np.where(beside | (far < near), f4(0), far)


class Queue:
    """The arrays of a queue."""

    def __init__(self, folder, low, scale, sides):
        self.folder = folder
        rays = np.load(folder / "rays.npy")
        self.count = len(rays)
        self.direction = rays["direction"].astype(float)
        leaves = exit_length((rays["origin"] - low) * scale, rays["direction"], sides)
        if folder.name == "closest":
            hits = np.load(folder / "hits.npy")
            with np.errstate(invalid="ignore"):
                length = np.where(hits["triangle"] == MISS, leaves, hits["t"] * scale)
        else:
            distances = np.load(folder / "distances.npy")
            length = np.minimum(np.minimum(distances * scale, rays["t_max"] * scale), leaves)
        self.length = length.astype(float)
        self.origin = (rays["origin"].astype(float) - low.astype(float)) * float(scale)
        self.end = self.origin + self.length[:, None] * self.direction
        work = np.load(folder / "work.npy")
        self.work = work["nodes"].astype(float) + work["triangles"]

    def order(self, method):
        if method == "unsorted":
            return np.arange(self.count)
        return np.load(self.folder / method / "permutation.npy")


def sphere(points):
    """Centre of the points' bounding box and the largest distance to it."""
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    return centre, np.linalg.norm(points - centre, axis=1).max()


def capsule_area(starts, ends):
    """Area of the convex hull of the spheres around the starts and around the ends."""
    (centre_a, a), (centre_b, b) = sphere(starts), sphere(ends)
    apart = np.linalg.norm(centre_a - centre_b)
    if apart <= abs(a - b):
        return 4 * np.pi * max(a, b) ** 2
    # Two caps and a frustum, by the angle between the axis and the tangents to both spheres.
    sine = (a - b) / apart
    cosine = np.sqrt(1 - sine**2)
    caps = 2 * np.pi * (a * a * (1 + sine) + b * b * (1 - sine))
    slant = apart * cosine
    return caps + np.pi * (a * cosine + b * cosine) * slant


def coherence(queue, order):
    """Mean capsule area and mean direction spread, weighted by rays."""
    area = spread = 0.0
    for group in groups(order, GROUP):
        area += len(group) * capsule_area(queue.origin[group], queue.end[group])
        spread += len(group) - np.linalg.norm(queue.direction[group].sum(axis=0))
    return area / queue.count, spread / queue.count


def lanes(queue, order, width):
    work = queue.work[order]
    return work.sum() / (width * sum(group.max() for group in groups(work, width)))


def ranks(values):
    """Ranks from 1; equal values share the mean of theirs."""
    values = np.asarray(values)
    return [(values < value).sum() + ((values == value).sum() + 1) / 2 for value in values]


def samples_of(order):
    """The times of an order's stages, a sample per round."""
    return {stage["stage"]: np.array(stage["samples_ns"]) for stage in order["stages"]}


def totals(samples, way):
    """What tracing in an order takes, per round: gathered, traced and scattered, or through indices."""
    stages = {"gathered": ("gather", "trace", "scatter"), "indices": ("trace_indirect",)}[way]
    return sum(samples[stage] for stage in ("key", "sort", "accumulate", *stages) if stage in samples)


def check_speedups(compare, where, order, unsorted, medians):
    """Against the samples of the same rounds, and the medians that the manifest's own timings have."""
    samples = samples_of(order)
    for stage, values in samples.items():
        compare("median", f"{stage} of {where}", medians[(*where, stage)], np.median(values))
    if order["method"] in ("unsorted", "two-point-real"):
        assert "missing" in order["trace_speedup"] and "missing" in order["net_speedup"], where
        return
    baseline, net = samples_of(unsorted)["trace"], totals(samples, order["way"])
    compare("trace speedup", where, order["trace_speedup"]["ratio"], np.median(baseline / samples["trace"]))
    compare("net speedup", where, order["net_speedup"]["ratio"], np.median(baseline / net))
    for speedup in (order["trace_speedup"], order["net_speedup"]):
        if speedup["interval"] is not None:
            low, high = speedup["interval"]
            expected = "faster" if low > 1 else "slower" if high < 1 else "no_significant_difference"
            assert low <= high and speedup["verdict"] == expected, where


def check_summaries(compare, recording, summaries):
    """The sums over bounces, round by round, of closest rays without those of the camera."""
    for summary in summaries:
        shadow = summary["rays"] == "shadow"
        baseline, trace, net, areas, known = 0, 0, 0, np.zeros(2), True
        for queue in recording["queues"]:
            if (queue["kind"] == "shadow") != shadow or (queue["bounce"] == 0 and not shadow):
                continue
            orders = {order["method"]: order for order in queue["orders"]}
            order = orders.get(summary["method"])
            if order is None:
                continue
            known &= "ratio" in order["trace_speedup"]
            baseline = baseline + samples_of(orders["unsorted"])["trace"]
            trace = trace + samples_of(order)["trace"]
            net = net + totals(samples_of(order), order["way"])
            areas += [
                orders[name]["coherence"]["mean_capsule_area"] * queue["rays"]
                for name in (summary["method"], "unsorted")
            ]
        compare("capsule_area_ratio", summary["method"], summary["capsule_area_ratio"], areas[0] / areas[1])
        if known:
            for name, times in (("trace_speedup", trace), ("net_speedup", net)):
                found = summary[name]["mean"]
                compare(f"total {name}", summary["method"], found, np.median(baseline / times))


def check_correlations(compare, points, lines):
    for line in lines:
        chosen = [(x, y) for kind, x, y in points if line["kind"] in (None, kind)]
        x, y = map(list, zip(*chosen))
        where = f"{line['of']}, {line['kind']}"
        if "missing" in line["correlation"]:
            assert len(chosen) < 3 or len(set(x)) == 1 or len(set(y)) == 1, where
            continue
        compare("n", where, line["correlation"]["n"], len(chosen))
        compare("Pearson", where, line["correlation"]["pearson"], np.corrcoef(x, y)[0, 1])
        compare("Spearman", where, line["correlation"]["spearman"], np.corrcoef(ranks(x), ranks(y))[0, 1])


def main(folder, metrics_file):
    result = json.loads(Path(metrics_file).read_text())
    metrics, recording = result["metrics"], result["metrics"]["recordings"][0]
    assert metrics["group_width"] == GROUP
    low, high = (np.array(result["scene"][f"bounds_{end}"], f4) for end in ("min", "max"))
    scale = f4(1) / (high - low).max()
    sides = (high - low) * scale
    medians = {
        (line["pass"], line["bounce"], line["kind"], line["method"], line["stage"]): line["median_ns"]
        for line in result["timings"]
    }
    compare, points = Comparison(), []
    for queue_line in recording["queues"]:
        if not queue_line["orders"]:
            continue
        place = queue_line["pass"], queue_line["bounce"], queue_line["kind"]
        unsorted = next(order for order in queue_line["orders"] if order["method"] == "unsorted")
        queue = Queue(Path(folder) / "pass-{:03}/bounce-{:02}/{}".format(*place), low, scale, sides)
        for order_line in queue_line["orders"]:
            method = order_line["method"]
            where, order = (*place, method), queue.order(method)
            area, spread = coherence(queue, order)
            compare("capsule area", where, order_line["coherence"]["mean_capsule_area"], area)
            compare("direction spread", where, order_line["coherence"]["mean_direction_spread"], spread)
            compare("groups", where, order_line["coherence"]["groups"], -(-queue.count // GROUP))
            for line, width in zip(order_line["lanes"], WIDTHS, strict=True):
                assert line["width"] == width
                compare("lane utilisation", where, line["utilisation"], lanes(queue, order, width))
            check_speedups(compare, where, order_line, unsorted, medians)
            if method == "unsorted":
                first = area, medians[(*where, "trace")]
            else:
                points.append((place[2], area / first[0], medians[(*where, "trace")] / first[1]))
    check_summaries(compare, recording, metrics["summaries"])
    check_correlations(compare, points, metrics["correlations"])
    for what in ("capsule area", "lane utilisation", "net speedup", "total net_speedup", "Spearman"):
        assert compare.compared.get(what), f"no {what} was compared"
    print(json.dumps(compare.compared))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
