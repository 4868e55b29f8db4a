"""Sources: conversion of the input of a user to columns of a right-hand side.

It imports discretizations, geometry and domains.
"""
