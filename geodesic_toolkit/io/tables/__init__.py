"""Tables of numbers as text: points, indices of vertices, masks.

Imports domains and what is below.
"""
