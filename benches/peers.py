#!/usr/bin/env python3
"""The problem of the case `gaussian` in other tools: error against time, into one JSON file.

A 50 m cube with zero flux walls, D = 15/year, an amount of 1000 at the centre, 2 years. The tools:

    scipy       explicit Euler with scipy's CSR product of the moment-corrected SPH matrix (cubic
                spline, H = 2 spacings), f32 and f64, at the step of the case: spacing^2 / 18 D
    scikit-fem  trilinear elements, BDF2, conjugate gradients
    fipy        finite volumes, implicit Euler and Crank-Nicolson, conjugate gradients
    dct         scipy's cosine transform, exact in time; it needs a box and a constant D

Errors are relative L2 norms over the particles, nodes or cells against a point source of the whole
amount at the centre, with its mirror images. Particles and cells start with the amount shared by
the ones nearest to the centre (8, or 1 for an odd size); finite elements take the point load.

Set-up (mesh, matrix, initial values) and solve are timed apart, imports and the error are not
timed, and every round runs everything once: all times of all rounds are kept. FiPy makes much of
its mesh in the first step, so that its solve has a part of its set-up. A tool that is not installed
is left out, with a line on stderr that says so.

    pip install numpy scipy scikit-fem fipy
    python benches/peers.py [--tools scipy dct] [--sizes 16 32] [--repeat 3] [--quick] [--out FILE]
    diffusph study gaussian --with peers.json
"""

import argparse
import json
import math
import os
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from importlib import metadata, util
from typing import Any

# On short vectors a second BLAS thread costs more than it saves, many times so on a busy machine.
os.environ.setdefault("OMP_NUM_THREADS", "1")
try:
    import numpy as np
    import scipy.fft
    import scipy.sparse as sp
    from scipy.sparse.linalg import cg
except ImportError as missing:
    sys.exit(f"{missing}; every tool here needs both: pip install numpy scipy")

SIDE = 50.0  # m
AMOUNT = 1000.0
YEAR = 31_536_000.0  # s
DIFFUSIVITY = 15.0 / YEAR  # m2/s
END = 2.0 * YEAR  # s
IMPLICIT_RESIDUAL = 1e-6  # relative, of conjugate gradients
# Added to every value, lost in all that count: without it f32 goes through subnormal numbers ahead
# of the front, and its products take up to ten times as long there.
FLOOR = 1e-30


@dataclass
class Peer:
    """A tool at one size: how to make its set-up, how to solve with it, and what came of it."""

    tool: str
    setting: str
    unknowns: int
    # () -> anything that solve needs
    setup: Callable[[], Any]
    # what setup made -> (values, x, y, z), the positions broadcast against the values
    solve: Callable[[Any], tuple]
    setup_s: list = field(default_factory=list)
    solve_s: list = field(default_factory=list)
    l2_relative: float = math.nan

    def measure(self):
        """One more set-up and solve."""
        start = time.perf_counter()
        made = self.setup()
        ready = time.perf_counter()
        result = self.solve(made)
        self.solve_s.append(time.perf_counter() - ready)
        self.setup_s.append(ready - start)
        self.l2_relative = relative_l2(*result)


def exact(x, y, z):
    """The point source at the centre with its mirror images: a product of one factor an axis."""

    def along(position):
        spread = 4.0 * DIFFUSIVITY * END
        images = sum(np.exp(-((position - (0.5 + n) * SIDE) ** 2) / spread) for n in range(-4, 5))
        return images / math.sqrt(math.pi * spread)

    return AMOUNT * along(x) * along(y) * along(z)


def relative_l2(values, x, y, z):
    """Error over the norm of the exact solution, in f64."""
    expected = exact(x, y, z)
    return float(np.linalg.norm(values - expected) / np.linalg.norm(expected))


def cell_centres(size):
    """Centres of the cells along x, y and z, to be broadcast."""
    axis = (np.arange(size) + 0.5) * (SIDE / size)
    return axis[:, None, None], axis[None, :, None], axis[None, None, :]


