"""Isolines of fields on meshes, what they measure and enclose, and discs that they cut out.

Imports solvers and what is below; not paths but for points that become vertices.
"""
