"""Sources: from what a user gives to columns of a right-hand side (kinds, positions, weights).

Imports discretizations, geometry and domains.
"""