def deposit(size):
    """The amount on the cells nearest to the centre, of a lattice [x, y, z]."""
    values = np.zeros((size, size, size))
    nearest = slice((size - 1) // 2, size // 2 + 1)
    values[nearest, nearest, nearest] = 1.0
    return values * (AMOUNT / (values.sum() * (SIDE / size) ** 3))


def sph_matrix(size):
    """The moment-corrected operator of the free lattice, 1/s."""
    spacing = SIDE / size

    def weight(axes):
        """Of a neighbour one spacing away along so many axes, up to the moment."""
        s = math.sqrt(axes)
        return 12.0 - 9.0 * s if s <= 1.0 else 3.0 * (2.0 - s) ** 2 / s

    # Neighbours in the interior: 6, 12 and 8. Of |x|^2 / 2 the operator has to give 3 D.
    moment = sum(count * axes * weight(axes) for axes, count in ((1, 6), (2, 12), (3, 8)))
    scale = 6.0 * DIFFUSIVITY / (moment * spacing**2)
    # The product of three line neighbourhoods, each 1 at a particle and 2 at its neighbours, is
    # 2^axes at each of the 26 neighbours on the lattice.
    line = sp.diags_array([2, 1, 2], offsets=[-1, 0, 1], shape=(size, size), dtype=np.int8)
    pattern = sp.kron(sp.kron(line, line), line, format="csr")
    weights = np.zeros(9)
    weights[[2, 4, 8]] = [scale * weight(axes) for axes in (1, 2, 3)]
    matrix = sp.csr_array((weights[pattern.data], pattern.indices, pattern.indptr), pattern.shape)
    matrix.setdiag(-matrix.sum(axis=1))
    return matrix


def scipy_peers(size):
    """Explicit Euler, one product with I + dt A a step. Fewer steps are stable, down to a quarter,
    and cost more for the same error: part of Euler's error cancels against that of the spacing."""
    steps = math.ceil(18.0 * DIFFUSIVITY * END / (SIDE / size) ** 2 - 1e-9)

    def setup(dtype):
        step = sph_matrix(size) * (END / steps)
        step.setdiag(1.0 + step.diagonal())
        return step.astype(dtype), (deposit(size).ravel() + FLOOR).astype(dtype)

    def solve(made):
        step, values = made
        for _ in range(steps):
            values = step @ values
        return values.reshape(size, size, size), *cell_centres(size)

    setting = f"{size}^3, {steps} steps"
    for name, dtype in (("f32", np.float32), ("f64", np.float64)):
        yield Peer(f"scipy CSR Euler {name}", setting, size**3, partial(setup, dtype), solve)


def scikit_fem_peers(size):
    """Trilinear elements, BDF2 after one step of implicit Euler, conjugate gradients that start
    from the step before. The point load is M c at the start: c itself is never needed."""
    import skfem
    from skfem.models.poisson import laplace, mass

    steps = 5 * size // 4
    dt = END / steps

    def solver(matrix):
        return partial(conjugate_gradients, matrix, sp.diags_array(1.0 / matrix.diagonal()))

    def setup():
        axis = np.linspace(0.0, SIDE, size + 1)
        mesh = skfem.MeshHex.init_tensor(axis, axis, axis)
        # Two Gauss points an axis are exact for both matrices.
        basis = skfem.Basis(mesh, skfem.ElementHex1(), intorder=2)
        stiffness = DIFFUSIVITY * laplace.assemble(basis)
        masses = mass.assemble(basis)
        load = AMOUNT * basis.point_source(np.full(3, SIDE / 2.0))
        first = solver(masses + dt * stiffness)
        other = solver(masses + 2.0 / 3.0 * dt * stiffness)
        return basis.doflocs, masses, load, first, other

    def solve(made):
        positions, masses, before, first, other = made
        values = first(before, None)
        for _ in range(steps - 1):
            held = masses @ values
            values = other((4.0 * held - before) / 3.0, values)
            before = held
        return values, *positions

    yield Peer("scikit-fem BDF2", f"{size}^3, {steps} steps", (size + 1) ** 3, setup, solve)


def conjugate_gradients(matrix, preconditioner, load, guess):
    """scipy's, to IMPLICIT_RESIDUAL."""
    values, info = cg(matrix, load, x0=guess, rtol=IMPLICIT_RESIDUAL, M=preconditioner)
    if info != 0:
        raise RuntimeError(f"conjugate gradients did not converge: {info}")
    return values


def fipy_peers(size):
    """Finite volumes on FiPy's scipy solvers (its own default, a direct solver, takes far longer in
    3-D, and its preconditioners cost more than they save here). Crank-Nicolson begins with four
    half steps of implicit Euler, the usual cure for ringing from a rough start."""
    os.environ.setdefault("FIPY_SOLVERS", "scipy")
    import fipy

    def setup():
        spacing = SIDE / size
        mesh = fipy.Grid3D(nx=size, ny=size, nz=size, dx=spacing, dy=spacing, dz=spacing)
        # x runs fastest; the deposit is the same along every axis.
        values = fipy.CellVariable(mesh=mesh, value=deposit(size).ravel())
        return mesh, values, fipy.LinearCGSolver(tolerance=IMPLICIT_RESIDUAL)

    implicit = fipy.TransientTerm() == fipy.DiffusionTerm(coeff=DIFFUSIVITY)
    half = DIFFUSIVITY / 2.0
    centred = fipy.TransientTerm() == fipy.DiffusionTerm(half) + fipy.ExplicitDiffusionTerm(half)

    def solve(schedule, made):
        mesh, values, solver = made
        for equation, steps, dt in schedule:
            for _ in range(steps):
                equation.solve(var=values, dt=dt, solver=solver)
        return np.array(values.value), *mesh.cellCenters.value

    def peer(tool, steps, schedule):
        setting = f"{size}^3, {steps} steps"
        return Peer(tool, setting, size**3, setup, partial(solve, schedule))

    steps = 5 * size // 4
    yield peer("FiPy implicit Euler", steps, [(implicit, steps, END / steps)])
    steps = max(5 * size // 8, 3)
    dt = END / steps
    schedule = [(implicit, 4, dt / 2.0), (centred, steps - 2, dt)]
    yield peer("FiPy Crank-Nicolson", steps, schedule)


def cosine_peers(size):
    """Each cosine of the cells decays at its own rate: one transform there and one back."""

    def setup():
        rate = DIFFUSIVITY * (np.pi * np.arange(size) / SIDE) ** 2
        decay = np.exp(-END * rate)
        return deposit(size), decay[:, None, None] * decay[:, None] * decay

    def solve(made):
        values, decay = made
        waves = scipy.fft.dctn(values, norm="ortho", workers=-1) * decay
        return scipy.fft.idctn(waves, norm="ortho", workers=-1), *cell_centres(size)

    yield Peer("scipy cosine transform f64", f"{size}^3", size**3, setup, solve)


# Name on the command line -> module, package, sizes, and the peers of a size.
TOOLS = {
    "scipy": ("scipy", "scipy", (24, 32, 50, 100), scipy_peers),
    "scikit-fem": ("skfem", "scikit-fem", (16, 32), scikit_fem_peers),
    "fipy": ("fipy", "fipy", (16, 32), fipy_peers),
    "dct": ("scipy", "scipy", (32, 100), cosine_peers),
}
QUICK_SIZE = 32


def machine():
    """Processor, number of cores, and what runs on them."""
    processor = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            names = [line.split(":", 1)[1] for line in lines if line.startswith("model name")]
        processor = names[0].strip() if names else processor
    except OSError:
        pass
    software = f"Python {platform.python_version()}, numpy {np.__version__}"
    return f"{processor}, {os.cpu_count()} cores, {platform.system()}, {software}"


def write(path, runs):
    """All measurements so far, with every raw time."""
    points = [
        {
            "tool": peer.tool,
            "version": version,
            "command": command,
            "setting": peer.setting,
            "particles": peer.unknowns,
            "setup_s": peer.setup_s,
            "solve_s": peer.solve_s,
            "l2_relative": peer.l2_relative,
            "against": "mirrored point source",
        }
        for peer, version, command in runs
        if peer.solve_s
    ]
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"peers_version": 1, "machine": machine(), "points": points}, file, indent=2)
        file.write("\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tools", nargs="+", choices=TOOLS, default=list(TOOLS))
    parser.add_argument("--sizes", nargs="+", type=int, help="cells or particles an axis")
    parser.add_argument("--repeat", type=int, default=3, help="rounds, each of everything once")
    parser.add_argument("--quick", action="store_true", help=f"one round, up to {QUICK_SIZE}^3")
    parser.add_argument("--out", default="peers.json")
    options = parser.parse_args()
    rounds = 1 if options.quick else options.repeat
    runs = []
    for name in options.tools:
        module, package, sizes, peers = TOOLS[name]
        if util.find_spec(module) is None:
            print(f"{name} left out: not installed (pip install {package})", file=sys.stderr)
            continue
        for size in options.sizes or sizes:
            if options.quick and size > QUICK_SIZE:
                continue
            command = f"python benches/peers.py --tools {name} --sizes {size} --repeat {rounds}"
            runs += [(peer, metadata.version(package), command) for peer in peers(size)]
    for number in range(rounds):
        for peer, _, _ in runs:
            peer.measure()
            print(
                f"{number + 1}/{rounds}  {peer.tool:26} {peer.setting:18}"
                f" set-up {peer.setup_s[-1]:7.3f} s, solve {peer.solve_s[-1]:8.3f} s,"
                f" error {100.0 * peer.l2_relative:.3f} %",
                flush=True,
            )
        write(options.out, runs)


if __name__ == "__main__":
    main()
