"""Writes queues of rays as `recorder import --queues FOLDER` reads them; README.md beside this file says
what is what. A queue is named by its bounce and its kind, "closest" or "shadow"; arrays have an entry for each
of its rays, in the order of their path indices."""

from pathlib import Path

import numpy as np

HIT = np.dtype([("t", "<f4"), ("triangle", "<u4"), ("u", "<f4"), ("v", "<f4")])


class Capture:
    """A folder of queues."""

    def __init__(self, folder):
        self.folder = Path(folder)

    def _save(self, bounce, kind, name, array, dtype, columns=()):
        if kind not in ("closest", "shadow"):
            raise ValueError(f"the kind of a queue is closest or shadow, not {kind!r}")
        array = np.ascontiguousarray(array, dtype)
        if array.shape[1:] != columns:
            raise ValueError(f"{name} has shape {array.shape}, expected (N, {columns})")
        path = self.folder / f"bounce-{bounce:02}" / kind / f"{name}.npy"
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, array)

    def rays(self, bounce, kind, origins, directions, t_min=0.0, t_max=np.inf):
        """World space; t_min and t_max, one for all or one for each, count in lengths of the direction."""
        rows = np.empty((len(origins), 8), "<f4")
        rows[:, 0:3], rows[:, 3], rows[:, 4:7], rows[:, 7] = origins, t_min, directions, t_max
        self._save(bounce, kind, "rays", rows, "<f4", (8,))

    def path_ids(self, bounce, kind, ids):
        """Ascending, y * width + x of each path's pixel; 0 to N - 1 if not written."""
        self._save(bounce, kind, "path_ids", ids, "<u4")

    def hits(self, bounce, t, triangle, u, v):
        """Of closest rays; a ray that hits nothing has t inf, triangle 0xFFFFFFFF, u 0, v 0."""
        hits = np.empty(len(t), HIT)
        hits["t"], hits["triangle"], hits["u"], hits["v"] = t, triangle, u, v
        self._save(bounce, "closest", "hits", hits, HIT)

    def distances(self, bounce, distances):
        """Of shadow rays to any occluder between t_min and t_max; inf where the light is seen."""
        self._save(bounce, "shadow", "distances", distances, "<f4")

    def lights(self, bounce, lights):
        """Index of each shadow ray's light, as the scene numbers them."""
        self._save(bounce, "shadow", "lights", lights, "<u4")

    def order(self, bounce, kind, name, permutation, keys=None):
        """An order of yours: the index of the ray at each place, and the key of each ray, uint32 or uint64."""
        self._save(bounce, kind, f"{name}/permutation", permutation, "<u4")
        if keys is not None:
            self._save(bounce, kind, f"{name}/keys", keys, "<u8" if keys.dtype.itemsize > 4 else "<u4")

    def claim(self, name, layout, bits):
        """Says what the keys of an order are, as `recorder --method` takes layouts; verify holds them to it."""
        with open(self.folder / "orders.txt", "a", encoding="utf-8") as file:
            file.write(f"{name} = {layout} @ {bits}\n")
