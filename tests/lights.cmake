# Tests of lights.
