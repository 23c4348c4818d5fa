"""Stage 2: people follow a collected text in the world, and flag what is wrong with it."""
