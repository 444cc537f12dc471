"""Redundancy resolution: learned bounds of one joint, the rest in closed form, verified and repaired."""
