"""The statistical second check of instructions."""
