# Tests of core.
halflight_unit_test(core_random halflight_core)
halflight_unit_test(core_parallel halflight_core)
