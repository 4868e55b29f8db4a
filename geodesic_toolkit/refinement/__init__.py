"""Refinement, in place of the Poisson step: fronts swept over triangles, within bounds.

It imports sources, discretizations, geometry and domains; the order of heat is an argument.
"""
