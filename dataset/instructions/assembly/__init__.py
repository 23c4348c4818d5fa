"""Planning of assembly instructions: what tells the one cell of the room that is meant."""
