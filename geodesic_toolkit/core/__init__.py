"""Helpers of all layers: types, frozen arrays, checks, warnings, atomic files.

Imports only ``errors`` and the compiled kernels from the package.
"""
