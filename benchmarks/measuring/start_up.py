"""A fresh process: what its import and its first call cost. Prints one line of JSON.

python -m measuring.start_up LIBRARY MESH.npz
"""

import importlib
import json
import sys
import warnings

from measuring.clocks import timed


def main() -> None:
    """Measure the imports, of the package and of numpy if that left it, then the first distance."""
    library, mesh = sys.argv[1:]
    warnings.simplefilter("ignore")
    package = PACKAGES[library.partition(",")[0]]
    alone, _ = timed(lambda: importlib.import_module(package))
    arrays_too, _ = timed(lambda: importlib.import_module("numpy"))
    import numpy as np

    from measuring import libraries

    with np.load(mesh) as file:
        arrays = file["vertices"], file["faces"]
    first, _ = timed(lambda: libraries.build(library, *arrays).one(0))
    second, _ = timed(lambda: libraries.build(library, *arrays).one(0))
    imports = {clock: alone[clock] + arrays_too[clock] for clock in alone}
    print(json.dumps({"alone": alone, "import": imports, "first": first, "second": second}))


PACKAGES = {"ours": "geodesic_toolkit", "potpourri3d": "potpourri3d", "libigl": "igl"}

if __name__ == "__main__":
    main()
