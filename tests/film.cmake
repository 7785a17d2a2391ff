# Tests of film, and of the image readers and environments that it shares its formats with.
halflight_unit_test(film_film halflight_film)
halflight_unit_test(scene_images halflight_scene halflight_film)
halflight_unit_test(scene_environment halflight_scene halflight_film)
halflight_unit_test(scene_images_faults halflight_scene halflight_film LABELS malformed)
