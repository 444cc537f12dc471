"""A scenario, run in Drake's Simulator, becomes a log; a log becomes metrics, plots and pages."""
