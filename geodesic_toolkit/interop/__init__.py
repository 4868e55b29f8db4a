"""Shapes of other packages, taken as domains; and what is said of those that cannot be.

Imports domains and geometry. Third-party packages are recognised without being imported.
"""
