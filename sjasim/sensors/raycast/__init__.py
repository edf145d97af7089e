"""Ray casting against geometric primitives: the depth camera's images and the occlusion of joints.

The kernels are compiled with Numba and exact for planes, spheres, capsules, ellipsoids, cylinders and boxes. The tests
compare them with MuJoCo's own rays, which cost many times as much for a scene of this size.
"""
