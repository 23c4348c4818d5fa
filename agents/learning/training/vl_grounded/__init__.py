"""Training of `vl_grounded`: demonstrations and views of rooms, augmented by exchanging things."""
