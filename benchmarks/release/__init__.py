"""People's texts of the official release, in the city that is rebuilt from them."""
