"""The fast camera: a software rasteriser compiled with numba."""
