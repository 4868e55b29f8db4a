"""Skip the examples in docstrings where petsc4py is not installed."""

import importlib.util

collect_ignore_glob = [] if importlib.util.find_spec("petsc4py") else ["src/*"]
