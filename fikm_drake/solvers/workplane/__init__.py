"""Paper 5: a workplane, its measured table and its inverses."""
