"""Random input of fuzz.py: commands, values, expressions and files, and the runs that try them."""
