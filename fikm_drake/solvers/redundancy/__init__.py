"""Redundancy resolution: a joint in the middle of its learned or exact bounds, and the rest verified."""
