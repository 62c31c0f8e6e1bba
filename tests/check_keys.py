"""Keys, permutations and length tables of a recording, computed anew:

    inspector info X.raydump --json > x.json
    python3 check_keys.py X.raydump x.json

All of it is NumPy, as plain as docs/keys.md says it; layouts are spelled out. Prints how many keys of each method and
how many length tables agree and which methods have no layout here, or ends with the first that does not agree.
"""

import json
import pathlib
import sys

import numpy as np

FINEST = 22
F = np.float32
# Made of sines, arcs and square roots, here in double precision: a ray on the border of a cell may be in the next one.
ROUNDED = {"theta", "phi", "u", "v", "lu", "lv", "lr"}


def quantised(value):
    scaled = np.where(value > 0, value * F(1 << FINEST), F(0))
    return np.minimum(scaled, F((1 << FINEST) - 1)).astype(np.int64)


def octahedral(direction):
    x, y, z = direction
    whole = np.abs(x) + np.abs(y) + np.abs(z)
    with np.errstate(invalid="ignore"):
        x, y = x / whole, y / whole
    far = (1 - np.abs(y)) * np.where(x > 0, 1, -1), (1 - np.abs(x)) * np.where(y > 0, 1, -1)
    return [np.where(whole == 0, 0.5, (np.where(z < 0, lower, upper) + 1) / 2) for upper, lower in zip((x, y), far)]


class Rays:
    """The rays of a queue; `length` is what a method takes them to have, in unit lengths."""

    def __init__(self, folder, facts):
        self.folder, self.facts = folder, facts
        scene, self.picture = facts["scene"], facts["options"]
        low, high = np.array(scene["bounds_min"], F), np.array(scene["bounds_max"], F)
        extent = (high - low).max()
        self.scale = F(1) / extent if extent > 0 else F(1)
        self.sides = (high - low) * self.scale
        rays = self.array("rays")
        self.t_max, self.direction = rays["t_max"] * self.scale, rays["direction"]
        self.origin = (rays["origin"] - low) * self.scale
        self.length = F(self.picture["two_point_length"])

    def array(self, name):
        return np.load(self.folder / f"{name}.npy")

    def exit(self):
        near, far = np.zeros(len(self.origin), F), np.full(len(self.origin), np.inf, F)
        outside = np.zeros(len(self.origin), bool)
        for axis in range(3):
            origin, direction, side = self.origin[:, axis], self.direction[:, axis], self.sides[axis]
            flat = direction == 0
            outside |= flat & ((origin < 0) | (origin > side))
            with np.errstate(divide="ignore", invalid="ignore"):
                one, other = (F(0) - origin) / direction, (side - origin) / direction
            near = np.where(flat, near, np.maximum(near, np.minimum(one, other)))
            far = np.where(flat, far, np.minimum(far, np.maximum(one, other)))
        return np.where(outside | (far < near), F(0), far)

    def traced_length(self):
        if self.folder.name == "shadow":
            return np.minimum(np.minimum(self.array("distances") * self.scale, self.t_max), self.exit())
        hits = self.array("hits")
        return np.where(hits["triangle"] == 0xFFFFFFFF, self.exit(), hits["t"] * self.scale)

    def from_light(self):
        """Two directions and a distance from each ray's light."""
        origin, direction = self.origin.astype(np.float64).T, self.direction.astype(np.float64).T
        lights, seen = self.array("lights"), np.zeros((3, len(self.origin)))
        for number, site in enumerate(self.facts["scene"]["light_sites"]):
            if site == "environment":
                found = [*octahedral(direction), np.zeros(len(lights))]
            elif "placed" in site:
                away = origin - np.array(site["placed"]["centre"])[:, None]
                found = [*octahedral(away), np.sqrt((away * away).sum(0) / 3)]
            else:
                axes = (site["directional"][name] for name in ("tangent", "bitangent", "direction"))
                found = [(np.array(axis) @ origin / np.sqrt(3) + 1) / 2 for axis in axes]
            seen = np.where(lights == number, found, seen)
        return seen

    def tile(self, across, down):
        """The number of each path's tile: tiles are laid over the picture in turn, and painted."""
        width, height = self.picture["width"], self.picture["height"]
        painted, count = np.zeros((height, width), np.int64), 0
        for top in range(0, height, down):
            for left in range(0, width, across):
                painted[top:top + down, left:left + across] = count
                count += 1
        return painted.reshape(-1)[self.array("path_ids")], max(count - 1, 0).bit_length()

    def coordinate(self, name):
        """Whole numbers, and how many bits they have."""
        if name == "light":
            return self.array("lights").astype(np.int64), self.light_bits()
        if name.startswith("tile"):
            return self.tile(*map(int, name.split()[1:]))
        axis = "xyz".find(name[-1])
        x, y, z = self.direction.T
        if name[0] == "o":
            value = self.origin[:, axis]
        elif name[0] == "d":
            value = (self.direction[:, axis] + F(1)) / F(2)
        elif name[0] == "e":
            bound = np.minimum(np.minimum(self.length, F(1.75)), np.minimum(self.t_max, self.exit()))
            whole = (np.maximum(bound, F(0)) * F(1 << 15)).astype(np.int64)
            step = whole * np.trunc(self.direction[:, axis] * F(1 << 15)).astype(np.int64) >> 8
            return np.clip(quantised(self.origin[:, axis]) + step, 0, (1 << FINEST) - 1), FINEST
        elif name == "pu":
            value = x / (np.abs(z) + F(1)) * F(0.25) + np.where(z < 0, F(0.25), F(0.75))
        elif name == "pv":
            value = y / (np.abs(z) + F(1)) * F(0.5) + F(0.5)
        elif name in ("u", "v"):
            value = octahedral(self.direction.astype(np.float64).T)["uv".find(name)]
        elif name in ("lu", "lv", "lr"):
            value = self.from_light()["uvr".find(name[1])]
        elif name == "theta":
            turn = np.arctan2(y, x, dtype=np.float64) / (2 * np.pi) + 0.5
            value = np.where((x == 0) & (y == 0), 0.5, turn)
        else:
            value = np.arccos(np.clip(z, -1, 1), dtype=np.float64) / np.pi
        return quantised(value), FINEST

    def light_bits(self):
        return max(len(self.facts["scene"]["light_sites"]) - 1, 0).bit_length()

    def bits(self, names):
        """Bits of coordinates in the order in which they are named, the highest of each first."""
        coordinates = {name: self.coordinate(name) for name in set(names)}
        taken = dict.fromkeys(coordinates, 0)
        for name in names:
            taken[name] += 1
            number, width = coordinates[name]
            yield number >> (width - taken[name]) & 1

    def hilbert(self, names):
        """Bits of the place along the Hilbert curve through coordinates, level by level."""
        coordinates = np.stack([self.coordinate(name)[0] for name in names])
        rays, axes = coordinates.shape[1], len(names)
        every = np.arange(rays)
        # What of the cell's axes is seen as which one, and whether mirrored.
        axis_of, mirrored = np.tile(np.arange(axes)[:, None], rays), np.zeros((axes, rays), np.int64)
        is_reversed = np.zeros(rays, np.int64)
        for level in range(1, FINEST + 1):
            bits = coordinates >> (FINEST - level) & 1
            seen = [bits[axis_of[axis], every] ^ mirrored[axis] for axis in range(axes)]
            gray = np.zeros(rays, np.int64)
            for bit in seen:
                gray = gray ^ bit
                yield gray ^ is_reversed
            is_reversed = is_reversed ^ gray
            for axis, bit in enumerate(seen):
                mirrored[0] ^= bit
                if axis:
                    for kept in (axis_of, mirrored):
                        first, other = kept[0].copy(), kept[axis].copy()
                        kept[0], kept[axis] = np.where(bit == 1, first, other), np.where(bit == 1, other, first)


