"""Readers, one for each format of shapes, and helpers of several formats.

Imports domains and lower layers.
"""
