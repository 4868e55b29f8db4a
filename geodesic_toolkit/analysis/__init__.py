"""What can be said about distances once they are there: paths, residuals, comparisons."""
