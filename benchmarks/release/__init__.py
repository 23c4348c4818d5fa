"""Benchmarks of people's texts in the city reconstructed from the official release: their truth, and following them."""
