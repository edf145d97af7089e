"""Skeleton estimation from depth images: segmentation, joint voting by a random forest, and tracking over time."""
