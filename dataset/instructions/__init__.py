"""Planning of instructions: from a ground truth and the landmarks seen along it to a meaning in no language."""
