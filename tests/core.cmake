# Tests of core.
halflight_unit_test(core_random halflight_core)
