#!/usr/bin/env python3
"""The list path against scipy's CSR product of the same matrix, in one run.

Builds the plain operator of the case `gaussian` (a 100^3 lattice, 26 neighbours in the interior) as
a scipy CSR matrix in f64 and f32, and times A @ c in turn with explicit Euler steps of
`diffusph run gaussian` on the CPU, one thread and all cores. Medians of several rounds; ratios
within one run are what counts on a shared machine.

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


def diffusph_rate(binary, threads):
    """Updates a second of whole Euler steps, checks for divergence included."""
    environment = dict(os.environ)
    if threads:
        environment["RAYON_NUM_THREADS"] = str(threads)
    command = [binary, "run", "gaussian", "--backend", "cpu", "--no-output", "--json"]
    command += ["--set", "output={}", "--set", "time.end=29200*40"]
    output = subprocess.run(command, env=environment, capture_output=True, check=True)
    return json.loads(output.stdout)["updates_per_s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binary", default="target/release/diffusph")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    f64, f32 = csr_matrix(np.float64), csr_matrix(np.float32)
    rates = {"scipy f64": [], "scipy f32": [], "diffusph 1 thread": [], "diffusph all cores": []}
    for _ in range(options.rounds):
        rates["scipy f64"].append(scipy_rate(f64))
        rates["diffusph 1 thread"].append(diffusph_rate(options.binary, 1))
        rates["scipy f32"].append(scipy_rate(f32))
        rates["diffusph all cores"].append(diffusph_rate(options.binary, None))
    median = {name: statistics.median(values) for name, values in rates.items()}
    result = {
        "entries_per_row": f64.nnz / SIDE**3,
        "rows_per_s": median,
        "all": rates,
        "ratio_1_thread_to_scipy_f64": median["diffusph 1 thread"] / median["scipy f64"],
        "ratio_all_cores_to_scipy_f64": median["diffusph all cores"] / median["scipy f64"],
    }
    if options.json:
        print(json.dumps(result, indent=2))
        return
    for name, value in median.items():
        spread = f"{min(rates[name]) / 1e6:.1f} .. {max(rates[name]) / 1e6:.1f}"
        print(f"{name:20} {value / 1e6:6.1f} M rows/s  ({spread})")
    print(f"one thread over scipy f64: {result['ratio_1_thread_to_scipy_f64']:.2f}")
    print(f"all cores over scipy f64:  {result['ratio_all_cores_to_scipy_f64']:.2f}")


if __name__ == "__main__":
    main()
