# Tests of film.
halflight_unit_test(film_film halflight_film)
