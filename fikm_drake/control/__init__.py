"""One control cycle as pure functions."""
