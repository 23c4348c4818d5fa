"""Planning of assembly instructions: relations that identify one cell of the room."""
