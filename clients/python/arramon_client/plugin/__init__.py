"""Loading of agents, and checked calls of their methods."""
