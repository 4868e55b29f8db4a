"""Tables of numbers as text: points, indices of vertices, masks.

Imports domains and lower layers.
"""
