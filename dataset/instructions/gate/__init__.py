"""The gate of generation: every phrase of an instruction is held against the object or place that it stands for."""
