"""Code that the benchmarks of speed and size share: shapes, libraries, processes, the machine."""
