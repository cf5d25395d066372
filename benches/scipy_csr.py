#!/usr/bin/env python3
"""Both paths of the CPU against scipy's CSR product of the same matrix, in one run.

Builds the plain operator of the case `gaussian` (a 100^3 lattice, 26 neighbours in the interior) as
a scipy CSR matrix in f64 and f32, and times A @ c in turn with explicit Euler steps of
`diffusph run gaussian` on the CPU, by list and by lattice, one thread and all cores, and with copies
of an array in one thread. Medians of several rounds; ratios within one run are what counts on a
shared machine.

    cargo build --release
    pip install numpy scipy
    python benches/scipy_csr.py [--binary target/release/diffusph] [--rounds 5] [--json]
"""

import argparse
import json
import os
import statistics
import subprocess
import time

import numpy as np
import scipy.sparse as sp

SIDE = 100
PRODUCTS = 20


def csr_matrix(dtype):
    """The operator of the free lattice in units of 1/s, rows with their diagonal."""
    spacing, radius = 0.5, 1.0
    n = np.arange(SIDE)
    z, y, x = np.meshgrid(n, n, n, indexing="ij")
    rows, columns, values = [], [], []
    for dz in (-1, 0, 1):
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                distance = spacing * np.sqrt(dx * dx + dy * dy + dz * dz)
                if distance == 0.0 or distance >= radius:
                    continue
                s = 2.0 * distance / radius
                shape = 9.0 * s - 12.0 if s < 1.0 else -3.0 * (2.0 - s) ** 2 / s
                weight = -(spacing**3) * 2.0 * 15.0 / 31_536_000 * 8.0 / np.pi * shape
                inside = np.ones_like(x, dtype=bool)
                for axis, step in ((x, dx), (y, dy), (z, dz)):
                    inside &= (axis + step >= 0) & (axis + step < SIDE)
                row = ((z * SIDE + y) * SIDE + x)[inside]
                rows.append(row)
                columns.append(row + (dz * SIDE + dy) * SIDE + dx)
                values.append(np.full(row.size, weight))
    rows, columns, values = map(np.concatenate, (rows, columns, values))
    off_diagonal = sp.csr_matrix((values, (rows, columns)), shape=(SIDE**3, SIDE**3))
    diagonal = sp.diags(-np.asarray(off_diagonal.sum(axis=1)).ravel())
    matrix = (off_diagonal + diagonal).tocsr().astype(dtype)
    matrix.sort_indices()
    return matrix


def scipy_rate(matrix):
    """Rows a second of the product alone, one thread."""
    state = np.random.default_rng(1).random(SIDE**3).astype(matrix.dtype)
    matrix @ state
    start = time.perf_counter()
    for _ in range(PRODUCTS):
        matrix @ state
    return PRODUCTS * SIDE**3 / (time.perf_counter() - start)


def copy_rate():
    """Values (f64, read and written) a second of a copy, one thread."""
    source = np.ones(8 * SIDE**3)
    target = np.empty_like(source)
    np.copyto(target, source)
    start = time.perf_counter()
    for _ in range(PRODUCTS):
        np.copyto(target, source)
    return PRODUCTS * source.size / (time.perf_counter() - start)


def diffusph_rate(binary, path, threads):
    """Updates a second of whole Euler steps, checks for divergence included."""
    environment = dict(os.environ)
    if threads:
        environment["RAYON_NUM_THREADS"] = str(threads)
    command = [binary, "run", "gaussian", "--backend", "cpu", "--no-output", "--json"]
    steps = 40 if path == "list" else 400
    command += ["--path", path, "--set", "output={}", "--set", f"time.end=29200*{steps}"]
    output = subprocess.run(command, env=environment, capture_output=True, check=True)
    return json.loads(output.stdout)["updates_per_s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binary", default="target/release/diffusph")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    f64, f32 = csr_matrix(np.float64), csr_matrix(np.float32)
    measures = {
        "copy": copy_rate,
        "scipy f64": lambda: scipy_rate(f64),
        "list 1 thread": lambda: diffusph_rate(options.binary, "list", 1),
        "lattice 1 thread": lambda: diffusph_rate(options.binary, "lattice", 1),
        "scipy f32": lambda: scipy_rate(f32),
        "list all cores": lambda: diffusph_rate(options.binary, "list", None),
        "lattice all cores": lambda: diffusph_rate(options.binary, "lattice", None),
    }
    rates = {name: [] for name in measures}
    for _ in range(options.rounds):
        for name, measure in measures.items():
            rates[name].append(measure())
    median = {name: statistics.median(values) for name, values in rates.items()}
    result = {
        "entries_per_row": f64.nnz / SIDE**3,
        "rows_per_s": median,
        "all": rates,
        "over_scipy_f64": {name: rate / median["scipy f64"] for name, rate in median.items()},
        "over_scipy_f32": {name: rate / median["scipy f32"] for name, rate in median.items()},
    }
    if options.json:
        print(json.dumps(result, indent=2))
        return
    for name, value in median.items():
        spread = f"{min(rates[name]) / 1e6:.1f} .. {max(rates[name]) / 1e6:.1f}"
        over = value / median["scipy f64"], value / median["scipy f32"]
        print(
            f"{name:18} {value / 1e6:7.1f} M rows/s  ({spread})"
            f"  {over[0]:6.2f} times scipy f64, {over[1]:6.2f} times f32"
        )


if __name__ == "__main__":
    main()