O, D, E = ["ox", "oy", "oz"], ["dx", "dy", "dz"], ["ex", "ey", "ez"]
TWO_POINT = (O + E) * 10 + O + ["ex"]
# Bits of coordinates, the highest first; "light" once stands for all its bits, "tile ACROSS DOWN" too.
LAYOUTS = {
    "origin": O * 22,
    "reis": O * 7 + ["ox"] + ["theta", "phi"] * 21,
    "costa": ["theta", "phi"] * 4 + O * 15 + ["theta", "phi"] * 5 + ["theta"],
    "aila": O * 3 + (O + D) * 9 + ["ox"],
    "octahedron": O * 4 + (O + ["u", "v"]) * 10 + ["ox", "oy"],
    "two-point": TWO_POINT,
    "two-point-adaptive": TWO_POINT,
    "two-point-real": TWO_POINT,
    "light-octahedron": ["light"] + ["lu", "lv"] * 8 + ["lu", "lv", "lr"] * 14 + O * 22,
    "origin-light": O * 3 + ["light"] + O * 19,
    "paraboloid": O * 4 + (O + ["pu", "pv"]) * 10 + ["ox", "oy"],
    "grid-spherical": O * 5 + ["theta"] * 4 + ["phi"] * 3,
    "tiled-octahedron": ["tile 64 128"] + ["u", "v"] * 4,
    "small-tiles": ["tile 7 10"] + ["u", "v"] * 4,
}
CURVES = {
    "hilbert-origin": lambda rays: rays.hilbert(O),
    "hilbert-two-point": lambda rays: rays.hilbert(O + E),
    "two-point-xor": lambda rays: (a ^ b for a, b in zip(rays.bits(O * 22), rays.bits(E * 22))),
}


def layout(method, rays):
    """Names of the bits of a whole key."""
    whole = {"light": rays.light_bits()}
    whole |= {name: rays.coordinate(name)[1] for name in LAYOUTS[method] if name.startswith("tile")}
    return [name for name in LAYOUTS[method] for _ in range(whole.get(name, 1))][:64]


