"""Runs the queries of docs/queries.md on an export by DuckDB, and holds their answers against the document's and,
where they overlap, against `inspector info --metrics --json`.

Usage: check_queries.py DOCUMENT EXPORT METRICS
A query is a block ```sql whose first line names it; a block ```text after it is its answer, which must be found again
to the letter. Prints a JSON object: how many answers and how many numbers were compared.
"""

import json, os, re, sys

# tests/run installs this one.
DUCKDB = "2.0.0"
try:
    import duckdb
except ImportError:
    sys.exit(f"no DuckDB in {sys.executable}: run tests/run, or pip install duckdb=={DUCKDB} and name its Python by PYTHON")
BLOCK = re.compile(r"```sql\n-- (.*?)\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", re.S)


def shown(relation):
    """Rows as the document has them: names, then values, between bars."""
    cell = lambda value: "" if value is None else str(value)
    rows = [relation.columns] + relation.fetchall()
    return "".join(" | ".join(map(cell, row)) + "\n" for row in rows)


def orders(metrics):
    """Every measured order: (kind, bounce, method) and the numbers of its queue and of itself."""
    for queue in metrics["queues"]:
        for order in queue["orders"]:
            yield (queue["kind"], queue["bounce"], order["method"]), queue, order


def expected(metrics):
    """What `info --metrics` says, by query and row."""
    known = lambda value: not (isinstance(value, dict) and "missing" in value)
    found = {name: {} for name in ("coherence", "lanes", "trace speedup", "whole frame", "estimates")}
    for key, queue, order in orders(metrics):
        found["coherence"][key] = order["coherence"]["mean_capsule_area"]
        found["lanes"][key] = next(lanes["utilisation"] for lanes in order["lanes"] if lanes["width"] == 32)
        if known(order["trace_speedup"]):
            found["trace speedup"][key] = order["trace_speedup"]["ratio"]
        estimator = {"two-point": "constant", "two-point-adaptive": "table"}.get(order["method"])
        if estimator:
            found["estimates"][key] = queue["estimators"][estimator]["mean_absolute"]
    for frame in metrics["frames"]:
        if known(frame["net_speedup"]):
            kind = {"secondary": "closest", "shadow": "shadow"}[frame["rays"]]
            found["whole frame"][(kind, None, frame["method"])] = frame["net_speedup"]["ratio"]
    return found


def compare(name, relation, known):
    """Rows that are keyed by kind, bounce and method and end in the number that `info` gives too."""
    at = [relation.columns.index(column) if column in relation.columns else None
          for column in ("kind", "bounce", "method")]
    rows = {tuple(None if i is None else row[i] for i in at): row[-1] for row in relation.fetchall()}
    assert rows.keys() == known.keys(), f"{name}: rows {sorted(map(str, rows.keys() ^ known.keys()))} on one side alone"
    for key, value in rows.items():
        # DuckDB adds numbers up in an order of its own.
        assert abs(value - known[key]) <= 1e-9 * abs(known[key]), f"{name} of {key}: {value}, `info` has {known[key]}"
    return len(rows)


def main():
    assert duckdb.__version__ == DUCKDB, f"DuckDB {duckdb.__version__}, expected {DUCKDB}: pip install duckdb=={DUCKDB}"
    document, export, metrics = sys.argv[1:]
    blocks = BLOCK.findall(open(document, encoding="utf-8").read())
    known = expected(json.load(open(metrics, encoding="utf-8"))["metrics"]["recordings"][0])
    os.chdir(export)
    connection = duckdb.connect()
    answers = numbers = 0
    for name, query, answer in blocks:
        relation = connection.sql(query)
        if answer:
            found = shown(relation)
            assert found == answer, f"{name}: the document has\n{answer}but the answer is\n{found}"
            answers += 1
        if name in known:
            numbers += compare(name, connection.sql(query), known.pop(name))
    assert not known, f"the document has no query named {', '.join(known)}"
    print(json.dumps({"queries": len(blocks), "answers": answers, "numbers": numbers}))


main()
