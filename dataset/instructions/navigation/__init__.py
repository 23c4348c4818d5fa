"""Planning of navigation instructions: the choice of steps, of the landmarks they refer to, and of their names."""
