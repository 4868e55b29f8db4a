"""Helpers of every layer: types, frozen arrays, checks, warnings, atomic files.

Imports nothing of the package but ``errors`` and the compiled kernels.
"""
