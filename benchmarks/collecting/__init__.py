"""A simulated collection of instructions: scripted people in a real browser."""
