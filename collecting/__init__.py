"""Collecting instructions from people: they write them, others follow them, and a host reviews them."""
