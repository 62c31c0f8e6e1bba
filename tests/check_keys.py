"""Keys of the rows of others, computed anew from a recording's rays: python3 check_keys.py X.raydump FACTS.json.

FACTS.json has the scene's bounds, the picture's width and height, and the bits of a key. Everything is NumPy in single precision, as plain as docs/keys.md
says it; a Hilbert curve is walked from level to level by its symmetries. Prints how many keys of each method agree.
"""

import json
import pathlib
import sys

import numpy as np

FINEST = 22
F = np.float32


def quantised(value):
    scaled = np.where(value > 0, value * F(1 << FINEST), F(0))
    return np.minimum(scaled, F((1 << FINEST) - 1)).astype(np.int64)


class Rays:
    def __init__(self, rays, paths, facts):
        low, high = np.array(facts["min"], F), np.array(facts["max"], F)
        extent = (high - low).max()
        self.scale = F(1) / extent if extent > 0 else F(1)
        self.sides = (high - low) * self.scale
        self.paths, self.width, self.height = paths, facts["width"], facts["height"]
        self.direction = rays["direction"]
        self.origin = (rays["origin"] - low) * self.scale
        bound = np.minimum(F(min(facts["length"], 1.75)), rays["t_max"] * self.scale)
        self.length = np.maximum(np.minimum(bound, self.exit()), F(0))

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

    def coordinate(self, name):
        """Of 22 bits."""
        axis = "xyz".find(name[-1])
        x, y, z = (self.direction[:, axis] for axis in range(3))
        if name[0] == "o":
            return quantised(self.origin[:, axis])
        if name[0] == "e":
            whole = (self.length * F(1 << 15)).astype(np.int64)
            step = whole * np.trunc(self.direction[:, axis] * F(1 << 15)).astype(np.int64) >> 8
            return np.clip(quantised(self.origin[:, axis]) + step, 0, (1 << FINEST) - 1)
        if name == "pu":
            return quantised(x / (np.abs(z) + F(1)) * F(0.25) + np.where(z < 0, F(0.25), F(0.75)))
        if name == "pv":
            return quantised(y / (np.abs(z) + F(1)) * F(0.5) + F(0.5))
        if name in "uv":
            x, y, z = (axis.astype(np.float64) for axis in (x, y, z))
            whole = np.abs(x) + np.abs(y) + np.abs(z)
            upper, across, sign = (x, y, x) if name == "u" else (y, x, y)
            lower = (1 - np.abs(across / whole)) * np.where(sign > 0, 1, -1)
            return quantised((np.where(z < 0, lower, upper / whole) + 1) / 2)
        if name == "theta":
            turn = np.arctan2(y, x, dtype=np.float64) / (2 * np.pi) + 0.5
            return quantised(np.where((x == 0) & (y == 0), 0.5, turn))
        assert name == "phi", name
        return quantised(np.arccos(np.clip(z, -1, 1), dtype=np.float64) / np.pi)

    def bits(self, names):
        """Bits of coordinates in the order in which they are named, the highest of each first."""
        coordinates = {name: self.coordinate(name) for name in set(names)}
        taken = dict.fromkeys(coordinates, 0)
        for name in names:
            taken[name] += 1
            yield coordinates[name] >> (FINEST - taken[name]) & 1

    def tile(self, across, down):
        """Bits of the number of a path's tile: tiles are laid over the picture in turn, and painted."""
        picture, count = np.zeros((self.height, self.width), np.int64), 0
        for top in range(0, self.height, down):
            for left in range(0, self.width, across):
                picture[top:top + down, left:left + across] = count
                count += 1
        number = picture.reshape(-1)[self.paths]
        for bit in reversed(range(max(count - 1, 0).bit_length())):
            yield number >> bit & 1

    def hilbert(self, names):
        """Bits of the place along the Hilbert curve through coordinates, level by level."""
        coordinates = np.stack([self.coordinate(name) for name in names])
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


O, E = ["ox", "oy", "oz"], ["ex", "ey", "ez"]
METHODS = {
    "paraboloid": lambda rays: rays.bits(O * 4 + (O + ["pu", "pv"]) * 10 + ["ox", "oy"]),
    "hilbert-origin": lambda rays: rays.hilbert(O),
    "hilbert-two-point": lambda rays: rays.hilbert(O + E),
    "two-point-xor": lambda rays: (a ^ b for a, b in zip(rays.bits(O * 22), rays.bits(E * 22))),
    "tiled-octahedron": lambda rays: (*rays.tile(64, 128), *rays.bits(["u", "v"] * 4)),
    "small-tiles": lambda rays: (*rays.tile(7, 10), *rays.bits(["u", "v"] * 4)),
    "grid-spherical": lambda rays: rays.bits(O * 5 + ["theta"] * 4 + ["phi"] * 3),
}


def key_of(bits, key_bits, rays):
    key = np.zeros(rays, np.uint64)
    bits = list(bits)[:key_bits]
    for bit in bits:
        key = key << np.uint64(1) | bit.astype(np.uint64)
    return key << np.uint64(key_bits - len(bits))


def main(folder, facts):
    facts = json.loads(pathlib.Path(facts).read_text())
    compared = dict.fromkeys(METHODS, 0)
    for path in sorted(pathlib.Path(folder).rglob("keys.npy")):
        method, found = path.parent.name, np.load(path)
        queue = path.parent.parent
        rays = Rays(np.load(queue / "rays.npy"), np.load(queue / "path_ids.npy"), facts)
        expected = key_of(METHODS[method](rays), facts["key_bits"], len(found))
        differing = np.flatnonzero(found != expected)
        # Azimuth and polar angle are a polynomial's, the octahedron is in double precision here: a ray on the
        # border of a cell may be in the next one.
        is_rounded = method in ("grid-spherical", "tiled-octahedron", "small-tiles")
        if len(differing) > (len(found) // 1000 if is_rounded else 0):
            at = differing[0]
            keys = f"{int(found[at]):#x}, expected {int(expected[at]):#x}"
            sys.exit(f"{path}: key of ray {at} is {keys}; {len(differing)} keys differ")
        order = np.load(path.parent / "permutation.npy")
        if (order != np.argsort(found, kind="stable")).any():
            sys.exit(f"{path}: the permutation is not that of the keys")
        compared[method] += len(found)
    print(json.dumps(compared))


main(*sys.argv[1:])
