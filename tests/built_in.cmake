# Tests of the built-in scenes, their toolkit and the files around them.
halflight_unit_test(scene_built_in halflight_scene)
halflight_unit_test(scene_built_in_car halflight_scene)
halflight_unit_test(scene_built_in_environments halflight_film)
halflight_unit_test(scene_built_in_files halflight_film)
halflight_unit_test(scene_built_in_lit halflight_session)
halflight_unit_test(scene_built_in_views halflight_scene)

# What the .glb writer makes is also read by a reader that is not ours.
find_package(TinyGLTF REQUIRED)
halflight_unit_test(scene_glb_reader halflight_scene TinyGLTF::TinyGLTF)
