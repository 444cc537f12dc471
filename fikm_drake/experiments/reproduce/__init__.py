"""What `fikm-drake reproduce` runs."""
