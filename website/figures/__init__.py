"""The figures of the documentation: charts of the tables in `docs`, and drawings."""
