"""Instructions: whether generated ones are true, lifelike and needed, and how free ones are read."""
