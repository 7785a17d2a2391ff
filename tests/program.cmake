# Tests of program.
