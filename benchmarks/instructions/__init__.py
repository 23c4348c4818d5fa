"""Instructions: are generated ones true, like people's and needed, and how well are free texts read?"""
