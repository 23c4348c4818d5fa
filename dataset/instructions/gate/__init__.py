"""The gate: checks every phrase of a generated instruction against the object or place that it refers to."""
