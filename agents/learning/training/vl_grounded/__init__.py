"""Training of `vl_grounded`: demonstrations and views of rooms, with things exchanged for others."""
