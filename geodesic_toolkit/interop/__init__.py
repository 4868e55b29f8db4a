"""Shapes of other packages as domains, and errors for objects that are not a shape.

Imports domains and geometry. Third-party packages are recognised without being imported.
"""
