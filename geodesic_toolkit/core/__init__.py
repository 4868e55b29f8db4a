"""What every layer uses: types, frozen arrays, checks, warnings, files that are whole or not there.

Imports nothing of the package but ``errors`` and the compiled kernels.
"""
