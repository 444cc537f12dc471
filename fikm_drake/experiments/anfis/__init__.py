"""Paper 2, Hassantabar 2021: its figures with numbers (`fikm-drake reproduce anfis`)."""
