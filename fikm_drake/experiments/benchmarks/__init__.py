"""What `fikm-drake benchmark` runs."""
