"""Counts as options."""

import argparse


def positive_count(text: str) -> int:
    """An integer of at least 1, for `add_argument`'s `type`."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, got {number}")
    return number
