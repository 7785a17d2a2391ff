# Tests of raster.
