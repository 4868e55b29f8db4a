"""A reader for each format of shapes, and the parts that several of them share.

Imports domains and what is below.
"""
