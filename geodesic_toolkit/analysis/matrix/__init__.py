"""Matrices of distances among many sources: in memory, on disk, with several workers.

Imports solvers and lower layers, but not the paths.
"""
