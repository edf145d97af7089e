"""Rays against geometric primitives, compiled: what a camera sees, and what hides from an eye.

Exact for planes, spheres, capsules, ellipsoids, cylinders and boxes; tests hold them against MuJoCo's own rays, which
cost many times as much for a scene of this size.
"""
