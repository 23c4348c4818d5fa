"""Layout of sections on the ground: rasters, building lots, and places for street furniture."""
