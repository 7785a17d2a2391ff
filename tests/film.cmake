# Tests of film.
