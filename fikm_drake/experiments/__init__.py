"""What the commands `fikm-drake benchmark` and `fikm-drake reproduce` run: papers' results and costs."""
