"""Finite element modes of disc and pads; the only room that knows scikit-fem."""
