"""Meshes and textures of all objects of a scene."""
