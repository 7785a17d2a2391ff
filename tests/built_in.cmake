# Tests of the built-in scenes, their toolkit and the files around them.
halflight_unit_test(scene_built_in halflight_scene)
halflight_unit_test(scene_built_in_files halflight_scene)
halflight_unit_test(scene_built_in_views halflight_scene)
