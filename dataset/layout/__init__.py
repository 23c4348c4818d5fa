"""Ground plans of sections: rasters, building lots, and places for street furniture."""
