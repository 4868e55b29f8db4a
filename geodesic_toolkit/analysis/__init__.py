"""Analysis of distances: paths, matrices, sampling, residuals, comparisons."""
