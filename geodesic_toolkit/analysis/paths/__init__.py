"""Shortest paths on meshes and clouds, by descent on distances and straightening.

Imports solvers and what is below; not the matrix.
"""
