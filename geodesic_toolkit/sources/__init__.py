"""From what a user says to columns of a right-hand side: kinds, places on the shape, weights.

Imports discretizations, geometry and domains.
"""
