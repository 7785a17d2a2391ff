# Tests of scene.
halflight_unit_test(scene_brdf halflight_scene)
halflight_unit_test(scene_shading halflight_scene)
halflight_unit_test(scene_camera halflight_scene)
halflight_unit_test(scene_framing halflight_scene)
