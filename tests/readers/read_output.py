"""Reads a series of outputs with pyvista and with meshio, and prints what each found as JSON.

Usage: read_output.py FOLDER

Numbers are printed as the hexadecimal of their 64 bits, so that a comparison can be exact.
"""

import json
import sys
from pathlib import Path

import meshio
import numpy
import pyvista


def bits(values):
    """Every number of an array, as the hexadecimal of its bits."""
    array = numpy.ascontiguousarray(values)
    assert array.dtype == numpy.float64, f"expected float64, found {array.dtype}"
    return [f"{word:016x}" for word in array.view(numpy.uint64).ravel().tolist()]


def by_pyvista(mesh):
    return {
        "positions": bits(mesh.points),
        "fields": {name: bits(mesh.point_data[name]) for name in mesh.point_data},
        "cell_types": [int(kind) for kind in mesh.celltypes],
        "connectivity": mesh.cell_connectivity.tolist(),
    }


def by_meshio(mesh):
    # VTK's number for meshio's name; the test expects VERTEX alone.
    number = {"vertex": 1}
    kinds = [number.get(block.type, block.type) for block in mesh.cells for _ in block.data]
    return {
        "positions": bits(mesh.points),
        "fields": {name: bits(values) for name, values in mesh.point_data.items()},
        "cell_types": kinds,
        "connectivity": [int(i) for block in mesh.cells for i in block.data.ravel()],
    }


def main(folder):
    reader = pyvista.get_reader(str(folder / "series.pvd"))
    files = sorted(folder.glob("particles_*.vtu"))
    through_series = []
    for index in range(len(reader.time_values)):
        reader.set_active_time_point(index)
        through_series.append(by_pyvista(reader.read()[0]))
    result = {
        "times": bits(numpy.array(reader.time_values, dtype=numpy.float64)),
        "files": [file.name for file in files],
        "pyvista": through_series,
        "meshio": [by_meshio(meshio.read(file)) for file in files],
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
