"""Shortest paths over faces that each have a metric of their own, as under costs."""
