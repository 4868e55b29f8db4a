"""Isolines of fields on meshes, their lengths and areas, and discs that they cut out.

Imports solvers and lower layers; of paths only the insertion of points as vertices.
"""
