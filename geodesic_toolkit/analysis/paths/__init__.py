"""Shortest paths on meshes and clouds: descent on distances, then straightening.

Imports solvers and lower layers, but not the matrix.
"""
