"""Tables of distances among many sources: in memory, on disk, on several workers.

Imports solvers and what is below; not the paths.
"""
