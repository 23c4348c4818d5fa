"""Planning of navigation instructions: which steps are told, by which things and places, under which names."""