def number(bits, count, rays):
    """The first so many bits, with zeros for those that are not there."""
    bits = list(bits)[:count]
    result = np.zeros(rays, np.uint64)
    for bit in bits:
        result = result << np.uint64(1) | bit.astype(np.uint64)
    return result << np.uint64(count - len(bits))


def wrong_key(keys, key_bits, method, rays):
    """What is wrong with the first key that is, or None."""
    keys = keys.astype(np.uint64)
    if method in CURVES:
        expected = number(CURVES[method](rays), key_bits, len(keys))
        return next((f"ray {at} has {keys[at]:#x}, expected {expected[at]:#x}" for at in np.flatnonzero(keys != expected)), None)
    names = layout(method, rays)[:key_bits]
    places = {name: [key_bits - 1 - at for at, other in enumerate(names) if other == name] for name in set(names)}
    used = sum(1 << place for some in places.values() for place in some)
    for at in np.flatnonzero(keys & ~np.uint64(used)):
        return f"ray {at} has {keys[at]:#x}, with bits that no coordinate has"
    for name, some in places.items():
        found = number((keys >> np.uint64(place) & np.uint64(1) for place in some), len(some), len(keys)).astype(np.int64)
        coordinate, width = rays.coordinate(name)
        expected = coordinate >> (width - len(some))
        apart = np.abs(found - expected)
        if name == "theta":  # A circle: its first and last cell are neighbours.
            apart = np.minimum(apart, (1 << len(some)) - apart)
        for at in np.flatnonzero(apart > (name in ROUNDED)):
            return f"ray {at} has {name} {found[at]} of {len(some)} bits in {keys[at]:#x}, expected {expected[at]}"
    return None


class Table:
    """A length table: counts and sums by cell."""

    def __init__(self, cells, bits):
        # A cell begins with a dummy of length 0.25.
        self.counts, self.sums = np.ones(1 << bits, np.uint64), np.full(1 << bits, 1 << 22, np.uint64)
        self.counts[cells["cell"]], self.sums[cells["cell"]] = cells["count"], cells["sum"]

    def means(self, cells):
        return (self.sums[cells] // self.counts[cells] >> np.uint64(1)).astype(F) / F(1 << 23)

    def add(self, cells, lengths):
        np.add.at(self.counts, cells, np.uint64(1))
        np.add.at(self.sums, cells, np.floor(np.minimum(lengths, 2).astype(np.float64) * (1 << 24)).astype(np.uint64))

    def __eq__(self, other):
        return (self.counts == other.counts).all() and (self.sums == other.sums).all()


def main(folder, facts):
    facts = json.loads(pathlib.Path(facts).read_text())
    options, compared, tables = facts["options"], {"tables": 0, "left out": []}, {}
    for queue in facts["queues"]:
        path = pathlib.Path(folder, f"pass-{queue['pass']:03}", f"bounce-{queue['bounce']:02}", queue["kind"])
        if not (path / "rays.npy").exists():
            continue
        rays = Rays(path, facts)
        estimates = {}
        if (path / "lengths.npy").exists():
            bits = options["table_bits"]
            cells = number(rays.bits(LAYOUTS[options["table_method"]]), bits, len(rays.origin)).astype(np.int64)
            table, traced = Table(rays.array("lengths"), bits), rays.traced_length()
            estimates = {"two-point-adaptive": table.means(cells), "two-point-real": traced}
            # What the queue before left, if that is the one before in the recording.
            before, left = tables.pop(queue["kind"], (None, None))
            if before == (queue["pass"], queue["bounce"] - 1):
                compared["tables"] += 1
                if table != left:
                    sys.exit(f"{path}: the table is not what the queue before left")
            table.add(cells, traced)
            if (path / "final-lengths.npy").exists():
                compared["tables"] += 1
                if table != Table(rays.array("final-lengths"), bits):
                    sys.exit(f"{path}: the last table is not what this queue left")
            tables[queue["kind"]] = (queue["pass"], queue["bounce"]), table
        for method in queue["methods"]:
            if not (path / method / "keys.npy").exists():
                continue
            if method not in LAYOUTS | CURVES:
                compared["left out"] = sorted({*compared["left out"], method})
                continue
            keys, order = np.load(path / method / "keys.npy"), np.load(path / method / "permutation.npy")
            rays.length = estimates.get(method, F(options["two_point_length"]))
            wrong = wrong_key(keys, options["key_bits"], method, rays)
            if wrong:
                sys.exit(f"{path}: {method}: {wrong}")
            if (order != np.argsort(keys, kind="stable")).any():
                sys.exit(f"{path}: the permutation of {method} is not that of its keys")
            compared[method] = compared.get(method, 0) + len(keys)
    print(json.dumps(compared))


main(*sys.argv[1:])
