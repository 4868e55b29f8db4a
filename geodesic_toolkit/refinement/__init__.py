"""Instead of the Poisson step: fronts swept over triangles, held to what is possible.

Imports sources, discretizations, geometry and domains; no heat but its order, as an argument.
"""
