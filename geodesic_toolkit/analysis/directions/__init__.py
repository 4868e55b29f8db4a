"""Directions and what they carry: logarithmic map, parallel transport, extension, means, cells.

Imports solvers and what is below; not the matrix.
"""
