"""Tables of the texts, their verifications and reviews."""
