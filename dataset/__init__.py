"""Offline tools that make and study data sets. The serving process never imports this package."""
