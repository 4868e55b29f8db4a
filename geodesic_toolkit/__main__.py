"""``python -m geodesic_toolkit``: the same program as ``geodesic-toolkit``."""

from geodesic_toolkit.cli import main

__all__: list[str] = []

if __name__ == "__main__":
    main()
